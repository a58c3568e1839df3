"""Energy balance (DESIGN section 13): emitted + roulette gain = absorbed + escaped + roulette loss, to 1e-6.

Gain − loss is the roulette's noise: zero on the average, judged over independent seeds.
"""

import numpy as np
import pytest
from oracles import cross_room
from support import scenes, statistics

import cpm

WAVELENGTHS = [450.0, 550.0, 620.0]
RED = ([400, 560, 620, 700], [0.05, 0.08, 0.60, 0.64])
GREEN = ([400, 500, 550, 620, 700], [0.10, 0.25, 0.45, 0.15, 0.10])


def coloured(medium):
    return scenes.room(medium, {"white": 0.75, "red": RED, "green": GREEN})


def with_glass(medium):
    """A mirror and a dispersive glass sphere in the room: splits, total reflection, paths that leave."""
    scene = coloured(medium)
    scene.add_sphere((-0.6, 0.5, 0.0), 0.45, material=cpm.materials.Dielectric(cpm.dispersion.Cauchy(1.6, 0.01)))
    scene.add_mesh(*scenes.rectangle((0.8, 0.8, 0.0), (0, 0, 0.8), (0.2, 0.8, 0)), material=cpm.materials.Mirror(0.9))
    return scene


SCENES = {
    "straight": lambda: coloured(cpm.media.Homogeneous(1.0)),
    "curved": lambda: coloured(scenes.curved_medium()),
    "glass": lambda: with_glass(cpm.media.Homogeneous(1.0)),
    "glass-curved": lambda: with_glass(scenes.curved_medium()),
    "furnace": lambda: scenes.furnace(cpm.media.LinearSquared(1.69, gradient=(0.2, -0.4, 0.1))),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("projection", [True, False])
def test_balance(name, projection):
    energy = cpm.trace_photons(SCENES[name](), 50_000, seed=1, wavelengths=WAVELENGTHS, projection=projection).energy
    terms = {
        key: np.asarray(energy[key], float)
        for key in ("emitted", "roulette_gain", "absorbed", "escaped", "roulette_loss")
    }
    for key, value in terms.items():
        assert value.shape == (3,), key
        assert np.all(value >= 0) and np.all(np.isfinite(value)), key
    left, right = (
        terms["emitted"] + terms["roulette_gain"],
        terms["absorbed"] + terms["escaped"] + terms["roulette_loss"],
    )
    np.testing.assert_allclose(left, right, rtol=1e-6)
    assert np.all(terms["absorbed"] > 0.01 * terms["emitted"])


@pytest.mark.parametrize("name", ["curved", "glass"])
def test_roulette_is_unbiased(name):
    """gain − loss over 12 seeds: |z| < 4 at each wavelength; and it is not trivially zero in colour."""
    scene = SCENES[name]()
    net = []
    for seed in range(12):
        energy = cpm.trace_photons(scene, 20_000, seed=seed, wavelengths=WAVELENGTHS).energy
        net.append((np.asarray(energy["roulette_gain"]) - energy["roulette_loss"]) / energy["emitted"])
    assert np.all(np.abs(statistics.z_of_mean(net, 0.0)) < 4), np.mean(net, axis=0)
    assert np.max(np.abs(net)) > 0


def test_variance_of_the_books():
    """`roulette_variance` is that of gain − loss: the spread over seeds, within a χ² of 39 degrees of freedom."""
    scene, net, variance = SCENES["curved"](), [], []
    for seed in range(40):
        energy = cpm.trace_photons(scene, 5000, seed=seed, wavelengths=[450.0]).energy
        net.append(float(energy["roulette_gain"][0] - energy["roulette_loss"][0]))
        variance.append(float(energy["roulette_variance"][0]))
    assert 0.4 < np.var(net, ddof=1) / np.mean(variance) < 2.0


def test_emitted_is_the_spots_power():
    """Without projection the photons carry I·2π(1 − cos 14°) together, exactly."""
    energy = cpm.trace_photons(SCENES["straight"](), 20_000, seed=1, wavelengths=WAVELENGTHS, projection=False).energy
    power = cross_room.INTENSITY * 2 * np.pi * (1 - np.cos(cross_room.HALF_ANGLE))
    np.testing.assert_allclose(energy["emitted"], power, rtol=1e-6)


def test_open_scene_escapes():
    """A point light over one black square: absorbed is the square's solid angle, the rest escapes."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Point((0, 1, 0), 2.0))
    energy = cpm.trace_photons(scene, 60_000, seed=1, wavelengths=[550.0], projection=False).energy
    sphere, square = 8 * np.pi, 2 * 4 * np.arcsin(0.5)  # a cube's face seen from its centre: 4π/6 sr
    assert square == pytest.approx(sphere / 6)
    error = 4 * sphere * np.sqrt(5 / 36 / 60_000)
    assert energy["absorbed"][0] == pytest.approx(square, abs=error)
    assert energy["escaped"][0] == pytest.approx(sphere - square, abs=error)


@pytest.mark.parametrize("powers, photons", [((1.0, 1.0, 1.0, 1.0, 1.0), 2), ((4.0, 1.0, 0.5, 0.0, 2.5, 3.0), 3)])
def test_fewer_photons_than_lights(powers, photons):
    """No power is lost: what is emitted is the lights' together for every seed, and each light's own on average."""
    spectra = [([500, 600], [power, 0.0] if i % 2 else [0.0, power]) for i, power in enumerate(powers)]
    scene = cpm.Scene()
    scene.add_mesh(*scenes.box_mesh((-1, -1, -1), (1, 1, 1)), cpm.materials.Black())
    for spectrum in spectra:
        scene.add_light(cpm.lights.Point((0.1, 0.2, 0.3), spectrum))
    emitted = []
    for seed in range(400):
        energy = cpm.trace_photons(scene, photons, seed=seed, wavelengths=[500, 600]).energy
        np.testing.assert_allclose(energy["emitted"].sum(), 4 * np.pi * sum(powers), rtol=1e-6)
        np.testing.assert_allclose(energy["absorbed"], energy["emitted"], rtol=1e-6)
        emitted.append(energy["emitted"])
    mean, spread = np.mean(emitted, axis=0), np.std(emitted, axis=0) / 20
    truth = 4 * np.pi * np.array([sum(powers[1::2]), sum(powers[::2])])
    assert np.all(np.abs(mean - truth) < 4.5 * spread), (mean / truth, spread / truth)  # false alarm 1e-5


def test_a_faint_last_light_has_a_path():
    """Three photons, three lights, the last 1e-9 of the others: it is not forgotten (its bin is its own)."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.box_mesh((-1, -1, -1), (1, 1, 1)), cpm.materials.Black())
    for spectrum in ([1.0, 0.0], [1.0, 0.0], [0.0, 1e-9]):
        scene.add_light(cpm.lights.Point((0, 0, 0), ([500, 600], spectrum)))
    energy = cpm.trace_photons(scene, 3, wavelengths=[500, 600]).energy
    np.testing.assert_allclose(energy["emitted"], 4 * np.pi * np.array([2.0, 1e-9]), rtol=1e-5)
