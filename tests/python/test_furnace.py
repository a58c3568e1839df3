"""Furnace (DESIGN sections 1 and 13): albedo ½ and basic emission ½ give basic radiance 1 everywhere.

A camera in index n_c then sees n_c² × 1, and a surface in index n_s receives E = π n_s², whatever
n does between.  A missing or doubled n² anywhere shows as a factor of 1.2 to 2.2 here.
"""

import numpy as np
import pytest
from support import scenes

import cpm

NEAREST, PHOTONS = 100, 80_000
GRADIENT = (0.2, -0.4, 0.1)
CAMERA = np.array((0.1, 0.3, 0.2))

#: name → (medium, n²(r)).
HEIGHTS = np.linspace(-2, 2, 161)
MEDIA = {
    "vacuum": (lambda: cpm.media.Homogeneous(1.0), lambda r: np.ones(r.shape[:-1])),
    "homogeneous": (lambda: cpm.media.Homogeneous(1.3), lambda r: np.full(r.shape[:-1], 1.69)),
    "linear-squared": (
        lambda: cpm.media.LinearSquared(1.69, gradient=GRADIENT),
        lambda r: 1.69 + r @ np.array(GRADIENT),
    ),
    "layered-cubic": (
        lambda: cpm.media.Layered(HEIGHTS, 1.3 + 0.2 * np.tanh(HEIGHTS), up=(0, 1, 0), interpolation="cubic"),
        lambda r: (1.3 + 0.2 * np.tanh(r[..., 1])) ** 2,
    ),
}


@pytest.fixture(params=MEDIA)
def case(request):
    make, n_squared = MEDIA[request.param]
    return scenes.furnace(make()), n_squared


def test_radiance(case, picture):
    """Pixels are n_c² within noise, with no trend over the picture."""
    scene, n_squared = case
    image = cpm.render(
        scene,
        size=(40, 30),
        photons=PHOTONS,
        nearest=NEAREST,
        wavelengths=[550.0],
        seed=2,
        max_radius=1.0,
        progress=False,
    )
    basic = image.data[:, :, 0] / n_squared(CAMERA)
    picture("basic", basic)
    assert basic.mean() == pytest.approx(1.0, abs=0.012)
    assert np.max(np.abs(basic - 1)) < 0.5 * 6 / np.sqrt(NEAREST - 2)
    for half in (basic[:15], basic[15:], basic[:, :20], basic[:, 20:]):
        assert half.mean() == pytest.approx(1.0, abs=0.02)


def test_irradiance(case):
    """E = π n_s² on the sphere's inside; direct part π n_s²/2."""
    scene, n_squared = case
    vertices, faces = scenes.icosphere(1.0, 3, inward=True)
    centres = vertices[faces].mean(axis=1)[::4]
    normals = -centres / np.linalg.norm(centres, axis=1, keepdims=True)
    photons = cpm.trace_photons(scene, PHOTONS, seed=3, wavelengths=[550.0])
    found = photons.diffuse.irradiance(centres, normals, nearest=NEAREST)[:, 0] / (np.pi * n_squared(centres))
    assert found.mean() == pytest.approx(1.0, abs=0.012)
    z = (found - 1) * np.sqrt(2 * (NEAREST - 2))  # two searches of equal weight
    assert np.max(np.abs(z)) < 6
    lower, upper = centres[:, 1] < -0.3, centres[:, 1] > 0.3
    assert found[lower].mean() == pytest.approx(found[upper].mean(), abs=0.03)


def test_emitted_power(case):
    """Photon power of an area light in index n: π n² L A, integrated over the mesh."""
    scene, n_squared = case
    vertices, faces = scenes.icosphere(1.0, 3, inward=True)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    expected = (
        np.pi * 0.5 * np.sum(areas * (n_squared((a + b) / 2) + n_squared((b + c) / 2) + n_squared((c + a) / 2)) / 3)
    )
    photons = cpm.trace_photons(scene, PHOTONS, seed=4, wavelengths=[550.0])
    first = photons.diffuse.bounce == 0
    assert photons.diffuse.power[first, 0].sum() == pytest.approx(expected, rel=0.005)
    assert photons.diffuse.power[:, 0].sum() == pytest.approx(2 * expected, rel=0.02)


@pytest.mark.parametrize("albedo", [0.0, 0.9])
def test_other_albedos(albedo):
    """Emission 1 − ρ gives radiance 1 for any ρ."""
    scene = scenes.furnace(cpm.media.Homogeneous(1.3), albedo=albedo, radiance=1 - albedo)
    image = cpm.render(
        scene,
        size=(24, 18),
        photons=40_000,
        nearest=NEAREST,
        wavelengths=[550.0],
        seed=6,
        max_radius=1.0,
        progress=False,
    )
    assert image.data.mean() / 1.69 == pytest.approx(1.0, abs=1e-6 if albedo == 0 else 0.03)


@pytest.mark.parametrize("what", ["glass", "dispersive glass", "mirror", "gradient lens"])
def test_objects_vanish(what):
    """In a furnace nothing can be seen: glass, mirrors and lenses show basic radiance 1 like everything else.

    Snell, Fresnel, total reflection, the caustic map and the n² of radiance must all be right for that.
    """
    materials = {
        "glass": lambda: cpm.materials.Dielectric(1.5),
        "dispersive glass": lambda: cpm.materials.Dielectric(cpm.dispersion.Cauchy(1.5, 0.02)),
        "mirror": lambda: cpm.materials.Mirror(1.0),
        "gradient lens": lambda: cpm.materials.Dielectric(cpm.media.LinearSquared(2.2, gradient=(0.5, -0.8, 0.0))),
    }
    scene = scenes.furnace(cpm.media.Homogeneous(1.2))
    scene.add_sphere((0.35, -0.05, -0.35), 0.3, material=materials[what]())
    image = cpm.render(
        scene,
        size=(40, 30),
        photons=PHOTONS,
        nearest=NEAREST,
        wavelengths=[450.0, 650.0],
        seed=8,
        samples=2,
        max_radius=1.0,
        progress=False,
    )
    basic = image.data / 1.44
    assert basic[8:22, 12:28].mean() == pytest.approx(1.0, abs=0.025)  # the object fills the middle
    for channel in range(2):
        assert basic[..., channel].mean() == pytest.approx(1.0, abs=0.02)


def test_camera_inside_glass():
    """A pinhole in a glass ball sees n_glass² × 1."""
    scene = scenes.furnace(cpm.media.Homogeneous(1.0))
    scene.add_sphere(CAMERA, 0.3, material=cpm.materials.Dielectric(1.5))
    image = cpm.render(
        scene,
        size=(24, 18),
        photons=PHOTONS,
        nearest=NEAREST,
        wavelengths=[550.0],
        seed=9,
        max_radius=1.0,
        progress=False,
    )
    assert image.data.mean() == pytest.approx(2.25, rel=0.025)
