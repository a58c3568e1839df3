"""Bounded media (DESIGN sections 1, 8): Snell with the local n of both sides, the last added wins, no jump no break."""

import numpy as np
import pytest
from oracles import closed_forms, radiometry
from support import scenes

import cpm

N2, G, BASE = 2.25, (0.3, 0.4, 0.0), (0.0, 0.0, 0.0)
BOX = (-1.0, -0.5, -1.0), (1.0, 0.5, 1.0)
OUT = ((0, -2, 0), (0, 1, 0))


def inside_index(r):
    return float(np.sqrt(N2 + np.dot(G, r)))


def scene_with(*media, medium=None):
    scene = cpm.Scene(medium=medium, extent=cpm.Box((-60, -60, -60), (60, 60, 60)))
    for m in media:
        scene.add_medium(m)
    return scene


def trace(scene, origin, direction, **options):
    options.setdefault("until", OUT)
    return cpm.trace(scene, [origin], [direction], wavelength=550.0, **options)


@pytest.mark.parametrize("method", ["auto", "dopri5"])
@pytest.mark.parametrize("degrees", [0.0, 20.0, 50.0])
def test_box_of_gradient(degrees, method):
    """In through the top face, along a parabola, out through the bottom: Snell twice with n(r) where it crosses."""
    a = np.radians(degrees)
    d = np.array((np.sin(a), -np.cos(a), 0.0))
    entry = np.array((-0.3, 0.5, 0.1))
    scene = scene_with(cpm.media.LinearSquared(N2, gradient=G, bounds=cpm.Box(*BOX)))
    inside = radiometry.snell(d, (0, 1, 0), 1.0, inside_index(entry))
    leg = closed_forms.linear_squared(N2, G, BASE, entry, inside, until=((0, -0.5, 0), (0, 1, 0)))
    assert abs(leg.position[0]) < 1, "the case must leave by the bottom"
    out = radiometry.snell(leg.direction, (0, 1, 0), inside_index(leg.position), 1.0)
    rest = (-2 - leg.position[1]) / out[1]
    rays = trace(scene, entry - 0.8 * d, d, method=method, rtol=1e-10)
    np.testing.assert_allclose(rays.position[0], leg.position + rest * out, rtol=0, atol=2e-9)
    np.testing.assert_allclose(rays.direction[0], out, rtol=0, atol=2e-9)
    assert rays.optical_path[0] == pytest.approx(0.8 + leg.optical_path + rest, abs=5e-9)
    assert rays.length[0] == pytest.approx(0.8 + leg.arc_length + rest, abs=5e-9)


def test_total_reflection_inside():
    """Homogeneous glass: a ray beyond the critical angle at the bottom comes back out of the top."""
    scene = scene_with(cpm.media.Homogeneous(1.5, bounds=cpm.Box((-50, -0.5, -50), (50, 0.5, 50))))
    a = np.radians(60)
    d = np.array((np.sin(a), -np.cos(a), 0))
    rays = trace(scene, (0, 0, 0), d, length=0.9 / np.cos(a), until=None)
    # 0.5 down, then 0.4 up: still inside.
    np.testing.assert_allclose(rays.position[0], (0.9 * np.tan(a), -0.1, 0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(rays.direction[0], d * (1, -1, 1), rtol=0, atol=1e-12)


def test_no_jump_no_break():
    """The same index on both sides: the ray passes unbroken, as if nothing were there."""
    d = np.array((0.5, -1.0, 0.2))
    bare = trace(scene_with(), (0, 1, 0), d)
    held = trace(scene_with(cpm.media.Homogeneous(1.0, bounds=cpm.Box(*BOX))), (0, 1, 0), d)
    np.testing.assert_allclose(held.position, bare.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(held.direction, bare.direction, rtol=0, atol=1e-15)


def test_sphere_bounds():
    """A homogeneous ball: the two refractions of a lens, by Snell at its normals."""
    center, radius, n = np.array((0.1, 0.0, -0.2)), 0.7, 1.4
    scene = scene_with(cpm.media.Homogeneous(n, bounds=cpm.Sphere(center, radius)))
    start, d = np.array((0.3, 2.0, 0.0)), np.array((-0.05, -1.0, 0.02))
    d /= np.linalg.norm(d)

    def cross(r, d):
        b = d @ (r - center)
        root = np.sqrt(b * b - (r - center) @ (r - center) + radius**2)
        t = next(x for x in (-b - root, -b + root) if x > 1e-9)
        return r + t * d

    first = cross(start, d)
    inside = radiometry.snell(d, (first - center) / radius, 1.0, n)
    second = cross(first, inside)
    out = radiometry.snell(inside, (second - center) / radius, n, 1.0)
    rest = (-2 - second[1]) / out[1]
    rays = trace(scene, start, d)
    np.testing.assert_allclose(rays.position[0], second + rest * out, rtol=0, atol=1e-10)
    np.testing.assert_allclose(rays.direction[0], out, rtol=0, atol=1e-11)


def test_shape_as_bounds():
    """A closed mesh of the scene bounds a medium: the box again, as triangles (its surface is a dielectric's)."""
    vertices, faces = scenes.box_mesh(*BOX)
    scene = scene_with()
    interior = cpm.media.LinearSquared(N2, gradient=G)
    scene.add_mesh(vertices, faces[:, ::-1].copy(), material=cpm.materials.Dielectric(interior))
    boxed = scene_with(cpm.media.LinearSquared(N2, gradient=G, bounds=cpm.Box(*BOX)))
    d, start = np.array((0.3, -1.0, 0.1)), np.array((-0.3, 1.2, 0.1))
    expected = trace(boxed, start, d)
    rays = trace(scene, start, d)
    np.testing.assert_allclose(rays.position, expected.position, rtol=0, atol=1e-9)


def test_last_added_wins():
    """Where two boxes overlap the later one fills: a straight ray's optical path says which."""
    low = cpm.media.Homogeneous(1.2, bounds=cpm.Box((-5, -1, -5), (5, 1, 5)))
    high = cpm.media.Homogeneous(1.5, bounds=cpm.Box((-5, -0.5, -5), (5, 0.5, 5)))
    down = (0.0, -1.0, 0.0)
    rays = trace(scene_with(low, high), (0, 2, 0), down)
    assert rays.optical_path[0] == pytest.approx(2 * 1.0 + 1 * 1.2 + 1 * 1.5, abs=1e-9)
    rays = trace(scene_with(high, low), (0, 2, 0), down)
    assert rays.optical_path[0] == pytest.approx(2 * 1.0 + 2 * 1.2, abs=1e-9)


@pytest.mark.parametrize(
    ("height", "direction", "n"),
    [(0.0, (0, -1, 0), 1.5), (0.5, (0, -1, 0), 1.5), (0.5, (0, 1, 0), 1.0), (0.7, (0, 1, 0), 1.0)],
)
def test_start_inside_or_on_the_face(height, direction, n):
    """Where a ray starts decides its |p|; on a boundary it is the side that the direction enters."""
    scene = scene_with(cpm.media.Homogeneous(1.5, bounds=cpm.Box(*BOX)))
    rays = trace(scene, (0, height, 0), direction, length=0.1, until=None)
    assert np.linalg.norm(rays.momentum[0]) == pytest.approx(n, rel=1e-12)
    assert rays.optical_path[0] == pytest.approx(0.1 * n, abs=1e-12)


def test_bounded_in_a_curved_medium():
    """The background bends too: parabola, Snell, straight, Snell, parabola."""
    n2, g = 1.69, (0, -0.10, 0)
    glass = cpm.media.Homogeneous(1.6, bounds=cpm.Box((-9, -0.5, -9), (9, 0.5, 9)))
    scene = scene_with(glass, medium=cpm.media.LinearSquared(n2, gradient=g))
    start, d = np.array((0.0, 2.0, 0.0)), np.array((1.0, -1.0, 0.2))
    up = (0, 1, 0)
    leg = closed_forms.linear_squared(n2, g, BASE, start, d, until=((0, 0.5, 0), up))
    inside = radiometry.snell(leg.direction, up, np.sqrt(n2 - 0.05), 1.6)
    second = leg.position + inside * (1 / -inside[1])
    out = radiometry.snell(inside, up, 1.6, np.sqrt(n2 + 0.05))
    end = closed_forms.linear_squared(n2, g, BASE, second, out, until=OUT)
    rays = trace(scene, start, d)
    np.testing.assert_allclose(rays.position[0], end.position, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rays.momentum[0], end.momentum, rtol=0, atol=1e-9)
