"""Fibre and lenses in scenes: curved hits on exact pieces, bounds of their own, photons and pictures."""

import numpy as np
import pytest
from oracles import central

import cpm

CENTER = (0.3, -0.2, 0.5)
MEDIA = {
    "parabolic": lambda **o: cpm.media.Parabolic(1.5, 0.3, axis=(1, 2, 2), origin=CENTER, **o),
    "luneburg": lambda **o: cpm.media.Luneburg(1.2, CENTER, **o),
    "fisheye": lambda **o: cpm.media.Fisheye(1.7, 1.2, CENTER, **o),
    "eaton": lambda **o: cpm.media.Eaton(1.2, CENTER, **o),
}
RNG = np.random.default_rng(5)


def rays(count, reach=0.7):
    return np.array(CENTER) + RNG.uniform(-reach, reach, (count, 3)), RNG.normal(size=(count, 3))


def target(scene, size=3.0):
    """A closed black box about the centre, far enough that rays bend before they hit it."""
    low, high = np.array(CENTER) - size, np.array(CENTER) + size
    corners = np.array([[(low, high)[(i >> k) & 1][k] for k in range(3)] for i in range(8)])
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    scene.add_mesh(corners, faces, cpm.materials.Black())
    return scene


@pytest.mark.parametrize("kind", MEDIA)
def test_same_path_in_a_scene(kind):
    """A scene's pieces end where the medium alone does, to 1e-12, whatever length is asked, and its samples too."""
    origins, directions = rays(40)
    lengths = RNG.uniform(0.1, 2.5, 40)
    medium = MEDIA[kind]()
    alone = cpm.trace(medium, origins, directions, wavelength=550.0, length=lengths, path=7)
    scene = target(cpm.Scene(medium), 4.0)
    within = cpm.trace(scene, origins, directions, wavelength=550.0, length=lengths, path=7)
    assert np.all(within.method == "exact") and np.all(within.status == alone.status)
    # close to Eaton's centre each piece starts from a rounded place
    impact = np.linalg.norm(np.cross(origins - CENTER, directions), axis=1)
    limit = 1e-12 * (1 + 1e-2 / impact if kind == "eaton" else np.ones(40))
    assert np.max(np.linalg.norm(within.position - alone.position, axis=1) / limit) < 1
    assert np.max(np.linalg.norm(within.direction - alone.direction, axis=1) / limit) < 10
    assert np.max(np.abs(within.optical_path - alone.optical_path) / limit) < 3
    assert np.max(np.linalg.norm(within.paths - alone.paths, axis=2) / limit[:, None]) < 3


@pytest.mark.parametrize("kind", MEDIA)
def test_hits_on_the_curve(kind):
    """Hits on walls: on the path of the oracle, by `exact` and integrated alike."""
    origins, directions = rays(60)
    medium = MEDIA[kind]()
    hits = {}
    for method in ("exact", "dopri5"):
        scene = target(cpm.Scene(medium, method=method, rtol=1e-9), 1.5)
        hits[method] = cpm.trace(scene, origins, directions, wavelength=550.0)
    met = hits["exact"].status == cpm.RayStatus.HIT
    assert np.mean(met) > 0.5
    np.testing.assert_array_equal(met, hits["dopri5"].status == cpm.RayStatus.HIT)
    wall = np.max(np.abs(hits["exact"].position[met] - CENTER), axis=1)
    np.testing.assert_allclose(wall, 1.5, rtol=0, atol=1e-12)
    near = 0.05 if kind == "eaton" else 0.0  # a near miss of the centre is no test of an integrator
    impact = np.linalg.norm(np.cross(origins - CENTER, directions), axis=1) / np.linalg.norm(directions, axis=1)
    far = met & (impact > near)
    assert np.max(np.linalg.norm(hits["exact"].position - hits["dopri5"].position, axis=1)[far]) < 1e-6
    alone = cpm.trace(medium, origins[met], directions[met], wavelength=550.0, length=hits["exact"].length[met])
    assert np.max(np.linalg.norm(alone.position - hits["exact"].position[met], axis=1)) < 1e-11


@pytest.mark.parametrize("kind", ["luneburg", "eaton"])
@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_own_sphere(kind, method):
    """In a scene's list a lens without bounds is its own sphere, and rays pass its surface unbroken: n = 1 there."""
    origins, directions = np.array(CENTER) + RNG.uniform(-2.5, 2.5, (60, 3)), RNG.normal(size=(60, 3))
    directions[:40] = CENTER - origins[:40] + RNG.uniform(-0.8, 0.8, (40, 3))
    scene = target(cpm.Scene(method=method, rtol=1e-9), 3.0)
    scene.add_medium(MEDIA[kind]())
    got = cpm.trace(scene, origins, directions, wavelength=550.0, length=3.0)
    away = got.status == cpm.RayStatus.ARRIVED
    assert np.mean(away) > 0.6
    for i in np.nonzero(away)[0]:
        y = origins[i] - CENTER
        impact = np.linalg.norm(np.cross(y, directions[i])) / np.linalg.norm(directions[i])
        expected = getattr(central, kind)(1.2, CENTER, origins[i], directions[i], length=3.0)
        limit = (1e-12 if method == "auto" else 3e-8) * (1 if kind == "luneburg" else 1 + 0.1 / impact)
        assert np.linalg.norm(got.position[i] - expected.position) < limit, (i, impact)


def test_fibre_in_glass():
    """A fibre bounded by a sphere in n = 1: Snell with the local index on both sides."""
    medium = cpm.media.Parabolic(1.5, 0.5, bounds=cpm.Sphere((0, 0, 0), 1.0))
    scene = target(cpm.Scene(), 3.0)
    scene.add_medium(medium)
    start, d = np.array([0.3, 0.1, -2.0]), np.array([0.0, 0.0, 1.0])
    r = start + (2 - np.sqrt(1 - 0.1)) * d  # on the sphere, ρ² = 0.1
    n = 1.5 * np.sqrt(1 - 0.25 * 0.1)
    cosine = -(d @ r)
    inside = d / n + (cosine / n - np.sqrt(1 - (1 - cosine**2) / n**2)) * r
    curve = central.parabolic_curve(1.5, 0.5, (0, 0, 1), (0, 0, 0), r, inside)
    before = np.linalg.norm(r - start)
    got = cpm.trace(scene, [start], [d], wavelength=550.0, length=before + 0.9)
    expected = curve.ray(curve.x_of_length(0.9))
    np.testing.assert_allclose(got.position[0], expected.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(got.momentum[0], expected.momentum, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", MEDIA)
def test_closed_walls_do_not_leak(kind):
    """From inside a closed box no ray gets out, a centre or not: each hits, or was cut off or captured."""
    origins, directions = rays(3000, 0.9)
    scene = target(cpm.Scene(MEDIA[kind]()), 1.0)
    got = cpm.trace(scene, origins, directions, wavelength=550.0)
    assert np.all(got.status == cpm.RayStatus.HIT)
    np.testing.assert_allclose(np.max(np.abs(got.position - CENTER), axis=1), 1.0, rtol=0, atol=1e-12)


def test_luneburg_picture():
    """A small bright disc at the antipode of a Luneburg lens fills the lens as seen along the axis."""
    scene = cpm.Scene(cpm.media.Luneburg(1.0))
    t = np.linspace(0, 2 * np.pi, 25)[:-1]
    ring = np.stack([0.15 * np.cos(t), 0.15 * np.sin(t), np.full_like(t, 1.02)], axis=1)
    disc = scene.add_mesh(np.vstack([[(0, 0, 1.02)], ring]), [(0, 1 + (i + 1) % 24, 1 + i) for i in range(24)], cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Area(disc, 1.0))
    scene.camera = cpm.Camera.look_at((0, 0, -60), (0, 0, 0), (0, 1, 0), fov=2.4)
    image = cpm.render(scene, size=(48, 48), photons=2000, nearest=20, wavelengths=[550.0], seed=1)
    x, y = np.meshgrid(*[(np.arange(48) + 0.5 - 24) / 24 * 60 * np.tan(np.radians(1.2))] * 2)
    radius = np.hypot(x, y)
    assert np.min(image.data[radius < 0.9, 0]) > 0.5  # the disc's own light, magnified
    assert np.max(image.data[radius > 1.1, 0]) < 1e-6
    assert image.stats["eye_evaluations"] == 0


@pytest.mark.parametrize("kind", ["luneburg", "eaton", "fisheye", "parabolic"])
def test_energy_in_a_box(kind):
    """Photons in a closed black box around the medium: all that is emitted is absorbed."""
    scene = target(cpm.Scene(MEDIA[kind]()), 1.3)
    scene.add_light(cpm.lights.Point(np.array(CENTER) + (0.4, 0.1, -0.2), 1.0))
    energy = cpm.trace_photons(scene, 5000, seed=3, wavelengths=[550.0]).energy
    assert energy["emitted"].sum() > 0
    np.testing.assert_allclose(energy["absorbed"], energy["emitted"], rtol=1e-6)
