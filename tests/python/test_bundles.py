"""Bundles that stay together within a tolerance where a medium disperses (docs/decisions/0011).

The closed forms that each bin is held against are in tests/c/test_bundles.c; here is what must hold in whole pictures.
"""

from pathlib import Path

import numpy as np
import pytest
from support import scenes

import cpm

WAVELENGTHS = np.linspace(410, 690, 16)
RED = ([400, 560, 620, 700], [0.05, 0.08, 0.60, 0.64])
OPTIONS = dict(size=(40, 30), photons=20_000, nearest=50, wavelengths=WAVELENGTHS, seed=3)


GREEN = ([499, 500, 600, 601], [0.0, 100.0, 100.0, 0.0])


def room(dispersion, n_squared=1.69, gradient=-0.10, glass=False, intensity=100.0):
    """The painted room in a linear n² that disperses."""
    medium = cpm.media.LinearSquared(n_squared, gradient=(0, gradient, 0), dispersion=dispersion)
    scene = scenes.room(medium, {"white": 0.75, "red": RED, "green": 0.15}, intensity)
    if glass:
        scene.add_sphere((-0.8, 0.5, 0.0), 0.4, material=cpm.materials.Dielectric("F2"))
        mirror = scenes.rectangle((0.8, 0.8, 0.0), (0, 0, 0.8), (0.2, 0.8, 0))
        scene.add_mesh(*mirror, material=cpm.materials.Mirror(0.9))
    return scene


def layered(strength=1.0):
    """Integrated paths: n(y) of the curved room, as a table."""
    heights = np.linspace(-10, 10, 101)
    return cpm.media.Layered(heights, 1.2 - 0.02 * strength * heights, dispersion="BK7")


@pytest.mark.parametrize("glass", [False, True])
@pytest.mark.parametrize("intensity", [100.0, GREEN], ids=["white", "green"])
def test_next_to_nothing_is_nothing(glass, intensity):
    """A tolerance below everything parts all bundles: the picture without, to the last bit, dark bins too."""
    scene = room("BK7", glass=glass, intensity=intensity)
    none = cpm.render(scene, bundle_tolerance=0, **OPTIONS)
    least = cpm.render(scene, bundle_tolerance=1e-9, **OPTIONS)
    np.testing.assert_array_equal(none.data, least.data)
    for key in ("photons_stored_direct", "photons_stored_later", "photons_stored_caustic", "gathers"):
        assert none.stats[key] == least.stats[key]
        assert none.stats[key] > 0 or (key == "photons_stored_caustic" and not glass)


@pytest.mark.parametrize("dispersion", [None, "air"])
def test_weak_dispersion_costs_what_none_does(dispersion):
    """Air over 8 m: one path for all bins, three followed; the picture is that of the middle bin's n, nearly."""
    image = cpm.render(room(dispersion, 1.00056, -2e-5), bundle_tolerance=0.1, **OPTIONS)
    assert image.stats["gathers"] <= 1200
    assert image.stats["eye_segments"] == (1200 if dispersion is None else 3600)
    stored = image.stats["photons_stored_direct"]
    assert stored == pytest.approx(19_400, rel=0.03)


@pytest.mark.parametrize("make", [lambda: room("F2"), lambda: room("BK7", glass=True),
                                  lambda: scenes.room(layered(), scenes.PAINTED)], ids=["curved", "glass", "layered"])
def test_same_bits(make):
    """Any threads, any batch."""
    first = cpm.render(make(), threads=1, **OPTIONS)
    stored = first.stats["photons_stored_direct"]
    assert 19_500 < stored < 16 * 19_000  # some stay together, some part
    for options in ({"threads": 2}, {"threads": 2, "batch": 333}):
        np.testing.assert_array_equal(first.data, cpm.render(make(), **options, **OPTIONS).data)


@pytest.mark.parametrize("tolerance", [0.01, 0.1, 1.0])
def test_energy(tolerance):
    """The books balance in every bin, and what is emitted does not depend on the tolerance."""
    scene = room("F2", glass=True)
    energy = cpm.trace_photons(scene, 20_000, seed=1, wavelengths=WAVELENGTHS, bundle_tolerance=tolerance).energy
    left = energy["emitted"] + energy["roulette_gain"]
    right = energy["absorbed"] + energy["escaped"] + energy["roulette_loss"]
    np.testing.assert_allclose(left, right, rtol=1e-6)
    alone = cpm.trace_photons(scene, 20_000, seed=1, wavelengths=WAVELENGTHS, bundle_tolerance=0).energy
    np.testing.assert_allclose(energy["emitted"], alone["emitted"], rtol=1e-9)
    net = energy["roulette_gain"] - energy["roulette_loss"]
    assert np.all(np.abs(net) < 4.5 * np.sqrt(energy["roulette_variance"]))


@pytest.mark.parametrize("tolerance", [0.0, 0.1, 5.0])
def test_furnace(tolerance):
    """Basic radiance 1 in every bin, with n of that bin at the light, at the surface and at the camera."""
    wavelengths, origin = np.array([420.0, 480.0, 550.0, 620.0, 680.0]), (0.1, 0.3, 0.2)
    medium = cpm.media.LinearSquared(1.69, (0.2, -0.4, 0.1), dispersion=cpm.dispersion.Cauchy(1.5, 0.02))
    image = cpm.render(scenes.furnace(medium), size=(40, 30), photons=80_000, nearest=100, wavelengths=wavelengths,
                       seed=2, max_radius=1.0, bundle_tolerance=tolerance)
    n = np.array([float(medium.evaluate(origin, w)[0].item()) for w in wavelengths])
    assert n[0] / n[-1] > 1.01
    basic = (image.data / n**2).mean(axis=(0, 1))
    np.testing.assert_allclose(basic, 1.0, rtol=0, atol=0.008)
    if tolerance == 5.0:
        assert image.stats["gathers"] == 1200


def test_means_agree():
    """Mean radiance of each bin with bundles together and apart: the same within 4σ over seeds.

    All photons within 15 cm, so that the discs are the same however many photons a path has become.
    """
    def mean(tolerance, seed):
        changed = {"seed": seed, "photons": 10_000, "nearest": 1_000_000, "max_radius": 0.15}
        image = cpm.render(room("BK7"), bundle_tolerance=tolerance, **OPTIONS | changed)
        return image.data.mean(axis=(0, 1))

    apart = np.array([mean(0.0, seed) for seed in range(8)])
    together = np.array([mean(0.1, seed + 100) for seed in range(8)])
    sigma = np.sqrt((apart.var(axis=0, ddof=1) + together.var(axis=0, ddof=1)) / 8)
    difference = together.mean(axis=0) - apart.mean(axis=0)
    assert np.all(np.abs(difference) < 4 * sigma), difference / sigma
    assert np.all(sigma < 0.02 * apart.mean(axis=0))


def test_colours_land_where_they_should():
    """A pencil of light in a strong gradient: the centre of each bin's photons, against the parabola of that bin.

    The centre is off by the tolerance at most, 40 circles of an estimate, which are a millimetre across.
    """
    medium = cpm.media.LinearSquared(1.69, (0, -0.3, 0), dispersion=cpm.dispersion.Cauchy(1.45, 0.012))
    scene = cpm.Scene(medium=medium)
    scene.add_mesh(*scenes.rectangle((5, 0, 0), (0, 0, 8), (8, 0, 0)), material=cpm.materials.Diffuse(0.0))
    scene.add_light(cpm.lights.Spot((0, 1, 0), (1, 1.2, 0), cutoff=0.05, intensity=1.0))
    photons = cpm.trace_photons(scene, 4000, seed=1, wavelengths=WAVELENGTHS, bundle_tolerance=40, projection=False)
    where, power = np.asarray(photons.diffuse.position, float), np.asarray(photons.diffuse.power, float)
    center = (power.T @ where) / power.sum(axis=0)[:, None]
    n = [float(medium.evaluate((0, 1, 0), w)[0].item()) for w in WAVELENGTHS]
    direction = np.array((1, 0.2)) / np.hypot(1, 0.2)
    d_line = 1.69 - 1
    for i, w in enumerate(WAVELENGTHS):
        scale = (n[i] ** 2 - 1) / (d_line - 0.3)  # n² − 1 at y = 1
        g = -0.5 * scale * 0.3
        p = n[i] * direction
        sigma = (-p[1] - np.sqrt(p[1] ** 2 - 2 * g * 1.0)) / g
        x = sigma * p[0]
        radius = np.hypot(x, 1) * np.radians(0.05) * np.sqrt(150 / 4000)
        assert abs(center[i, 0] - x) < 40 * radius + 6 * np.hypot(x, 1) ** 2 * np.radians(0.05) / np.sqrt(4000), w
    assert np.ptp(center[:, 0]) > 0.2  # colours do part: by more than the tolerance
    assert 4000 < len(where) < 16 * 4000


@pytest.mark.parametrize(("value", "error", "words"), [
    (-0.1, ValueError, "bundle_tolerance is -0.1; 0 to 100"), (np.nan, ValueError, "bundle_tolerance"),
    (101, ValueError, "bundle_tolerance is 101; 0 to 100"), ("some", TypeError, "bundle_tolerance")])
def test_nonsense(value, error, words):
    for run in (lambda: cpm.render(room("air"), size=(4, 3), photons=10, bundle_tolerance=value),
                lambda: cpm.trace_photons(room("air"), 10, bundle_tolerance=value)):
        with pytest.raises(error, match=words):
            run()


def test_command_line(tmp_path, monkeypatch, capsys):
    """--bundle-tolerance is render's; nonsense is bad input."""
    from cpm.cli.program import run

    monkeypatch.chdir(tmp_path)
    scene = str(Path(__file__).parents[2] / "examples" / "glass_caustic.toml")
    small = ["--size", "8x6", "--photons", "2000", "--quiet", "-o"]
    assert run(["render", scene, "--bundle-tolerance", "0", *small, "apart.exr"]) == 0
    assert run(["render", scene, "--bundle-tolerance", "50", *small, "together.exr"]) == 0
    expected = cpm.render(cpm.load_scene(scene), size=(8, 6), photons=2000, bundle_tolerance=50).data
    np.testing.assert_array_equal(cpm.Image.load("together.exr").data, expected)
    assert not np.array_equal(cpm.Image.load("apart.exr").data, expected)
    assert run(["render", scene, "--bundle-tolerance", "-1", *small, "no.exr"]) == 2
    assert "bundle_tolerance is -1; 0 to 100" in capsys.readouterr().err and not Path("no.exr").exists()


def test_scene_file_says_it(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text('[render]\nbundle_tolerance = 0.25\n')
    assert cpm.load_scene(path).render_defaults.bundle_tolerance == 0.25
    path.write_text('[render]\nbundle_tolerance = -1\n')
    with pytest.raises(ValueError, match=r"render\.bundle_tolerance"):
        cpm.load_scene(path)


@pytest.mark.filterwarnings("ignore:the picture is black")  # the wide one misses the Sun
def test_the_sky_through_air():
    """The Sun's limb at 5″ a pixel: directions of rays that leave are compared with the pixel. Next to no tolerance: the
    same bits; a tenth of a pixel moves no limb by more; wide pixels share paths."""
    scene = cpm.Scene(cpm.media.Atmosphere(cpm.atmosphere.USStandard1976()), rtol=1e-9)
    scene.add_sphere((0, -6371e3, 0), 6371e3, material=cpm.materials.Black())
    scene.add_light(cpm.lights.Sun(elevation=-0.8, azimuth=0.0))
    toward = np.array([0.0, np.sin(np.radians(0.04)), -np.cos(np.radians(0.04))])
    scene.camera = cpm.Camera.look_at((0, 10, 0), (0, 10, 0) + toward, fov=6 * 5 / 3600)
    options = dict(size=(6, 120), photons=0, samples=4, wavelengths=np.linspace(410, 690, 8))
    apart, least, tenth = (cpm.render(scene, bundle_tolerance=tolerance, **options).data
                           for tolerance in (0.0, 1e-9, 0.1))
    np.testing.assert_array_equal(apart, least)
    assert np.all(apart[0] == 0) and np.all(apart[-1] > 0)  # from above the limb to below it
    steep = np.abs(np.diff(apart, axis=0)).max(axis=(0, 1))  # from one pixel to the next
    assert np.all(np.abs(tenth - apart).max(axis=(0, 1)) <= 0.3 * steep)
    scene.camera = cpm.Camera.look_at((0, 10, 0), (0, 10, 0) + toward, fov=20.0)
    wide = cpm.render(scene, bundle_tolerance=0.1, **options)
    assert wide.stats["eye_segments"] < 0.5 * 8 * 4 * 6 * 120
