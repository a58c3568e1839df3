"""A gradient-index rod in a block of glass in air, both closed meshes: whole paths, Snell with the local n on both sides.

Oracle: straight lines, Snell at planes, the fibre's sinusoid between (`oracles.central`): nothing of the library's.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles import central, radiometry
from support import scenes

import cpm

GLASS, INDEX, ALPHA = 1.5, 1.62, 0.35
BLOCK = (-2.0, -2.0, -1.5), (2.0, 2.0, 2.5)
ROD = (-1.2, -1.2, -0.8), (1.2, 1.2, 1.4)
AXIS, BASE = (0.0, 0.0, 1.0), (0.15, -0.1, 0.0)
SCREEN = 4.0
FORWARD = np.array(AXIS)


def index(r):
    return INDEX * np.sqrt(1 - ALPHA**2 * np.sum((np.asarray(r)[:2] - BASE[:2]) ** 2))


def lens(**options):
    """The scene; the rod is given as a medium bounded by a shape, in a block that is a dielectric of glass."""
    scene = cpm.Scene(extent=cpm.Box((-20, -20, -20), (20, 20, 20)), **options)
    for (low, high), medium in ((BLOCK, cpm.media.Homogeneous(GLASS)),
                                (ROD, cpm.media.Parabolic(INDEX, ALPHA, axis=AXIS, origin=BASE))):
        vertices, faces = scenes.box_mesh(low, high)
        scene.add_mesh(vertices, faces[:, ::-1].copy(), material=cpm.materials.Dielectric(medium))
    return scene


def straight(r, d, z, n):
    """To the plane of z: where, and the optical path."""
    t = (z - r[2]) / d[2]
    return r + t * d, n * t


def expected(origin, direction):
    """Position and direction on the screen, and the optical path."""
    r, d = np.array(origin, float), np.array(direction, float) / np.linalg.norm(direction)
    r, optical = straight(r, d, BLOCK[0][2], 1.0)
    d = radiometry.snell(d, FORWARD, 1.0, GLASS)
    r, more = straight(r, d, ROD[0][2], GLASS)
    optical += more
    d = radiometry.snell(d, FORWARD, GLASS, index(r))
    leg = central.parabolic(INDEX, ALPHA, AXIS, BASE, r, d, until=((0, 0, ROD[1][2]), AXIS))
    r, optical = leg.position, optical + leg.optical_path
    assert np.all(np.abs(r[:2]) < 1.2), "the case must leave by the far end"
    d = radiometry.snell(leg.direction, FORWARD, index(r), GLASS)
    r, more = straight(r, d, BLOCK[1][2], GLASS)
    optical += more
    d = radiometry.snell(d, FORWARD, GLASS, 1.0)
    r, more = straight(r, d, SCREEN, 1.0)
    return r, d, optical + more


ORIGINS = np.array([(0.15, -0.1, -3), (0.6, 0.2, -3), (-0.5, 0.5, -2.5), (0.1, -0.8, -4), (0.8, 0.1, -3)])
DIRECTIONS = np.array([(0, 0, 1), (0, 0, 1), (0.2, -0.1, 1), (0.05, 0.1, 1), (-0.3, 0.15, 1)])


@pytest.mark.parametrize(("options", "limit"), [
    ({}, 1e-9),
    ({"exclude": ("exact",), "rtol": 1e-10}, 1e-8),
    ({"method": "dopri5", "rtol": 1e-10}, 1e-8),
    ({"method": "adams", "rtol": 1e-10}, 1e-8),
])
def test_whole_path(options, limit):
    """Air, glass, rod, glass, air: place and direction on a screen behind, and the optical path."""
    ends = [expected(*ray) for ray in zip(ORIGINS, DIRECTIONS, strict=True)]
    rays = cpm.trace(lens(), ORIGINS, DIRECTIONS, wavelength=550.0, until=((0, 0, SCREEN), AXIS), **options)
    np.testing.assert_allclose(rays.position, [end[0] for end in ends], rtol=0, atol=limit)
    np.testing.assert_allclose(rays.direction, [end[1] for end in ends], rtol=0, atol=limit)
    np.testing.assert_allclose(rays.optical_path, [end[2] for end in ends], rtol=0, atol=limit)
    bent = np.linalg.norm(rays.direction - DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1)[:, None], axis=1)
    assert np.all(bent[1:] > 0.05), "the lens must matter"


def test_it_focuses():
    """Rays parallel to the axis are brought together as the paraxial matrix of rod and faces says, up to h²."""
    heights = np.array([0.01, 0.02])
    origins = np.column_stack([BASE[0] + heights, np.full(2, BASE[1]), np.full(2, -3.0)])
    rays = cpm.trace(lens(), origins, [AXIS] * 2, wavelength=550.0, until=((0, 0, SCREEN), AXIS))
    phase = ALPHA * (ROD[1][2] - ROD[0][2])
    # in the rod: x = h cos αz, n₀x′ = −h n₀α sin αz; behind it the glass, then air
    height, slope = np.cos(phase), -INDEX * ALPHA * np.sin(phase)
    away = (BLOCK[1][2] - ROD[1][2]) / GLASS + (SCREEN - BLOCK[1][2])
    off = np.abs((rays.position[:, 0] - BASE[0]) / heights - (height + slope * away))
    assert np.all(off <= 0.2 * heights**2), off


def test_shape_that_bounds():
    """The same rod as a medium with `bounds=` the mesh: no difference to the dielectric's interior."""
    scene = cpm.Scene(extent=cpm.Box((-20, -20, -20), (20, 20, 20)))
    for (low, high), make in ((BLOCK, lambda **o: cpm.media.Homogeneous(GLASS, **o)),
                              (ROD, lambda **o: cpm.media.Parabolic(INDEX, ALPHA, axis=AXIS, origin=BASE, **o))):
        vertices, faces = scenes.box_mesh(low, high)
        shape = scene.add_mesh(vertices, faces[:, ::-1].copy(), material=cpm.materials.Dielectric(make()))
        scene.add_medium(make(bounds=shape))
    rays = cpm.trace(scene, ORIGINS, DIRECTIONS, wavelength=550.0, until=((0, 0, SCREEN), AXIS))
    ends = np.array([expected(*ray)[0] for ray in zip(ORIGINS, DIRECTIONS, strict=True)])
    np.testing.assert_allclose(rays.position, ends, rtol=0, atol=1e-9)
