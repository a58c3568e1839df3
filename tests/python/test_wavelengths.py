"""Bins of equal width, refraction and contribution; colour through uneven bins, against dense integrals."""

import numpy as np
import pytest
from scipy import integrate, interpolate

import cpm
from cpm import wavelengths

BINS = (8, 16, 32)


def observer(w):
    """CIE 1931, 2°, from colour-science's 1 nm table."""
    import colour

    table = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    return np.stack([np.interp(w, table.wavelengths, table.values[:, i]) for i in range(3)], axis=-1)


def xyz_of(spectrum, low=400.0, high=700.0):
    """Dense integral, 0.01 nm."""
    w = np.linspace(low, high, 30001)
    return 683.0 * integrate.trapezoid(observer(w) * spectrum(w)[:, None], w, axis=0)


def through_film(spectrum, bins):
    image = cpm.Image(spectrum(np.asarray(bins))[None, None], bins)
    return image.to_xyz()[0, 0]


def relative(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


SAMPLERS = {
    "equal": wavelengths.equal,
    "refraction": lambda low, high, n: wavelengths.by_refraction(cpm.dispersion.Air(), low, high, n),
    "contribution": lambda low, high, n: wavelengths.by_contribution(low, high, n, illuminant="D65"),
}


def test_equal_is_what_it_was():
    bins = wavelengths.equal(400, 700, 16)
    np.testing.assert_allclose(bins.centers, 409.375 + 18.75 * np.arange(16), rtol=1e-15)
    np.testing.assert_allclose(bins.widths, 18.75, rtol=1e-12)
    np.testing.assert_allclose(cpm.bin_centers(400, 700, 16), bins, rtol=1e-15)


@pytest.mark.parametrize("n", [1, 5, 16, 64])
def test_refraction_of_air_in_equal_steps(n):
    """Refraction at the edges, asked anew: equal steps to 1e-3."""
    profile = cpm.atmosphere.Polytropic(288.15, 101325.0)
    bins = wavelengths.by_refraction(profile, 400, 700, n)
    there = cpm.atmosphere.refraction(profile, 90.0, bins.edges)
    np.testing.assert_allclose(np.diff(there), (there[-1] - there[0]) / n, rtol=1e-3)
    assert np.all(np.diff(bins.widths) > 0)  # violet is refracted the more
    np.testing.assert_allclose(bins.centers, 0.5 * (bins.edges[1:] + bins.edges[:-1]), rtol=1e-15)


def test_refraction_of_glass():
    """Against the inverse of the formula, by SciPy."""
    model = cpm.dispersion.catalogue("F2")
    fine = np.linspace(400, 700, 200_001)
    inverse = interpolate.interp1d(model.n(fine)[::-1], fine[::-1])
    expected = inverse(np.linspace(model.n(400.0), model.n(700.0), 13)[1:-1])
    for what in (model, cpm.media.Homogeneous("F2"), cpm.media.Linear(1.3, (0, -0.1, 0), dispersion="F2"),
                 lambda w: 5 * model.n(w)):
        bins = wavelengths.by_refraction(what, 400, 700, 12)
        np.testing.assert_allclose(bins.edges[1:-1], expected, rtol=0, atol=0.01)


def test_refraction_by_step():
    """Young's 2″: as few bins as keep every step below it."""
    profile = cpm.atmosphere.Polytropic(288.15, 101325.0)
    bins = wavelengths.by_refraction(profile, 400, 700, step=2 / 3600)
    steps = -3600 * np.diff(cpm.atmosphere.refraction(profile, 90.0, bins.edges))
    assert steps.max() <= 2.0 + 1e-3 and steps.sum() > 2.0 * (len(bins) - 1)


def test_refraction_that_turns():
    """A function with a minimum: bins cross it, and the sum of changes is shared out."""
    bins = wavelengths.by_refraction(lambda w: (w - 550.0) ** 2, 450, 650, 10)
    np.testing.assert_allclose(bins.edges, np.sort(np.concatenate(
        [550 - 100 * np.sqrt(np.arange(5, 0, -1) / 5), [550], 550 + 100 * np.sqrt(np.arange(1, 6) / 5)])), atol=0.1)


@pytest.mark.parametrize("which", ["xyz", "y"])
def test_contribution_is_shared_out(which):
    """Each bin holds the same of illuminant × observer × transmission, and half of it on either side of its centre."""
    def transmission(w):
        return np.exp(-2 * (550 / w) ** 4)

    bins = wavelengths.by_contribution(400, 700, 12, illuminant="A", observer=which, transmission=transmission,
                                       spread=0)
    lamp = cpm.spectra.as_spectrum("A")

    def total(low, high):
        w = np.linspace(low, high, 4001)
        seen = observer(w).sum(axis=1) if which == "xyz" else observer(w)[:, 1]
        return integrate.trapezoid(lamp.at(w) * seen * transmission(w), w)

    parts = [total(low, high) for low, high in zip(bins.edges[:-1], bins.edges[1:], strict=True)]
    np.testing.assert_allclose(parts, total(400, 700) / 12, rtol=2e-3)
    halves = [total(low, center) for low, center in zip(bins.edges[:-1], bins.centers, strict=True)]
    np.testing.assert_allclose(halves, np.array(parts) / 2, rtol=4e-3)


def test_spread_bounds_the_widest():
    even = wavelengths.by_contribution(400, 700, 16, observer="y", spread=0.2)
    bare = wavelengths.by_contribution(400, 700, 16, observer="y", spread=0.0)
    assert even.widths.max() < 300 / (0.2 * 16) + 1e-9 < bare.widths.max()
    np.testing.assert_allclose(wavelengths.by_contribution(400, 700, 16, spread=1.0).edges,
                               wavelengths.equal(400, 700, 16).edges, atol=0.1)


@pytest.mark.parametrize("name", SAMPLERS)
@pytest.mark.parametrize("n", BINS)
def test_flat_and_tilted_spectra_keep_their_colour(name, n):
    """What is linear in wavelength is integrated to 1e-4 in uneven bins, however uneven, and to 1.2e-3 in equal ones
    (constant in each, as ever); times the illuminant where bins are shaped by it."""
    bins = SAMPLERS[name](400, 700, n)
    lamp = cpm.spectra.as_spectrum("D65" if name == "contribution" else 1.0).at
    assert relative(through_film(lamp, bins), xyz_of(lamp)) < 1e-5
    for tilted in (lambda w: lamp(w) * (1 - (w - 550) / 200), lambda w: lamp(w) * (1 + (w - 550) / 200)):
        error = relative(through_film(tilted, bins), xyz_of(tilted))
        assert error < (1.2e-3 * (8 / n) ** 2 if name == "equal" else 1e-4)


def test_light_that_falls_by_orders_of_magnitude():
    """The Sun through 30 atmospheres of molecules in 4 bins: shaped by it, exact; equal bins are 1 % off."""
    def light(w):
        return np.exp(-30 * 0.0088 * (w / 1000) ** -4.05)

    w = np.arange(400.0, 701.0)
    shaped = wavelengths.by_contribution(400, 700, 4, illuminant=(w, light(w)))
    assert relative(through_film(light, shaped), xyz_of(light)) < 1e-4
    assert relative(through_film(light, wavelengths.equal(400, 700, 4)), xyz_of(light)) > 1e-2


@pytest.mark.parametrize("name", SAMPLERS)
def test_smooth_spectra_converge(name):
    """A paint's edge, and a low Sun: second order in the number of bins."""
    for spectrum in (lambda w: 1 / (1 + np.exp((w - 560) / 15)), lambda w: np.exp(-3 * (550 / w) ** 4)):
        errors = [relative(through_film(spectrum, SAMPLERS[name](400, 700, n)), xyz_of(spectrum)) for n in (16, 32, 64)]
        assert errors[-1] < 1e-3 and errors[0] / errors[-1] > 6, errors


def test_centres_alone():
    """Without edges bins reach half-way: a list of centres, and an image from a file, are right to the first order."""
    centers = 400 + 300 * np.linspace(0.02, 1, 40) ** 1.5
    image = cpm.Image((1 + (centers - 550) / 300)[None, None], centers)
    edges = image.edges
    expected = xyz_of(lambda w: 1 + (w - 550) / 300, edges[0], edges[-1])
    assert relative(image.to_xyz()[0, 0], expected) < 1e-4


def test_films_keep_their_edges():
    """Through render, through photons traced before; a list of centres has none."""
    scene = cpm.Scene()
    scene.add_sphere((0, 0, 0), 1.0, material=cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Point((0, 3, 0), 1.0))
    scene.camera = cpm.Camera.look_at((0, 2, 3), (0, 0, 0))
    bins = wavelengths.by_contribution(bins=5)
    options = dict(size=(4, 3), photons=2000, nearest=10)
    image = cpm.render(scene, wavelengths=bins, **options)
    np.testing.assert_array_equal(image.edges, bins.edges)
    np.testing.assert_array_equal(image.wavelengths, bins.centers)
    photons = cpm.trace_photons(scene, 2000, wavelengths=bins)
    again = cpm.render(scene, photons=photons, size=(4, 3), nearest=10)
    np.testing.assert_array_equal(again.edges, bins.edges)
    np.testing.assert_allclose(again.to_xyz(), image.to_xyz(), rtol=1e-6)
    bare = cpm.render(scene, wavelengths=bins.centers, **options)
    np.testing.assert_array_equal(bare.data, image.data)
    assert not np.array_equal(bare.edges, bins.edges)
    assert cpm.Image(np.ones((1, 1, 1)), [550.0]).edges.shape == (2,)


FILE = """
[medium]
type = "homogeneous"
n = "air"
[[lights]]
type = "point"
position = [0, 1, 0]
intensity = "A"
[render]
wavelengths = { from = 420, to = 680, bins = 9, sampling = "%s" }
"""


@pytest.mark.parametrize("sampling", wavelengths.SAMPLINGS)
def test_scene_files(tmp_path, sampling):
    path = tmp_path / "scene.toml"
    path.write_text(FILE % sampling)
    found = cpm.load_scene(path).render_defaults.wavelengths
    expected = {"equal": lambda: wavelengths.equal(420, 680, 9),
                "refraction": lambda: wavelengths.by_refraction(cpm.dispersion.catalogue("air"), 420, 680, 9),
                "contribution": lambda: wavelengths.by_contribution(420, 680, 9, illuminant="A")}[sampling]()
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    if sampling != "equal":
        np.testing.assert_allclose(found.edges, expected.edges, rtol=1e-6)


@pytest.mark.parametrize(("text", "words"), [
    (FILE % "random", "render.wavelengths.*sampling"),
    ((FILE % "refraction").replace('"air"', "1.0"), "render.wavelengths.*nothing in the scene disperses")])
def test_bad_scene_files(tmp_path, text, words):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=words):
        cpm.load_scene(path)


@pytest.mark.parametrize(("run", "error", "words"), [
    (lambda: wavelengths.equal(700, 400), ValueError, "700 to 400 nm"),
    (lambda: wavelengths.equal(400, 700, 0), ValueError, "bins is 0"),
    (lambda: wavelengths.equal(400, 700, 257), ValueError, "bins is 257"),
    (lambda: wavelengths.by_refraction(cpm.media.Homogeneous(1.5)), ValueError, "does not disperse"),
    (lambda: wavelengths.by_refraction(1.5), TypeError, "a profile, a medium"),
    (lambda: wavelengths.by_refraction(cpm.dispersion.Air(), bins=4, step=1e-7), ValueError, "one of them"),
    (lambda: wavelengths.by_refraction(cpm.dispersion.Air(), step=-1.0), ValueError, "step is -1"),
    (lambda: wavelengths.by_refraction(cpm.dispersion.Air(), step=1e-12), ValueError, "256 are allowed"),
    (lambda: wavelengths.by_refraction(lambda w: np.full(w.shape, np.nan)), ValueError, "refraction is nan at 400 nm"),
    (lambda: wavelengths.by_refraction(lambda w: 1.0), ValueError, "gave shape"),
    (lambda: wavelengths.by_contribution(illuminant=0.0), ValueError, "nothing is seen"),
    (lambda: wavelengths.by_contribution(illuminant=([400, 700], [1, -1])), ValueError, "must be finite and >= 0"),
    (lambda: wavelengths.by_contribution(spread=2), ValueError, "spread is 2"),
    (lambda: wavelengths.Bins([400, 500, 500]), ValueError, r"edges\[2\] is 500 nm after 500"),
    (lambda: wavelengths.Bins([400, 500], [510]), ValueError, r"centers\[0\] is 510 nm; it must be within"),
    (lambda: wavelengths.Bins([400]), ValueError, "2 to 257 edges"),
    (lambda: wavelengths.Bins([400, 500], shape=lambda w: 0 * w), ValueError, "shape is not above 0"),
])
def test_nonsense(run, error, words):
    with pytest.raises(error, match=words):
        run()
