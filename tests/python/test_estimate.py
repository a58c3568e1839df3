"""The irradiance estimate against brute force (DESIGN section 8, Estimate).

E = Σ(the k−1 nearer photons)/(π r_k²) of the right side; direct photons (bounce 0) and later ones
searched apart; fewer than k within `max_radius`: all of them over π max_radius².
"""

import numpy as np
import pytest
from support import scenes

import cpm

WAVELENGTHS = [450.0, 550.0, 620.0]


@pytest.fixture(scope="module")
def photons():
    """A coloured box with a small lamp: photons of many bounces on flat walls."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.box_mesh((0, 0, 0), (2, 2, 2)), material=cpm.materials.Diffuse(([400, 700], [0.3, 0.7])))
    scene.add_light(cpm.lights.Point((0.8, 1.3, 0.9), 1.0))
    return cpm.trace_photons(scene, 40_000, seed=1, wavelengths=WAVELENGTHS).diffuse


def queries(count=40, margin=0.5):
    """Points on floor and left wall at least `margin` from the corners, and their normals."""
    rng = np.random.default_rng(4)
    points = rng.uniform(margin, 2 - margin, (count, 3))
    normals = np.zeros((count, 3))
    points[: count // 2, 1], normals[: count // 2, 1] = 0.0, 1.0
    points[count // 2 :, 0], normals[count // 2 :, 0] = 0.0, 1.0
    return points, normals


def brute_force(photon_map, points, normals, nearest, max_radius=np.inf):
    """(N, B) the formula, one query at a time."""
    position, power = photon_map.position.astype(float), photon_map.power.astype(float)
    direction, out = photon_map.direction.astype(float), np.zeros((len(points), power.shape[1]))
    for i, (point, normal) in enumerate(zip(points, normals, strict=True)):
        front = direction @ normal < 0
        for group in (photon_map.bounce == 0, photon_map.bounce > 0):
            keep = front & group
            square = np.sum((position[keep] - point) ** 2, axis=1)
            order = np.argsort(square)
            within = order[square[order] <= max_radius**2]
            if len(within) >= nearest:
                area = np.pi * square[within[nearest - 1]]
                used = within[: nearest - 1]
            else:
                area, used = np.pi * max_radius**2, within
            out[i] += power[keep][used].sum(axis=0) / area
    return out


@pytest.mark.parametrize("nearest", [2, 50, 150])
def test_nearest(photons, nearest):
    points, normals = queries()
    found = photons.irradiance(points, normals, nearest=nearest)
    assert found.shape == (len(points), 3)
    np.testing.assert_allclose(found, brute_force(photons, points, normals, nearest), rtol=2e-4)


@pytest.mark.parametrize("max_radius", [0.4, 0.1, 0.03])
def test_max_radius(photons, max_radius):
    """Fewer than k within the radius: all that are there."""
    points, normals = queries()
    found = photons.irradiance(points, normals, nearest=150, max_radius=max_radius)
    np.testing.assert_allclose(found, brute_force(photons, points, normals, 150, max_radius), rtol=2e-4, atol=1e-12)


def test_fewer_stored_than_asked():
    """Five photons, 150 asked: Σ of all within the scene's diagonal or the radius given."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Spot((0, 1, 0), (0, 0, 0), cutoff=20.0, intensity=1.0))
    stored = cpm.trace_photons(scene, 5, seed=1, wavelengths=[550.0], projection=False).diffuse
    assert len(stored.power) == 5
    up, at = [(0.0, 1.0, 0.0)], [(0.0, 0.0, 0.0)]
    found = stored.irradiance(at, up, nearest=150, max_radius=0.7)
    np.testing.assert_allclose(found[0], stored.power.sum(axis=0) / (np.pi * 0.49), rtol=1e-5)
    diagonal = stored.irradiance(at, up, nearest=150)
    assert np.all(np.isfinite(diagonal)) and 0 < diagonal[0, 0] < found[0, 0]


def test_wrong_side(photons):
    """From outside the box, nothing."""
    points, normals = queries()
    np.testing.assert_array_equal(photons.irradiance(points, -normals, nearest=50, max_radius=0.3), 0.0)


def test_two_groups(photons):
    """Direct and later photons are searched apart: a single search would differ by more than rounding."""
    points, normals = queries()
    single = np.zeros((len(points), 3))
    position, power = photons.position.astype(float), photons.power.astype(float)
    for i, point in enumerate(points):
        keep = photons.direction @ normals[i] < 0
        square = np.sum((position[keep] - point) ** 2, axis=1)
        order = np.argsort(square)
        single[i] = power[keep][order[:49]].sum(axis=0) / (np.pi * square[order[49]])
    found = photons.irradiance(points, normals, nearest=50)
    assert np.max(np.abs(found / single - 1)) > 0.01


def test_empty_map():
    """A map with nothing in it estimates zero."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Spot((0, 1, 0), (0, 2, 0), cutoff=10.0, intensity=1.0))
    photons = cpm.trace_photons(scene, 1000, seed=1, wavelengths=WAVELENGTHS)
    for stored in (photons.diffuse, photons.caustic):
        assert len(stored.power) == 0
        np.testing.assert_array_equal(stored.irradiance([(0, 0, 0)], [(0, 1, 0)]), np.zeros((1, 3)))


@pytest.mark.parametrize(
    ("points", "normals", "options"),
    [
        ([(np.nan, 0, 0)], [(0, 1, 0)], {}),
        ([(0, 0, 0)], [(0, 0, 0)], {}),
        ([(0, 0)], [(0, 1, 0)], {}),
        ([(0, 0, 0)], [(0, 1, 0), (0, 1, 0)], {}),
        ([(0, 0, 0)], [(0, 1, 0)], {"nearest": 0}),
        ([(0, 0, 0)], [(0, 1, 0)], {"max_radius": -1.0}),
    ],
)
def test_bad_queries(photons, points, normals, options):
    with pytest.raises(ValueError):
        photons.irradiance(points, normals, **options)
