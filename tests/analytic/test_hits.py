"""Curved rays on surfaces (DESIGN section 3): triangles and spheres against the roots of the parabola's polynomials."""

import numpy as np
import pytest
from oracles import closed_forms, hits
from support import scenes

import cpm

N2, G = 2.2, np.array((0.3, -0.8, 0.2))
BLACK = cpm.materials.Diffuse(0.0)
METHODS = {"auto": 1e-10, "dopri5": 1e-7, "rk4": 1e-6, "euler": 2e-2}


def scene_with(add, method="auto"):
    rtol = {"dopri5": 1e-9, "auto": None, "rk4": None, "euler": 1e-3}[method]
    scene = cpm.Scene(
        medium=cpm.media.LinearSquared(N2, gradient=G), method=method, rtol=rtol, step=0.02 if method == "rk4" else None
    )
    add(scene)
    return scene


def start(origin, direction):
    """p₀ of a ray."""
    d = np.asarray(direction, float)
    return np.sqrt(N2 + G @ origin) * d / np.linalg.norm(d)


def fan(count, seed=1, reach=0.6):
    rng = np.random.default_rng(seed)
    return rng.uniform(-reach, reach, (count, 3)), rng.normal(size=(count, 3))


def trace(scene, origins, directions, method):
    options = {"euler": {"rtol": 1e-3}, "dopri5": {"rtol": 1e-9}, "rk4": {"step": 0.02}}.get(method, {})
    return cpm.trace(scene, origins, directions, wavelength=550.0, method=method, **options)


@pytest.mark.parametrize("method", METHODS)
def test_box(method):
    """A closed box from inside: point and arc length of the first wall."""
    vertices, faces = scenes.box_mesh((-1, -1, -1), (1, 1, 1))
    scene = scene_with(lambda s: s.add_mesh(vertices, faces, material=BLACK), method)
    origins, directions = fan(200)
    rays = trace(scene, origins, directions, method)
    assert np.all(rays.status == cpm.RayStatus.HIT) and np.all(rays.shape == 0)
    for i, (o, d) in enumerate(zip(origins, directions, strict=True)):
        p0 = start(o, d)
        sigma, _ = hits.mesh(o, p0, G, vertices, faces)
        expected, momentum = closed_forms.parabola(o, p0, G, sigma)
        limit = METHODS[method] * max(1.0, 1.0 / abs(momentum[np.argmax(np.abs(expected))]))
        assert np.linalg.norm(rays.position[i] - expected) < limit, i
        assert np.linalg.norm(rays.momentum[i] - momentum) < limit
        assert rays.length[i] == pytest.approx(closed_forms.parabola_arc_length(p0, G, sigma), abs=limit)
    on_wall = np.abs(np.abs(rays.position).max(axis=1) - 1)
    assert np.max(on_wall) < 1e-9, "hits are polished onto the surface"


@pytest.mark.parametrize("method", METHODS)
def test_sphere(method):
    """An exact sphere, from inside and outside, against the quartic."""
    center, radius = np.array((0.1, -0.2, 0.3)), 0.5
    scene = scene_with(lambda s: s.add_sphere(center, radius, material=BLACK), method)
    origins, directions = fan(200, seed=2, reach=0.9)
    directions[100:] = center - origins[100:] + 0.2 * directions[100:]
    rays = trace(scene, origins, directions, method)
    hit = 0
    for i, (o, d) in enumerate(zip(origins, directions, strict=True)):
        p0 = start(o, d)
        sigma = hits.sphere(o, p0, G, center, radius)
        if not np.isfinite(sigma):
            assert rays.status[i] != cpm.RayStatus.HIT or method == "euler", i
            continue
        expected, momentum = closed_forms.parabola(o, p0, G, sigma)
        graze = abs(momentum @ (expected - center)) / np.linalg.norm(momentum) / radius
        if graze < 0.1 or closed_forms.parabola_arc_length(p0, G, sigma) > 4:
            continue
        hit += 1
        assert rays.status[i] == cpm.RayStatus.HIT, i
        assert np.linalg.norm(rays.position[i] - expected) < METHODS[method] / graze, i
    assert hit > 100


def test_small_triangles():
    """A finely cut sphere (1280 facets): the facet's plane, not the sphere's, holds the hit."""
    vertices, faces = scenes.icosphere(0.9, 3, inward=True)
    scene = scene_with(lambda s: s.add_mesh(vertices, faces, material=BLACK))
    origins, directions = fan(40, seed=3, reach=0.4)
    rays = trace(scene, origins, directions, "auto")
    assert np.all(rays.status == cpm.RayStatus.HIT)
    for i, (o, d) in enumerate(zip(origins, directions, strict=True)):
        p0 = start(o, d)
        sigma, _ = hits.mesh(o, p0, G, vertices, faces)
        np.testing.assert_allclose(rays.position[i], closed_forms.parabola(o, p0, G, sigma)[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_comes_back_to_the_floor(method):
    """Over a flat floor the ray leaves the geometry's box, turns and comes back: a hit, on the triangle that it left.

    Only the root at σ = 0 is excluded.
    """
    medium = cpm.media.LinearSquared(2.0, gradient=(0, -1.0, 0))
    scene = cpm.Scene(medium=medium)
    scene.add_mesh([(-50, 0, -50), (-50, 0, 50), (50, 0, 0)], [(0, 1, 2)], material=BLACK)
    for angle in (10.0, 45.0, 80.0, 89.9):
        a = np.radians(angle)
        rays = cpm.trace(scene, [(0, 0, 0)], [(np.cos(a), np.sin(a), 0)], wavelength=550.0, method=method, rtol=1e-9)
        assert rays.status[0] == cpm.RayStatus.HIT
        np.testing.assert_allclose(
            rays.position[0], (4 * 2 * np.sin(a) * np.cos(a), 0, 0), rtol=0, atol=1e-9 if method == "auto" else 1e-6
        )


def test_grazing_from_below_the_chord():
    """A vertex of the parabola that dips 1e-4 m into a floor is a hit; one that clears it by 1e-4 m is not.

    The chord of the whole arc passes metres above: only a sagitta bound sees it.
    """
    g, n2 = np.array((0, 0.4, 0)), 1.0  # bends upward: a valley over the floor y = 0
    medium = cpm.media.LinearSquared(n2, gradient=g)
    for dip, status in ((1e-4, cpm.RayStatus.HIT), (-1e-4, cpm.RayStatus.LEFT)):
        for method in ("auto", "dopri5"):
            scene = cpm.Scene(medium=medium, extent=cpm.Box((-9, -1, -9), (9, 5, 9)))
            scene.add_mesh([(-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)], [(0, 1, 2), (0, 2, 3)], material=BLACK)
            height, x = 1.0, -3.0
            # Bottom at y = −dip: n² there = p_x² = 1 − 0.4 dip; p_y at the start from |p|² = n².
            p_x = np.sqrt(n2 - 0.4 * dip)
            p_y = -np.sqrt(n2 + 0.4 * height - p_x**2)
            rays = cpm.trace(scene, [(x, height, 0.01)], [(p_x, p_y, 0)], wavelength=550.0, method=method, rtol=1e-9)
            assert rays.status[0] == status, (dip, method)


def test_edges_and_corners_hold():
    """Rays aimed by the closed form at edges and vertices of a closed mesh hit one of the triangles that meet there."""
    vertices, faces = scenes.icosphere(1.0, 1, inward=True)
    scene = scene_with(lambda s: s.add_mesh(vertices, faces, material=BLACK))
    origin = np.array((0.05, 0.1, -0.07))
    targets = np.concatenate([vertices, 0.5 * (vertices[faces[:, 0]] + vertices[faces[:, 1]])])
    directions = []
    for target in targets:
        offset = target - origin
        # |offset − gσ²/4|² = n²σ²: a quadratic in σ².
        n2 = N2 + G @ origin
        a, b, c = G @ G / 16, -(n2 + 0.5 * offset @ G), offset @ offset
        u = 2 * c / (-b + np.sqrt(b * b - 4 * a * c))
        directions.append((offset - G * u / 4) / np.sqrt(u))
    rays = cpm.trace(scene, np.tile(origin, (len(targets), 1)), directions, wavelength=550.0)
    assert np.all(rays.status == cpm.RayStatus.HIT)
    np.testing.assert_allclose(rays.position, targets, rtol=0, atol=1e-8)


def test_left_and_length_in_a_scene():
    """Past everything: LEFT at the extent; with `length=` a ray that meets nothing arrives."""
    scene = cpm.Scene(medium=cpm.media.LinearSquared(N2, gradient=G), extent=cpm.Box((-2, -2, -2), (2, 2, 2)))
    scene.add_mesh([(5, 0, 0), (5, 1, 0), (5, 0, 1)], [(0, 1, 2)], material=BLACK)
    rays = cpm.trace(scene, [(0, 0, 0)], [(-1, 0.3, 0.1)], wavelength=550.0)
    assert rays.status[0] == cpm.RayStatus.LEFT
    assert np.abs(rays.position[0]).max() == pytest.approx(2.0, abs=1e-9) and rays.shape[0] == -1
    rays = cpm.trace(scene, [(0, 0, 0)], [(-1, 0.3, 0.1)], wavelength=550.0, length=0.5)
    assert rays.status[0] == cpm.RayStatus.ARRIVED
    expected = closed_forms.linear_squared(N2, G, np.zeros(3), np.zeros(3), (-1, 0.3, 0.1), length=0.5)
    np.testing.assert_allclose(rays.position[0], expected.position, rtol=0, atol=1e-12)


@pytest.mark.parametrize("end", [{"length": 3.0}, {"until": ((0, 0, -3.0), (0, 0, 1))}], ids=["length", "until"])
@pytest.mark.parametrize("what", ["nothing", "a shape elsewhere", "a bounded medium behind"])
def test_homogeneous_scene_has_no_edge(what, end):
    """All homogeneous: the default extent is infinite, so a ray that meets nothing arrives where it was sent."""
    scene = cpm.Scene()
    if what == "a shape elsewhere":
        scene.add_sphere((0, 9, 0), 0.1, material=BLACK)
    if what == "a bounded medium behind":
        scene.add_medium(cpm.media.Homogeneous(1.5, bounds=cpm.Box((-1, -1, 0.5), (1, 1, 1.5))))
    rays = cpm.trace(scene, [(0.1, 0.2, 0)], [(0, 0, -1)], wavelength=550.0, **end)
    assert rays.status[0] == cpm.RayStatus.ARRIVED
    np.testing.assert_allclose(rays.position[0], (0.1, 0.2, -3.0), rtol=0, atol=1e-12)
