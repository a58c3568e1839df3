"""Spectra, dispersion and colour against published values and colour-science."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cpm
from cpm import dispersion
from cpm.spectra import as_spectrum

F_LINE, D_LINE, C_LINE = 486.1327, 587.5618, 656.2725

#: n_F, n_d, n_C of the data sheets, five decimals.
GLASSES = {
    "BK7": (1.52238, 1.51680, 1.51432),
    "F2": (1.63208, 1.62004, 1.61503),
    "SF11": (1.80645, 1.78472, 1.77599),
}


@pytest.mark.parametrize("name", GLASSES)
def test_glass_is_its_data_sheet(name):
    n = dispersion.catalogue(name).n([F_LINE, D_LINE, C_LINE])
    np.testing.assert_allclose(n, GLASSES[name], atol=6e-6)


def test_fused_silica_is_malitson_s_table():
    # Malitson (1965), table I: computed index at the lines g, d and C.
    n = dispersion.catalogue("fused silica").n([435.8343, 587.5618, 656.2725])
    np.testing.assert_allclose(n, [1.46669, 1.45846, 1.45637], atol=6e-6)


def test_air_is_ciddor_s_formula():
    wavelengths = np.linspace(230.0, 1690.0, 97)
    squared = (1e3 / wavelengths) ** 2
    refractivity = 0.05792105 / (238.0185 - squared) + 0.00167917 / (57.362 - squared)
    np.testing.assert_allclose(dispersion.catalogue("air").n(wavelengths) - 1.0, refractivity, rtol=1e-11)


def test_absolute_water_lies_above_relative_water():
    # 20 °C: 1.33299 relative to air at the sodium D line (CRC handbook), times n of air.
    water, air = dispersion.catalogue("water"), dispersion.catalogue("air")
    assert water.reference == "vacuum"
    assert water.n(589.3) == pytest.approx(1.33299 * air.n(589.3), abs=3e-5)


@pytest.mark.parametrize("name", ["BK7", "N-BK7", "n-bk7", "Fused Silica", "fused_silica", "sapphire", "diamond"])
def test_catalogue_says_where_it_comes_from(name):
    entry = dispersion.catalogue(name)
    assert entry.reference in ("air", "vacuum")
    assert len(entry.source) > 20
    low, high = entry.range
    assert np.isfinite(entry.n([low, high])).all()


def test_out_of_range_is_an_error_unless_asked_for():
    with pytest.raises(ValueError, match=r"200"):
        dispersion.catalogue("BK7").n(200.0)
    assert dispersion.catalogue("BK7", extrapolate=True).n(290.0) > 1.55
    assert dispersion.catalogue("BK7").n(290.0, extrapolate=True) > 1.55


def test_unknown_material_lists_the_known():
    with pytest.raises(ValueError, match=r"'unobtainium'.*BK7.*diamond"):
        dispersion.catalogue("unobtainium")


def test_cauchy_takes_nanometres_and_computes_in_micrometres():
    assert dispersion.Cauchy(1.5, 0.004).n(500.0) == pytest.approx(1.5 + 0.004 / 0.25, rel=1e-15)


def test_tabulated_is_linear_and_ends_at_its_ends():
    table = dispersion.Tabulated([400, 500, 700], [1.52, 1.51, 1.50])
    np.testing.assert_allclose(table.n([400, 450, 600, 700]), [1.52, 1.515, 1.505, 1.50], rtol=1e-14)
    with pytest.raises(ValueError, match="399"):
        table.n(399.0)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: dispersion.Cauchy(float("nan")), "nan"),
        (lambda: dispersion.Sellmeier([1, 2], [0.1]), "as many"),
        (lambda: dispersion.Tabulated([500, 400], [1.5, 1.5]), r"wavelengths\[1\]"),
        (lambda: dispersion.Constant(float("nan")), "nan"),
        (lambda: dispersion.catalogue("BK7").n([500.0, np.nan]), r"wavelength\[1\]"),
        (lambda: cpm.media.Homogeneous("BK7", dispersion="F2"), "one of them"),
    ],
)
def test_bad_dispersion_is_refused_by_name(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_spectrum_is_linear_between_and_held_beyond():
    spectrum = as_spectrum(([400, 500, 600], [0.1, 0.5, 0.3]))
    np.testing.assert_allclose(spectrum.at([300, 450, 500, 550, 900]), [0.1, 0.3, 0.5, 0.4, 0.3], rtol=1e-15)


@given(value=st.floats(0, 1e6), wavelength=st.floats(1, 1e5))
def test_a_number_is_flat(value, wavelength):
    assert as_spectrum(value).at(wavelength) == value


@pytest.mark.parametrize("name", ["D65", "A", "E", "FL2"])
def test_illuminants_are_one_at_560(name):
    assert as_spectrum(name).at(560.0) == pytest.approx(1.0, rel=1e-12)
    assert as_spectrum({"name": name, "scale": 50.0}).at(560.0) == pytest.approx(50.0, rel=1e-12)


def test_illuminant_a_is_planck_s():
    # CIE 15: A is a Planckian radiator at 2848 K with c2 = 1.435e-2 m K.
    def planck(nm):
        return nm**-5.0 / np.expm1(1.435e7 / (2848.0 * nm))

    wavelengths = np.array([400.0, 500.0, 620.0, 700.0])
    np.testing.assert_allclose(as_spectrum("A").at(wavelengths), planck(wavelengths) / planck(560.0), rtol=2e-4)


def test_colour_science_distributions_are_spectra():
    from colour import SpectralDistribution

    spectrum = as_spectrum(SpectralDistribution({400: 0.2, 500: 0.4, 600: 0.8}))
    assert spectrum.at(550.0) == pytest.approx(0.6)


def test_shipped_paints():
    # The Cornell box's white and red at 620 nm, as published.
    assert as_spectrum("cornell-white").at(620.0) == pytest.approx(0.744)
    assert as_spectrum("cornell-red").at(620.0) == pytest.approx(0.513)
    assert as_spectrum("cornell-green").at(500.0) == pytest.approx(0.285)


@pytest.mark.parametrize(
    "value, message",
    [
        ("no-such-light", "no-such-light.*cornell-white"),
        (([400, 500], [1.0]), "shape"),
        (([500, 400], [1.0, 1.0]), r"wavelengths\[1\]"),
        (([400, 500], [1.0, np.inf]), r"values\[1\]"),
        ({"scale": 2.0}, "name, or wavelengths"),
        ({"name": "D65", "colour": 1}, "colour"),
        ((1, 2, 3), "pair"),
        (float("nan"), "nan"),
    ],
)
def test_bad_spectra_are_refused(value, message):
    with pytest.raises((ValueError, TypeError), match=message):
        as_spectrum(value)


@pytest.mark.parametrize("reflectance", [1.5, -0.1, ([400, 500], [0.5, 1.01])])
def test_reflectance_is_at_most_one(reflectance):
    with pytest.raises(ValueError, match="0 to 1"):
        cpm.materials.Diffuse(reflectance)


# Pictures: bins to colour.


def picture(values, wavelengths):
    """A picture of one row whose pixels have the spectra ``values`` (N, bins)."""
    return cpm.Image(np.asarray(values, dtype=float)[None], wavelengths)


def test_flat_spectrum_is_the_equal_energy_white():
    wavelengths = cpm.bin_centers(360, 830, 47)
    x, y, z = picture(np.ones((1, 47)), wavelengths).to_xyz()[0, 0]
    assert y == pytest.approx(683 * 106.857, rel=1e-4)  # 683 lm/W times the integral of V(λ), nm
    assert x == pytest.approx(y, rel=1e-3)
    assert z == pytest.approx(y, rel=1e-3)


@pytest.mark.filterwarnings("ignore:.*Aligning")  # colour-science says that it cuts its table to ours
def test_colour_agrees_with_colour_science():
    import colour

    wavelengths = np.arange(400.0, 701.0, 10.0)
    values = as_spectrum("D65").at(wavelengths) * as_spectrum("cornell-red").at(wavelengths)
    ours = picture(values[None], wavelengths).to_xyz()[0, 0]
    theirs = colour.sd_to_XYZ(colour.SpectralDistribution(values, wavelengths), k=683, method="Integration")
    np.testing.assert_allclose(ours, theirs, rtol=4e-3)


def test_narrow_bins_have_the_hue_of_their_wavelength():
    red, green, blue = picture(np.eye(3), [450.0, 540.0, 640.0]).to_rgb()[0, ::-1]
    assert np.argmax(red) == 0
    assert np.argmax(green) == 1
    assert np.argmax(blue) == 2


def test_white_makes_a_flat_spectrum_neutral():
    flat = picture(np.ones((1, 47)), cpm.bin_centers(360, 830, 47))
    np.testing.assert_allclose(flat.to_rgb(white="E")[0, 0], 1.0, atol=5e-3)
    red, _, blue = flat.to_rgb(exposure=1e-5, encode=False)[0, 0]
    assert red > blue  # unadapted, E is pink on a D65 display


def test_one_bin_is_grey():
    grey = picture([[1.0], [0.25]], [620.0]).to_rgb(exposure=1e-5, encode=False)[0]
    np.testing.assert_allclose(grey, grey[:, :1] * np.ones(3), rtol=2e-3)
    assert grey[0, 0] == pytest.approx(4 * grey[1, 0])


def test_exposure_of_a_black_picture_is_harmless():
    assert not picture(np.zeros((2, 3)), [450.0, 550.0, 650.0]).to_rgb().any()


def test_picture_is_read_only_and_no_copy():
    image = picture(np.ones((1, 2)), [500.0, 600.0])
    assert np.shares_memory(image.data, image.data)
    with pytest.raises(ValueError, match="read-only"):
        image.data[0, 0, 0] = 2.0


def test_spectral_exr_is_read_by_colour_science(tmp_path):
    import colour

    values = np.random.default_rng(1).random((5, 7, 4)).astype(np.float32)
    wavelengths = np.array([450.0, 500.5, 550.0, 650.0])
    cpm.Image(values, wavelengths).save(tmp_path / "a.exr")
    components, _ = colour.read_spectral_image_Fichet2021(tmp_path / "a.exr", additional_data=True)
    stored_wavelengths, stored = components["S0"]
    np.testing.assert_allclose(stored_wavelengths, wavelengths)
    np.testing.assert_array_equal(stored, values)


def test_png_is_what_to_rgb_says(tmp_path):
    from matplotlib.image import imread

    image = cpm.Image(np.random.default_rng(2).random((4, 6, 3)), [450.0, 550.0, 650.0])
    image.save(tmp_path / "a.png")
    stored = imread(tmp_path / "a.png")[..., :3]
    np.testing.assert_allclose(stored, image.to_rgb(), atol=0.6 / 255)


def test_failed_save_leaves_what_was_there(tmp_path):
    target = tmp_path / "a.png"
    target.write_bytes(b"before")
    with pytest.raises(ValueError, match="white"):
        cpm.Image(np.ones((1, 1, 3)), [450.0, 550.0, 650.0]).save(target, white="no-such-light")
    assert target.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", ["a.jpg", "a", "a.exr.gz"])
def test_unknown_suffix_is_refused(tmp_path, name):
    with pytest.raises(ValueError, match=r"\.exr, \.png"):
        cpm.Image(np.ones((1, 1, 1)), [550.0]).save(tmp_path / name)
