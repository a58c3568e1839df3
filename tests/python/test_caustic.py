"""A glass sphere's caustic against ray optics (`oracles.glass_sphere`): where the light goes, per wavelength.

Geometry of `examples/glass_caustic.toml`: sphere at (0, 1, 0), radius 0.5, point light at (0, 4, 0),
floor at `floor`.  The oracle sums external reflection, refraction and up to six internal reflections.
"""

from pathlib import Path

import numpy as np
import pytest
from oracles import glass_sphere, radiometry
from support import scenes

import cpm

WAVELENGTHS = [420.0, 550.0, 680.0]
PHOTONS = 300_000
GEOMETRY = dict(height=3.0, radius=0.5)


def glass_scene(floor, medium=None):
    """Floor 8 m wide at y = `floor`; BK7 by its Sellmeier formula, or another interior."""
    scene = cpm.Scene()
    interior = medium or cpm.dispersion.Sellmeier(radiometry.BK7_B, radiometry.BK7_C)
    scene.add_sphere((0, 1, 0), 0.5, material=cpm.materials.Dielectric(interior))
    scene.add_mesh(*scenes.rectangle((0, floor, 0), (0, 0, 4), (4, 0, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Point((0, 4, 0), 1.0))
    return scene


@pytest.fixture(scope="module", params=[0.0, 0.35])
def caustic(request):
    """(drop below the sphere's centre, caustic map), floor near the focus or before it."""
    photons = cpm.trace_photons(glass_scene(request.param), PHOTONS, seed=4, wavelengths=WAVELENGTHS)
    return 1.0 - request.param, photons.caustic


@pytest.mark.parametrize("wavelength", WAVELENGTHS)
def test_power_in_rings(caustic, wavelength):
    """Power between radii, z-test by the spread of the photons' own weights; noise of the bright ones below 10 %."""
    drop, stored = caustic
    edges = np.array([0, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.5])
    power = scenes.photons_of(stored, wavelength).astype(float)
    radius = np.hypot(stored.position[:, 0], stored.position[:, 2])
    n = float(radiometry.bk7(wavelength))
    expected = glass_sphere.ring_power(n, edges, drop=drop, **GEOMETRY)
    found = np.histogram(radius, bins=edges, weights=power)[0]
    spread = np.sqrt(np.histogram(radius, bins=edges, weights=power**2)[0])
    heaviest = power.max()
    # Where few photons are expected the sample's own spread is no guide: use the Poisson one.
    spread = np.maximum(spread, np.sqrt(expected * heaviest))
    assert np.all(np.abs(found - expected) < 4.5 * spread + 2e-3 * expected.sum()), (
        found / expected,
        spread / expected,
    )
    bright = expected > 0.15 * expected.sum()
    assert np.all(
        np.abs(found[bright] / expected[bright] - 1) < np.maximum(0.03, 4.5 * spread[bright] / expected[bright])
    )
    assert np.all(spread[bright] < 0.1 * expected[bright]), "too few caustic photons to judge"


@pytest.mark.parametrize("caustic", [0.35], indirect=True)
def test_bright_ring(caustic):
    """Before the focus the fold is a bright ring: its radius against dρ/dθ = 0, per wavelength."""
    drop, stored = caustic
    edges = np.linspace(0.0, 0.3, 151)
    middle = 0.5 * (edges[1:] + edges[:-1])
    rings = []
    for wavelength in WAVELENGTHS:
        power = scenes.photons_of(stored, wavelength)
        radius = np.hypot(stored.position[:, 0], stored.position[:, 2])
        density = np.histogram(radius, bins=edges, weights=power)[0] / np.diff(edges**2)
        expected = glass_sphere.fold_radius(float(radiometry.bk7(wavelength)), drop=drop, **GEOMETRY)
        outside = middle > 0.6 * expected
        rings.append(middle[outside][np.argmax(density[outside])])
        assert rings[-1] == pytest.approx(expected, abs=0.006)


def test_colours_separate(caustic):
    """Blue is bent more than red: the rms radius of the refracted light differs as the oracle's does."""
    drop, stored = caustic

    def oracle_share(wavelength):
        p = glass_sphere.ring_power(float(radiometry.bk7(wavelength)), [0, 0.03, 0.4], drop=drop, **GEOMETRY)
        return p[0] / p.sum()

    def share(wavelength):
        radius = np.hypot(stored.position[:, 0], stored.position[:, 2])
        power = scenes.photons_of(stored, wavelength)
        return power[radius < 0.03].sum() / power[radius < 0.4].sum()

    blue, red = WAVELENGTHS[0], WAVELENGTHS[-1]
    assert share(blue) - share(red) == pytest.approx(oracle_share(blue) - oracle_share(red), abs=0.02)


def test_total_power():
    """All paths that reach a floor below the sphere: the power of the sphere's cone less what goes up."""
    scene = glass_scene(0.0, medium=1.5)
    photons = cpm.trace_photons(scene, 100_000, seed=2, wavelengths=[550.0])
    expected = glass_sphere.ring_power(1.5, [0, 3.99], drop=1.0, **GEOMETRY)[0]
    radius = np.hypot(photons.caustic.position[:, 0], photons.caustic.position[:, 2])
    found = photons.caustic.power[radius < 3.99, 0].sum()
    assert found == pytest.approx(expected, rel=0.02)


def test_irradiance_on_the_axis():
    """The peak: caustic irradiance averaged over a small disc on the axis, from the k-NN estimate."""
    photons = cpm.trace_photons(glass_scene(0.35, medium=1.5), PHOTONS, seed=3, wavelengths=[550.0])
    rng = np.random.default_rng(1)
    r, phi = 0.05 * np.sqrt(rng.uniform(size=400)), rng.uniform(0, 2 * np.pi, 400)
    at = np.stack([r * np.cos(phi), np.full(400, 0.35), r * np.sin(phi)], axis=1)
    found = photons.caustic.irradiance(at, np.tile((0.0, 1.0, 0.0), (400, 1)), nearest=80)[:, 0].mean()
    expected = glass_sphere.ring_power(1.5, [0, 0.05], drop=0.65, **GEOMETRY)[0] / (np.pi * 0.05**2)
    assert found == pytest.approx(expected, rel=0.05)


def test_shadow_of_the_sphere():
    """Direct light has a hole where the sphere stands: no diffuse photon within the cone's shadow."""
    photons = cpm.trace_photons(glass_scene(0.0, medium=1.5), 50_000, seed=2, wavelengths=[550.0])
    shadow = 4 * np.tan(np.arcsin(0.5 / 3.0))
    radius = np.hypot(photons.diffuse.position[:, 0], photons.diffuse.position[:, 2])
    assert radius.min() > shadow - 2e-3
    assert np.all(photons.diffuse.bounce == 0)


def test_mirror_folds_the_beam():
    """A spot on a tilted mirror: caustic photons land where the mirrored spot would put them, with ρ of the power."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 1, 0), (0, 0, 1), (0.5, 0.5, 0)), material=cpm.materials.Mirror(0.8))
    scene.add_mesh(*scenes.rectangle((-4, 0, 0), (0, 0, 5), (0, 5, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Spot((0, 3, 0), (0, 1, 0), cutoff=5.0, intensity=1.0))  # straight down
    stored = cpm.trace_photons(scene, 20_000, seed=5, wavelengths=[550.0]).caustic
    power = 0.8 * 2 * np.pi * (1 - np.cos(np.radians(5)))
    assert stored.power[:, 0].sum() == pytest.approx(power, rel=0.01)
    # The mirror x = y − 1 swaps x and y − 1: the light's image is at (2, 1, 0), and (0, −1, 0) becomes (−1, 0, 0).
    offset = stored.position - (2.0, 1.0, 0.0)
    radius = np.hypot(offset[:, 1], offset[:, 2]) / np.abs(offset[:, 0])
    assert radius.max() == pytest.approx(np.tan(np.radians(5)), rel=0.01)
    assert np.mean(radius**2) == pytest.approx(np.tan(np.radians(5)) ** 2 / 2, rel=0.02)
    assert np.all(stored.bounce == 1)


def test_coloured_rim_of_the_close_up():
    """The shipped close-up: the density falls off a cliff where the folds of three colours are (its file's numbers)."""
    scene = cpm.load_scene(Path(__file__).resolve().parents[2] / "examples" / "glass_caustic_close.toml")
    waves = [450.0, 550.0, 650.0]
    stored = cpm.trace_photons(scene, 100_000, seed=2, wavelengths=waves).caustic
    radius = np.hypot(stored.position[:, 0], stored.position[:, 2])
    on_screen = np.abs(stored.position[:, 1] - 0.2) < 1e-4
    folds = []
    for wavelength in waves:
        fold = glass_sphere.fold_radius(float(radiometry.bk7(wavelength)), drop=0.8, **GEOMETRY)
        folds.append(abs(fold))
        power = scenes.photons_of(stored, wavelength).astype(float) * on_screen
        edges = abs(fold) + np.array([-6e-4, 0.0, 6e-4])
        inside, outside = np.histogram(radius, bins=edges, weights=power)[0] / np.diff(edges**2)
        assert inside > 5 * outside, (wavelength, inside, outside)
    np.testing.assert_allclose(folds, [0.0216, 0.0235, 0.0247], atol=1e-4)
