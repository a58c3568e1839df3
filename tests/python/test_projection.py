"""Projection maps (DESIGN section 4) save photons and change no mean: on against off, and against solid angles."""

import numpy as np
import pytest
from oracles import cross_room
from support import scenes

import cpm

SEEDS = range(16)


def landed(scene, count, seed, projection, mask):
    """Direct power of the photons in `mask`, W/nm."""
    photons = cpm.trace_photons(scene, count, seed=seed, wavelengths=[550.0], projection=projection)
    stored = photons.diffuse
    return stored.power[mask(stored), 0].sum()


def square_scene(half, medium=None):
    """A black square of half-edge `half`, 1 m under a point light of 1 W/sr/nm."""
    scene = cpm.Scene(medium=medium) if medium is not None else cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, half), (half, 0, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Point((0.0, 1.0, 0.0), 1.0))
    return scene


def solid_angle(half, distance=1.0):
    """Of a square seen from its axis: 4 asin(a²/(a² + d²))."""
    return 4 * np.arcsin(half**2 / (half**2 + distance**2))


# Without a map too few photons reach the smallest to compare anything.
@pytest.mark.parametrize(("half", "projection"), [(1.0, True), (0.1, True), (0.02, True), (1.0, False), (0.1, False)])
def test_power_on_a_square(half, projection):
    """Down to an object within one cell of the map: power = I Ω, z-test over seeds."""
    scene, expected = square_scene(half), solid_angle(half)
    found = [landed(scene, 20_000, seed, projection, lambda m: np.ones(len(m.power), bool)) for seed in SEEDS]
    spread = np.std(found, ddof=1) / np.sqrt(len(found))
    assert spread > 0, "no photon reaches the object"
    assert abs(np.mean(found) - expected) < 4 * spread, (np.mean(found), expected, spread)


def test_map_saves_photons():
    """With the map, far more of the photons arrive: that is what it is for."""
    scene = square_scene(0.1)
    stored = [
        len(cpm.trace_photons(scene, 20_000, seed=1, wavelengths=[550.0], projection=p).diffuse.power)
        for p in (True, False)
    ]
    assert stored[0] > 5 * stored[1]


def test_object_within_one_cell_beside_a_large_one():
    """Inactive cells keep a chance: a 4 cm square no corner ray meets still gets its mean, whatever lies elsewhere."""
    scene, half = square_scene(1.0), 0.02
    center = np.array((0.0, 1.0, 0.0)) + np.array((0.013, 1.0, 0.017))  # above the light, facing it
    scene.add_mesh(*scenes.rectangle(center, (half, 0, 0), (0, 0, half)), material=cpm.materials.Diffuse(0.0))
    power, squares = 0.0, 0.0
    for seed in range(8):
        stored = cpm.trace_photons(scene, 200_000, seed=seed, wavelengths=[550.0], projection=True).diffuse
        w = stored.power[stored.position[:, 1] > 1.5, 0].astype(float)
        power, squares = power + w.sum() / 8, squares + np.sum(w**2) / 64
    assert power > 0, "the small square never receives a photon"
    assert abs(power - solid_angle(half)) < 4 * np.sqrt(squares) + 0.01 * solid_angle(half)


@pytest.mark.parametrize("name", ["straight", "curved"])
def test_room_has_the_same_mean(name):
    """Power on the floor and on the walls, interreflections included, map on against off (z of the difference)."""
    scene = scenes.room(None if name == "straight" else scenes.curved_medium(), scenes.PAINTED)

    def places(photon_map):
        r = photon_map.position
        inside = (np.abs(r[:, 0]) < 1.999) & (np.abs(r[:, 2]) < 1.999)
        return [inside & (r[:, 1] < 1e-3), inside & (r[:, 1] > 3.999), (r[:, 2] < -1.999), (r[:, 2] > 1.999)]

    sums = {True: [], False: []}
    for projection in sums:
        for seed in SEEDS:
            stored = cpm.trace_photons(
                scene, 20_000, seed=seed + 100 * projection, wavelengths=[550.0], projection=projection
            ).diffuse
            sums[projection].append([stored.power[m, 0].sum() for m in places(stored)])
    on, off = np.array(sums[True]), np.array(sums[False])
    z = (on.mean(0) - off.mean(0)) / np.sqrt((on.var(0, ddof=1) + off.var(0, ddof=1)) / len(SEEDS))
    assert np.all(np.abs(z) < 4), z
    oracle = cross_room.STRAIGHT if name == "straight" else cross_room.CURVED
    assert on[:, 0].mean() > oracle.floor_power(400)  # direct, and more


def test_caustic_map_of_a_small_sphere():
    """A glass sphere of 3 cm under a point light: caustic power is its solid angle, less what reflects up."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 3), (3, 0, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_sphere((0.4, 0.5, 0.2), 0.03, material=cpm.materials.Dielectric(1.5))
    light = np.array((0.0, 3.0, 0.0))
    scene.add_light(cpm.lights.Point(light, 1.0))
    found = []
    for seed in range(8):
        caustic = cpm.trace_photons(scene, 40_000, seed=seed, wavelengths=[550.0], projection=True).caustic
        found.append(caustic.power[:, 0].sum() if len(caustic.power) else 0.0)
    distance = np.linalg.norm(light - (0.4, 0.5, 0.2))
    cone = 2 * np.pi * (1 - np.sqrt(1 - (0.03 / distance) ** 2))
    assert np.mean(found) > 0
    # 4 % to 9 % of it is reflected, of which a part lands on the 6 m floor.
    spread = 4 * np.std(found, ddof=1) / np.sqrt(len(found))
    assert 0.88 * cone - spread < np.mean(found) < cone + spread
