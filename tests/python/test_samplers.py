"""χ² of every sampler, seeds fixed (DESIGN section 13): lights' directions and places, the diffuse lobe, Fresnel.

Without projection maps all photons of a light weigh the same, so counts can be judged.
"""

import itertools

import numpy as np
import pytest
from oracles import radiometry
from support import scenes
from support.statistics import assert_uniform, assert_uniform_pair, chi_square

import cpm

COUNT = 60_000
BLACK = cpm.materials.Diffuse(0.0)


def traced(scene, count=COUNT, seed=7):
    return cpm.trace_photons(scene, count, seed=seed, wavelengths=[550.0], projection=False)


def shell(medium=None, albedo=0.0, radius=5.0):
    """An analytic sphere around the origin: what is emitted is seen on it."""
    scene = cpm.Scene(medium=medium) if medium is not None else cpm.Scene()
    scene.add_sphere((0, 0, 0), radius, material=cpm.materials.Diffuse(albedo))
    return scene


def equal_weights(photon_map, total):
    """All weights equal, and their sum the light's power."""
    power = photon_map.power[:, 0].astype(float)
    assert np.ptp(power) <= 2e-3 * power.mean()  # 16-bit spectra
    assert power.sum() == pytest.approx(total, rel=2e-3)


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_point(n):
    """Uniform over the sphere; power 4πI whatever n (intensity is the actual one)."""
    scene = shell(cpm.media.Homogeneous(n))
    scene.add_light(cpm.lights.Point((0, 0, 0), 2.0))
    stored = traced(scene).diffuse
    assert len(stored.power) == COUNT
    d = stored.position / 5.0
    assert_uniform(d[:, 1], -1, 1)
    assert_uniform_pair(d[:, 1], np.arctan2(d[:, 2], d[:, 0]), (-1, -np.pi), (1, np.pi))
    equal_weights(stored, 8 * np.pi)


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("cutoff", [14.0, 60.0, 90.0])
def test_spot(cutoff, n):
    """Uniform in solid angle inside the cone, nothing outside; power I·2π(1 − cos cutoff)."""
    scene = shell(cpm.media.Homogeneous(n))
    axis = np.array((1.0, -2.0, 0.5)) / np.linalg.norm((1.0, -2.0, 0.5))
    scene.add_light(cpm.lights.Spot((0, 0, 0), 2 * axis, cutoff=cutoff, intensity=3.0))
    stored = traced(scene).diffuse
    d = stored.position.astype(float) / 5.0
    side = np.cross(axis, (0, 0, 1)) / np.linalg.norm(np.cross(axis, (0, 0, 1)))
    phi = np.arctan2(d @ np.cross(axis, side), d @ side)
    edge = np.cos(np.radians(cutoff))
    assert_uniform(d @ axis, edge, 1)
    assert_uniform_pair(d @ axis, phi, (edge, -np.pi), (1, np.pi))
    equal_weights(stored, 3 * 2 * np.pi * (1 - edge))


def lamp(n, emitter):
    """A lamp facing down at y = 1.5 in a large black room."""
    scene = cpm.Scene(medium=cpm.media.Homogeneous(n))
    scene.add_mesh(*scenes.box_mesh((-20, -20, -20), (20, 20, 20)), material=BLACK)
    shape = scene.add_mesh(*emitter, material=BLACK)
    scene.add_light(cpm.lights.Area(shape, 0.5))
    return scene


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_area_direction(n):
    """Cosine lobe on the side of the geometric normal: cos² uniform, azimuth too; power π n² L A."""
    half = 1e-4  # so small that place does not matter
    scene = lamp(n, scenes.rectangle((0, 1.5, 0), (half, 0, 0), (0, 0, half)))
    stored = traced(scene).diffuse
    d = stored.position.astype(float) - (0, 1.5, 0)
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    assert d[:, 1].max() < 0  # a × b = x × z = −y
    assert_uniform(d[:, 1] ** 2, 0, 1)
    assert_uniform_pair(d[:, 1] ** 2, np.arctan2(d[:, 2], d[:, 0]), (0, -np.pi), (1, np.pi))
    equal_weights(stored, np.pi * n * n * 0.5 * (2 * half) ** 2)


def test_area_place():
    """Uniform over triangles of unequal size: photons caught just below a lamp of two rectangles."""
    big, small = (
        scenes.rectangle((0, 1.5, 0), (1, 0, 0), (0, 0, 0.5)),
        scenes.rectangle((3, 1.5, 0), (0.5, 0, 0), (0, 0, 0.25)),
    )
    emitter = np.concatenate([big[0], small[0]]), np.concatenate([big[1], small[1] + 4])
    scene = lamp(1.0, emitter)
    gap = 1e-5
    scene.add_mesh(*scenes.rectangle((0, 1.5 - gap, 0), (0, 0, 10), (10, 0, 0)), material=BLACK)
    stored = traced(scene).diffuse
    near = np.abs(stored.position[:, 1] - 1.5) < 0.01
    assert near.mean() > 0.999
    r = stored.position[near].astype(float)
    on_big = r[:, 0] < 2
    assert chi_square([on_big.sum(), (~on_big).sum()], [2.0, 0.5]) > 1e-4
    inside = on_big & (np.abs(r[:, 0]) < 1) & (np.abs(r[:, 2]) < 0.5)
    assert_uniform_pair(r[inside, 0], r[inside, 2], (-1, -0.5), (1, 0.5))


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_cosine_scattering(n):
    """Inside a sphere a cosine lobe from any point lands uniformly: later bounces are uniform, however bad the first.

    A spot that lights one place only makes the first bounce as uneven as can be.
    """
    scene = shell(cpm.media.Homogeneous(n), albedo=0.8, radius=1.0)
    scene.add_light(cpm.lights.Spot((0, 0, 0), (0, -1, 0), cutoff=5.0, intensity=1.0))
    stored = traced(scene).diffuse
    for bounce in (1, 2):
        d = stored.position[stored.bounce == bounce].astype(float)
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        assert len(d) > 0.5 * COUNT
        assert_uniform(d[:, 1], -1, 1)
        assert_uniform_pair(d[:, 0], np.arctan2(d[:, 2], d[:, 1]), (-1, -np.pi), (1, np.pi))


def test_roulette_rate():
    """Survivors of an albedo 0.8: binomial at each bounce."""
    scene = shell(albedo=0.8, radius=1.0)
    scene.add_light(cpm.lights.Point((0, 0, 0), 1.0))
    bounce = traced(scene).diffuse.bounce
    counts = np.bincount(bounce)[:8]
    assert counts[0] == COUNT
    for before, after in itertools.pairwise(counts):
        assert abs(after - 0.8 * before) < 4.5 * np.sqrt(before * 0.16)


@pytest.mark.parametrize("degrees", [5.0, 45.0, 80.0])
def test_fresnel_rate(degrees):
    """A thin beam on a glass block: reflected share is Fresnel's, refracted ones go where Snell says."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.box_mesh((-30, -30, -30), (30, 30, 30)), material=BLACK)
    vertices, faces = scenes.box_mesh((-5, -8, -5), (5, 0, 5))
    scene.add_mesh(vertices, faces[:, ::-1].copy(), material=cpm.materials.Dielectric(1.5))
    a = np.radians(degrees)
    d = np.array((np.sin(a), -np.cos(a), 0.0))
    scene.add_light(cpm.lights.Spot(-0.5 * d, (0, 0, 0), cutoff=0.05, intensity=1.0))
    stored = traced(scene, 40_000).caustic
    up = (stored.direction[:, 1] > 0) & (stored.position[:, 1] > 0)
    first = up & (np.abs(np.hypot(stored.direction[:, 0], stored.direction[:, 2]) - np.sin(a)) < 0.02)
    # Reflected at the top face: straight line from the origin.
    line = np.cross(stored.position, d * (1, -1, 1))
    first &= np.linalg.norm(line, axis=1) < 0.15 * 1.0
    total = stored.power[:, 0].sum()
    share, expected = stored.power[first, 0].sum() / total, float(radiometry.fresnel(np.cos(a), 1.0, 1.5))
    assert share == pytest.approx(expected, abs=4.5 * np.sqrt(expected * (1 - expected) / len(stored.power)) + 2e-4)


def test_area_sphere():
    """An exact sphere as a lamp: outward, uniform over a concentric shell, power π L 4πR²."""
    scene = shell()
    shape = scene.add_sphere((0, 0, 0), 0.3, material=BLACK)
    scene.add_light(cpm.lights.Area(shape, 0.5))
    stored = traced(scene).diffuse
    d = stored.position / 5.0
    assert_uniform(d[:, 1], -1, 1)
    assert_uniform_pair(d[:, 0], np.arctan2(d[:, 2], d[:, 1]), (-1, -np.pi), (1, np.pi))
    equal_weights(stored, np.pi * 0.5 * 4 * np.pi * 0.09)


def test_lights_share_the_photons():
    """Two lamps of unequal power: each gets its own power, whatever share of the photons."""
    scene = shell()
    scene.add_sphere((0, 0, 0), 0.01, material=BLACK)
    scene.add_light(cpm.lights.Spot((0, 1, 0), (0, 4, 0), cutoff=30.0, intensity=1.0))
    scene.add_light(cpm.lights.Spot((0, -1, 0), (0, -4, 0), cutoff=30.0, intensity=7.0))
    stored = traced(scene).diffuse
    up = stored.position[:, 1] > 0
    one = 2 * np.pi * (1 - np.cos(np.radians(30)))
    assert stored.power[up, 0].sum() == pytest.approx(one, rel=4 / np.sqrt(up.sum()))
    assert stored.power[~up, 0].sum() == pytest.approx(7 * one, rel=4 / np.sqrt((~up).sum()))
