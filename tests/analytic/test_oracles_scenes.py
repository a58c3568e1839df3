"""The oracles of whole scenes against each other: the cross room, Fresnel and Snell, the glass sphere.

Runs without the library, so a failure here is the oracle's own.
"""

import numpy as np
import pytest
from oracles import cross_room, fields, glass_sphere, radiometry, rays


@pytest.mark.parametrize("room", [cross_room.STRAIGHT, cross_room.CURVED], ids=["straight", "curved"])
class TestCrossRoom:
    """The room's direct light: DOP853, a difference quotient and a Monte Carlo sum as judges."""

    def test_path_reaches_its_point(self, room):
        medium = fields.LinearSquared(room.n_squared, (0, room.slope, 0))
        for x, z in [(-1.2, 0.1), (-0.5, 0.6), (0.3, -0.2)]:
            point = cross_room.floor_points(x, z)
            ray = rays.trace(medium, cross_room.SPOT, room.momentum_to(point), until=((0, 0, 0), (0, 1, 0)))
            np.testing.assert_allclose(ray.position, point, rtol=0, atol=1e-11)
            wall = rays.trace(medium, cross_room.SPOT, room.momentum_to(point), until=((-2, 0, 0), (1, 0, 0)))
            np.testing.assert_allclose(room.on_wall(point), wall.position[[2, 1]], rtol=0, atol=1e-11)

    def test_jacobian(self, room):
        h = 1e-4
        for x, z in [(-1.2, 0.1), (-0.5, 0.6), (0.3, -0.2)]:
            corners = cross_room.floor_points(x + h * np.array([-1, 1, 1, -1]), z + h * np.array([-1, -1, 1, 1]))
            d = room.momentum_to(corners) / room.n_spot
            area = 0.5 * np.linalg.norm(np.cross(d[2] - d[0], d[3] - d[1]))
            assert room.solid_angle_density(x, z) == pytest.approx(area / (4 * h * h), rel=1e-7)

    def test_power_by_monte_carlo(self, room):
        """Directions uniform in the cone, walls crossed at the hole: the fraction is the floor's power."""
        rng = np.random.default_rng(3)
        cosine = rng.uniform(np.cos(cross_room.HALF_ANGLE), 1, 400_000)
        phi = rng.uniform(0, 2 * np.pi, len(cosine))
        axis = (cross_room.TARGET - cross_room.SPOT) / np.linalg.norm(cross_room.TARGET - cross_room.SPOT)
        side = np.array([0.0, 0.0, 1.0])
        sine = np.sqrt(1 - cosine**2)
        d = cosine[:, None] * axis + sine[:, None] * (
            np.cos(phi)[:, None] * side + np.sin(phi)[:, None] * np.cross(axis, side)
        )
        x, z = room.floor_of_direction(d)
        sigma = 3.0 / (room.n_spot * d[:, 0])
        y = cross_room.SPOT[1] + room.n_spot * d[:, 1] * sigma + room.slope * sigma**2 / 4
        hit = cross_room.through_cross(room.n_spot * d[:, 2] * sigma, y)
        np.testing.assert_array_equal(hit, room.lit(x, z))
        cone = 2 * np.pi * (1 - np.cos(cross_room.HALF_ANGLE)) * cross_room.INTENSITY
        spread = cone * np.sqrt(hit.mean() * (1 - hit.mean()) / len(hit))
        assert abs(room.floor_power(1000) - cone * hit.mean()) < 4 * spread + 1e-3 * cone

    def test_outline_bounds_the_lit_figure(self, room):
        """Just inside and just outside the hole's rim, `lit` changes (where the cone does not cut)."""
        hole, _ = room.outline(8)
        centre = hole[:-1].mean(axis=0)
        for (x, z), (x2, z2) in zip(hole[:-1:8], hole[4:-1:8], strict=True):
            del x, z
            inward = centre - np.array([x2, z2])
            inward /= np.linalg.norm(inward)
            if room.in_cone(cross_room.floor_points(x2, z2)):
                assert room.lit(x2 + 1e-3 * inward[0], z2 + 1e-3 * inward[1]) != room.lit(
                    x2 - 1e-3 * inward[0], z2 - 1e-3 * inward[1]
                )


def test_straight_room_is_inverse_square():
    x, z = -0.4, 0.1
    offset = cross_room.floor_points(x, z) - cross_room.SPOT
    distance = np.linalg.norm(offset)
    expected = cross_room.INTENSITY * -offset[1] / distance**3
    assert cross_room.STRAIGHT.irradiance(x, z) == pytest.approx(expected, rel=1e-13)


def test_bk7_is_the_data_sheet():
    for line, n in radiometry.BK7_LINES.items():
        assert float(radiometry.bk7(line)) == pytest.approx(n, abs=6e-6)


def test_prism_is_two_refractions():
    apex, incidence, n = np.radians(60), np.radians(49), 1.52
    left, right = np.array([-np.cos(apex / 2), np.sin(apex / 2)]), np.array([np.cos(apex / 2), np.sin(apex / 2)])
    tilt = np.arctan2(-left[1], -left[0]) + incidence
    d = np.array([np.cos(tilt), np.sin(tilt), 0.0])
    inside = radiometry.snell(d, np.append(left, 0), 1.0, n)
    out = radiometry.snell(inside, np.append(right, 0), n, 1.0)
    assert np.arccos(out @ d) == pytest.approx(radiometry.prism_deviation(n, apex, incidence), abs=1e-12)


def test_fresnel_limits():
    assert radiometry.fresnel(1.0, 1.0, 1.5) == pytest.approx(0.04)
    assert radiometry.fresnel(0.0, 1.0, 1.5) == 1.0
    assert radiometry.fresnel(0.5, 1.5, 1.0) == 1.0  # 60° inside glass: total
    brewster = np.cos(np.arctan(1.5))
    s = (np.cos(np.arctan(1.5)) - 1.5 * np.sin(np.arctan(1.5))) / (
        np.cos(np.arctan(1.5)) + 1.5 * np.sin(np.arctan(1.5))
    )
    assert radiometry.fresnel(brewster, 1.0, 1.5) == pytest.approx(s * s / 2)


def test_glass_sphere():
    """Paraxial rays meet at the lens-maker's image, and the paths carry the cone's whole power."""
    geometry = dict(height=3.0, radius=0.5)
    v = glass_sphere.paraxial_image(1.5, **geometry)
    rho, power = glass_sphere.floor_radii(1.5, **geometry, drop=v, samples=20_000, reflections=0)
    assert abs(rho[-1]) < 1e-6 and abs(rho[-1] / rho[-2000]) < 1e-2
    cone = 2 * np.pi * (1 - np.sqrt(1 - (0.5 / 3) ** 2))
    assert power.sum() <= cone
    ring = glass_sphere.fold_radius(1.5, **geometry, drop=0.65)
    density = glass_sphere.ring_power(1.5, np.linspace(0, 0.4, 201), **geometry, drop=0.65) / np.diff(
        np.linspace(0, 0.4, 201) ** 2
    )
    outer = np.linspace(0.001, 0.399, 200)
    peak = outer[np.argmax(np.where(outer > 0.05, density, 0))]
    assert peak == pytest.approx(ring, abs=0.004)


def test_glass_sphere_in_three_dimensions():
    """Ring power again by rays in space, with `snell` and `fresnel` at real normals, Russian roulette at each hit."""
    rng, n, height, radius, drop, count = np.random.default_rng(8), 1.5, 3.0, 0.5, 0.65, 8000
    limit = np.sqrt(1 - (radius / height) ** 2)
    edges = np.array([0.0, 0.05, 0.1, 0.2, 0.6, 2.0])
    landed = np.zeros(len(edges) - 1)
    for cosine, phi in zip(rng.uniform(limit, 1, count), rng.uniform(0, 2 * np.pi, count), strict=True):
        sine = np.sqrt(1 - cosine**2)
        d, r, inside = np.array((sine * np.cos(phi), -cosine, sine * np.sin(phi))), np.array((0.0, height, 0.0)), False
        for _ in range(12):
            b = d @ r
            root = b * b - r @ r + radius**2
            t = (-b + np.sqrt(root) if inside else -b - np.sqrt(root)) if root > 0 else -1.0
            if t < 1e-9:
                break
            r = r + t * d
            m = r / np.linalg.norm(r)
            n1, n2 = (n, 1.0) if inside else (1.0, n)
            if rng.uniform() < radiometry.fresnel(d @ m, n1, n2):
                d = d - 2 * (d @ m) * m
                if not inside:
                    break
            else:
                d, inside = radiometry.snell(d, m, n1, n2), not inside
                if not inside:
                    break
        if d[1] < 0 and not inside:
            at = r + d * (-drop - r[1]) / d[1]
            slot = np.searchsorted(edges, np.hypot(at[0], at[2])) - 1
            if slot < len(landed):
                landed[slot] += 1
    expected = (
        glass_sphere.ring_power(n, edges, height=height, radius=radius, drop=drop) / (2 * np.pi * (1 - limit)) * count
    )
    assert np.all(np.abs(landed - expected) < 4 * np.sqrt(expected) + 1), (landed, expected)
