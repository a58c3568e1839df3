"""No light through closed walls, however the rays bend (DESIGN section 3, "Hitting geometry on a curve")."""

import numpy as np
import pytest
from support import scenes

import cpm

GRADIENT = (0.9, -1.2, 0.5)


def strong():
    """n² = 3 + g·r: 1.4 to 4.6 over the box, radii of curvature near its size."""
    return cpm.media.LinearSquared(3.0, gradient=GRADIENT)


HEIGHTS = np.linspace(-3, 3, 241)
MEDIA = {
    "linear-squared": strong,
    "layered-cubic": lambda: cpm.media.Layered(
        HEIGHTS, 1.6 - 0.5 * np.tanh(1.5 * HEIGHTS), up=(0.36, 0.8, 0.48), interpolation="cubic"
    ),
    "grid-cubic": lambda: cpm.media.Grid(
        ripples(), origin=(-2, -2, -2), spacing=(0.25, 0.25, 0.25), interpolation="cubic"
    ),
    "grid-linear": lambda: cpm.media.Grid(
        ripples(), origin=(-2, -2, -2), spacing=(0.25, 0.25, 0.25), interpolation="linear"
    ),
}


def ripples():
    """A smooth, strongly varying n on 17³ samples."""
    x = np.linspace(-2, 2, 17)
    x, y, z = np.meshgrid(x, x, x, indexing="ij")
    return 1.5 + 0.25 * np.sin(2.1 * x + 0.4) * np.cos(1.7 * y) + 0.15 * np.sin(1.9 * z - 0.7 * x)


def closed_box(medium, slanted=True):
    """A closed box with a slanted slab that floats in it, a lamp inside, bright walls."""
    scene = cpm.Scene(medium=medium)
    scene.add_mesh(*scenes.box_mesh((-1, -1, -1), (1, 1, 1)), material=cpm.materials.Diffuse(0.7))
    if slanted:
        scene.add_mesh(
            *scenes.rectangle((0.2, -0.4, 0.1), (0.4, 0.2, 0), (0, 0.1, 0.4)), material=cpm.materials.Diffuse(0.5)
        )
    scene.add_light(cpm.lights.Point((-0.3, 0.4, -0.2), 1.0))
    return scene


def nothing_outside(photons, half=1.0):
    """All stored photons within the box, on its walls or the slab, and nothing escaped."""
    r = np.abs(photons.diffuse.position)
    assert len(r) > 0
    assert r.max() <= half + 1e-5, f"a photon at {r.max()} outside ±{half}"
    assert np.all(np.asarray(photons.energy["escaped"]) <= 1e-9 * np.asarray(photons.energy["emitted"]))


@pytest.mark.parametrize(
    ("name", "count"),
    [("layered-cubic", 100_000), ("grid-cubic", 50_000), ("grid-linear", 50_000)],
)
def test_closed_box(name, count):
    nothing_outside(cpm.trace_photons(closed_box(MEDIA[name]()), count, seed=1, wavelengths=[550.0]))


@pytest.mark.parametrize("top", [1.0, 0.5, 0.7])
def test_walls_on_the_faces_of_discrete_layers(top):
    """Rays are thrown back by total reflection at the very face where the wall is: the wall comes first."""
    medium = cpm.media.Layered([-1.0, -0.5, 0.0, 0.5, 1.0], [1.4, 1.3, 1.24, 1.16, 1.1], interpolation="step")
    scene = cpm.Scene(medium=medium)
    scene.add_mesh(*scenes.box_mesh((-1, -1, -1), (1, top, 1)), material=cpm.materials.Diffuse(0.7))
    scene.add_light(cpm.lights.Point((-0.3, 0.2, -0.2), 1.0))
    nothing_outside(cpm.trace_photons(scene, 100_000, seed=1, wavelengths=[550.0]))


def in_parts(name, count):
    """In parts of a million, so that memory stays bounded."""
    scene = closed_box(MEDIA[name]())
    for seed in range(count // 1_000_000):
        nothing_outside(cpm.trace_photons(scene, 1_000_000, seed=100 + seed, wavelengths=[550.0]))


def test_ten_million():
    """A closed box in a strong gradient, 10⁷ photons, none outside."""
    in_parts("linear-squared", 10_000_000)


@pytest.mark.long
@pytest.mark.parametrize(("name", "count"), [("layered-cubic", 2_000_000), ("grid-cubic", 1_000_000)])
def test_closed_box_long(name, count):
    in_parts(name, count)


def test_closed_mesh():
    """1280 triangles, whose shared edges and corners are where leaks hide."""
    scene = cpm.Scene(medium=strong())
    vertices, faces = scenes.icosphere(1.0, 3, inward=True)
    scene.add_mesh(vertices, faces, material=cpm.materials.Diffuse(0.7))
    scene.add_light(cpm.lights.Point((0.1, 0.2, -0.3), 1.0))
    photons = cpm.trace_photons(scene, 200_000, seed=1, wavelengths=[550.0])
    radius = np.linalg.norm(photons.diffuse.position, axis=1)
    assert radius.max() < 1 + 1e-5 and radius.min() > 0.98
    assert np.all(np.asarray(photons.energy["escaped"]) == 0)


def test_exact_sphere():
    """The analytic sphere from inside."""
    scene = cpm.Scene(medium=strong())
    scene.add_sphere((0, 0, 0), 1.0, material=cpm.materials.Diffuse(0.7))
    scene.add_light(cpm.lights.Point((0.1, 0.2, -0.3), 1.0))
    photons = cpm.trace_photons(scene, 100_000, seed=1, wavelengths=[550.0])
    np.testing.assert_allclose(np.linalg.norm(photons.diffuse.position, axis=1), 1.0, rtol=0, atol=2e-6)
    assert np.all(np.asarray(photons.energy["escaped"]) == 0)


def test_rays_aimed_at_corners():
    """`cpm.trace` in the scene, 20 000 rays towards the box's edges and corners: each hits a wall."""
    scene = closed_box(strong(), slanted=False)
    rng = np.random.default_rng(2)
    target = np.sign(rng.uniform(-1, 1, (20_000, 3)))
    target[:, rng.integers(0, 3)] = rng.uniform(-1, 1, 20_000)
    start = rng.uniform(-0.9, 0.9, (20_000, 3))
    rays = cpm.trace(scene, start, target - start, wavelength=550.0)
    assert np.all(rays.status == cpm.RayStatus.HIT)
    np.testing.assert_allclose(np.abs(rays.position).max(axis=1), 1.0, rtol=0, atol=1e-6)


def test_photon_falls_back_on_its_triangle():
    """A floor alone under n² that falls with height: scattered light comes back onto the triangle it left.

    Only the root at σ = 0 is excluded (DESIGN section 4).
    """
    scene = cpm.Scene(medium=cpm.media.LinearSquared(2.0, gradient=(0, -1.0, 0)))
    scene.add_mesh([(-50, 0, -50), (-50, 0, 50), (50, 0, 0)], [(0, 1, 2)], material=cpm.materials.Diffuse(0.9))
    scene.add_light(cpm.lights.Spot((0, 0.5, 0), (0, 0, 0), cutoff=30.0, intensity=1.0))
    photons = cpm.trace_photons(scene, 20_000, seed=1, wavelengths=[550.0])
    # Every ray turns below y = 2 sin²θ … all of them fall back: 20 000 × ρ survive to a second bounce.
    second = np.count_nonzero(photons.diffuse.bounce == 1) / np.count_nonzero(photons.diffuse.bounce == 0)
    assert second == pytest.approx(0.9, abs=0.02)
