"""Bounded media (DESIGN sections 1, 8): Snell with the local n of both sides, the last added wins, no jump no break."""

import numpy as np
import pytest
from oracles import closed_forms, hits, radiometry
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
    rays = trace(scene_with(low, high), (0.137, 2, 0.211), down)
    assert rays.optical_path[0] == pytest.approx(2 * 1.0 + 1 * 1.2 + 1 * 1.5, abs=1e-9)
    rays = trace(scene_with(high, low), (0.137, 2, 0.211), down)
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


def follow(origin, direction, length):
    """Oracle: `length` metres through the gradient box, by straight lines, parabolas, Snell and total reflection."""
    vertices, faces = scenes.box_mesh(*BOX)
    r, d, g, inside, left = (
        np.array(origin),
        np.array(direction) / np.linalg.norm(direction),
        np.array(G),
        False,
        length,
    )
    while True:
        p, bend = (inside_index(r) * d, g) if inside else (d, np.zeros(3))
        sigma, face = hits.mesh(r, p, bend, vertices, faces, after=1e-9)
        reach = closed_forms.parabola_arc_length(p, bend, sigma) if np.isfinite(sigma) else np.inf
        if reach >= left:
            sigma = closed_forms.parabola_sigma_of_length(p, bend, left)
            r, p = closed_forms.parabola(r, p, bend, sigma)
            return r, p / np.linalg.norm(p)
        left -= reach
        r, p = closed_forms.parabola(r, p, bend, sigma)
        a, b, c = vertices[faces[face]]
        normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        d, n = p / np.linalg.norm(p), inside_index(r)
        out = radiometry.snell(d, normal, *((n, 1.0) if inside else (1.0, n)))
        if out is None:
            d = d - 2 * (d @ normal) * normal
        else:
            d, inside = out, not inside


@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_random_rays_through_the_box(method):
    """120 rays, many totally reflected several times: where they are after 5 m."""
    rng = np.random.default_rng(12)
    origins = 2.5 * rng.normal(size=(120, 3))
    origins *= 2.5 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-0.8, 0.8, (120, 3)) * (1, 0.5, 1) - origins
    scene = scene_with(cpm.media.LinearSquared(N2, gradient=G, bounds=cpm.Box(*BOX)))
    rays = cpm.trace(scene, origins, directions, wavelength=550.0, length=5.0, method=method, rtol=1e-11)
    expected = [follow(o, d, 5.0) for o, d in zip(origins, directions, strict=True)]
    assert np.all(rays.status == cpm.RayStatus.ARRIVED)
    np.testing.assert_allclose(rays.position, [e[0] for e in expected], rtol=0, atol=1e-7)
    np.testing.assert_allclose(rays.direction, [e[1] for e in expected], rtol=0, atol=1e-7)


def test_faces_diagonal():
    """A ray that meets a box's face exactly on a diagonal or an edge of its triangles passes like any other."""
    scene = scene_with(cpm.media.Homogeneous(1.5, bounds=cpm.Box((-1, -0.5, -1), (1, 0.5, 1))))
    across = np.linspace(-0.95, 0.95, 39)
    x, z = (v.ravel() for v in np.meshgrid(across, across))
    origins = np.stack([x, np.full(x.size, 2.0), z], axis=1)
    rays = cpm.trace(scene, origins, np.tile((0.0, -1.0, 0.0), (x.size, 1)), wavelength=550.0, until=OUT)
    assert np.all(rays.status == cpm.RayStatus.ARRIVED), f"{np.sum(rays.status != 0)} of {x.size} stuck"
    np.testing.assert_allclose(rays.optical_path, 3 + 1.5, rtol=0, atol=1e-9)


COINCIDENT = {
    # boxes as (low y, high y, n); the path is 4 m along −y from y = 2
    "adjacent": ([(-0.5, 0.5, 1.5), (-1.5, -0.5, 1.3)], 2 * 1.0 + 1.5 + 1.3),
    "adjacent, other order": ([(-1.5, -0.5, 1.3), (-0.5, 0.5, 1.5)], 2 * 1.0 + 1.5 + 1.3),
    "nested, one face shared": ([(-0.5, 0.5, 1.5), (-0.5, 0.0, 1.3)], 3 * 1.0 + 0.5 * 1.5 + 0.5 * 1.3),
    "the same box twice": ([(-0.5, 0.5, 1.5), (-0.5, 0.5, 1.3)], 3 * 1.0 + 1.3),
}


@pytest.mark.parametrize("name", COINCIDENT)
@pytest.mark.parametrize("lean", [0.0, 0.3])
def test_coincident_faces(name, lean):
    """Media that share a face: each fills its own side, the later one where both do (stacked slabs, a lens doublet)."""
    boxes, straight = COINCIDENT[name]
    scene = scene_with(
        *(cpm.media.Homogeneous(n, bounds=cpm.Box((-5, low, -5), (5, high, 5))) for low, high, n in boxes)
    )
    rays = trace(scene, (0.137, 2, 0.211), (np.sin(lean), -np.cos(lean), 0))
    assert rays.status[0] == cpm.RayStatus.ARRIVED
    if lean:
        assert rays.direction[0, 0] == pytest.approx(np.sin(lean), abs=1e-12)  # plane parallel: out as it came in
    else:
        assert rays.optical_path[0] == pytest.approx(straight, abs=1e-9)
