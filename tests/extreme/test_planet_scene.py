"""A room on a planet: the Earth in the scene costs neither hits nor the photons' places.

Float with an Earth's radius in it resolves half a metre. Oracle: the same room without the planet, whose ground it does
not touch.
"""
import numpy as np
import pytest

import cpm

EARTH = 6.371e6


def room(planet, medium):
    scene = cpm.Scene(medium=medium)
    v = [(-2, 0.5, -2), (2, 0.5, -2), (2, 0.5, 2), (-2, 0.5, 2)]
    scene.add_mesh(v, [(0, 2, 1), (0, 3, 2)], material=cpm.materials.Diffuse(0.75))
    post = [(x, y, 0.3) for x, y in ((-0.5, 0.5), (0.5, 0.5), (0.5, 1.5), (-0.5, 1.5))]
    scene.add_mesh(post, [(0, 1, 2), (0, 2, 3)], material=cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Point((0.4, 3.0, 1.5), 10.0))
    scene.camera = cpm.Camera.look_at((1.0, 2.5, 3.5), (0, 0.7, 0), (0, 1, 0), fov=50.0)
    if planet:
        scene.add_sphere((0, -EARTH, 0), EARTH, material=cpm.materials.Black())
    return scene


@pytest.mark.parametrize("medium", [cpm.media.Homogeneous(1.0), cpm.media.LinearSquared(1.1, gradient=(0, -0.02, 0))],
                         ids=["straight", "curved"])
def test_a_planet_changes_no_room(medium):
    settings = {"size": (64, 48), "photons": 400_000, "nearest": 100, "wavelengths": [550.0], "seed": 4}
    alone, on_earth = (cpm.render(room(planet, medium), **settings) for planet in (False, True))
    # The planet takes photons too, so that the same seed gives other ones: means over the floor and the post agree.
    for rows in (slice(0, 24), slice(24, 48)):
        a, b = (image.data[rows].mean() for image in (alone, on_earth))
        assert a > 0
        assert b == pytest.approx(a, rel=0.04)
    assert np.isfinite(on_earth.data).all()


def test_rays_on_a_planet_meet_what_is_near_them():
    scene = room(True, cpm.media.Homogeneous(1.0))
    rng = np.random.default_rng(2)
    aims = np.column_stack([rng.uniform(-1.9, 1.9, 500), np.full(500, 0.5), rng.uniform(-1.9, 0.2, 500)])
    start = np.array([0.0, 1.0, -2.5])
    rays = cpm.trace(scene, start, aims - start, wavelength=550.0)
    assert (rays.status == cpm.RayStatus.HIT).all()
    assert np.abs(rays.position - aims).max() < 1e-8
