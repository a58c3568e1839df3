"""Spectra to colours: observers, RGB spaces, and what becomes of colours that a display cannot show."""

import numpy as np
import pytest

import cpm

SPECTRAL = np.arange(400.0, 701.0, 20.0)
SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])  # IEC 61966-2-1
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of the same


def lines(power=1.0):
    """One pixel a bin, each lit in its own bin alone: (1, bins, bins)."""
    return cpm.Image(power * np.eye(len(SPECTRAL))[None], SPECTRAL)


def oracle_xyz(observer):
    """∫ over each bin of the colour matching functions, by the trapezoid rule on a grid of 0.01 nm."""
    import colour

    table = colour.MSDS_CMFS[observer]
    fine = np.arange(390.0, 710.0 + 1e-9, 0.01)
    bars = np.stack([np.interp(fine, table.wavelengths, table.values[:, i]) for i in range(3)], axis=1)
    inside = [(fine >= w - 10 - 1e-9) & (fine <= w + 10 + 1e-9) for w in SPECTRAL]
    return 683.0 * np.array([np.trapezoid(bars[i], fine[i], axis=0) for i in inside])


@pytest.mark.parametrize("observer", ["CIE 1931 2 Degree Standard Observer", "CIE 1964 10 Degree Standard Observer",
                                      "CIE 2015 2 Degree Standard Observer"])
def test_any_observer(observer):
    np.testing.assert_allclose(lines().to_xyz(observer)[0], oracle_xyz(observer), rtol=1e-5, atol=1e-5)


def test_two_degrees_by_default():
    np.testing.assert_array_equal(lines().to_xyz(), lines().to_xyz("CIE 1931 2 Degree Standard Observer"))


def test_spectral_colours_are_out_of_gamut():
    linear = lines().to_rgb(encode=False, exposure=1.0)[0]
    np.testing.assert_allclose(linear, oracle_xyz("CIE 1931 2 Degree Standard Observer") @ SRGB.T, rtol=0, atol=0.3)
    assert (linear.min(axis=1) < -1e-3 * linear.max(axis=1)).sum() > 10  # or the tests below would test nothing


def test_clip_bounds_each_channel():
    linear = lines().to_rgb(encode=False, exposure=1e-4)
    np.testing.assert_array_equal(lines().to_rgb(encode=False, exposure=1e-4, gamut="clip"), np.maximum(linear, 0.0))
    shown = lines(3.0).to_rgb(exposure=1e-4)
    np.testing.assert_array_equal(shown, lines(3.0).to_rgb(exposure=1e-4, gamut="clip"))
    assert shown.min() == 0.0 and shown.max() <= 1.0


@pytest.mark.parametrize("exposure", [1e-6, 1e-5, 1e-4])
def test_desaturate_keeps_luminance_and_hue(exposure):
    """In [0, 1]; the luminance is kept, and what is left of a colour lies between it and grey; a channel is at a bound."""
    linear = lines().to_rgb(encode=False, exposure=exposure)[0]
    shown = lines().to_rgb(exposure=exposure, gamut="desaturate")[0]
    decoded = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    assert shown.min() >= 0 and shown.max() <= 1
    light = linear @ LUMINANCE
    dim = light < 1
    assert dim.sum() > 5
    np.testing.assert_allclose(decoded[dim] @ LUMINANCE, light[dim], rtol=2e-3, atol=1e-7)
    np.testing.assert_allclose(decoded[~dim], 1.0, rtol=0, atol=1e-6)  # brighter than white is white
    before, after = linear[dim] - light[dim, None], decoded[dim] - light[dim, None]
    share = (after * before).sum(axis=1) / (before**2).sum(axis=1)
    assert np.all((share > 0) & (share <= 1 + 1e-3))
    np.testing.assert_allclose(after, share[:, None] * before, rtol=0, atol=3e-4 * np.abs(before).max())
    at_bound = np.minimum(decoded[dim].min(axis=1), 1 - decoded[dim].max(axis=1)) < 1e-6
    outside = (linear[dim].min(axis=1) < 0) | (linear[dim].max(axis=1) > 1)
    np.testing.assert_array_equal(at_bound[outside], True)
    np.testing.assert_allclose(share[~outside], 1.0, rtol=1e-3)


def test_keep_leaves_the_numbers():
    np.testing.assert_array_equal(lines().to_rgb(encode=False, exposure=1.0, gamut="keep"),
                                  lines().to_rgb(encode=False, exposure=1.0))
    assert lines().to_rgb(exposure=1e-4, gamut="keep").min() < 0


@pytest.mark.parametrize("space", ["Display P3", "ITU-R BT.2020"])
def test_a_wider_space_desaturates_less(space):
    narrow = lines().to_rgb(encode=False, exposure=1e-4)[0]
    wide = lines().to_rgb(space, encode=False, exposure=1e-4)[0]
    assert (wide.min(axis=1) / wide.max(axis=1)).min() > (narrow.min(axis=1) / narrow.max(axis=1)).min()


def test_names_are_refused_before_anything_is_written(tmp_path):
    image = lines()
    for options, words in [(dict(gamut="cut"), "gamut is 'cut'; clip, desaturate, keep are allowed"),
                           (dict(white="chalk"), "white is 'chalk'"), (dict(observer="me"), "observer is 'me'"),
                           (dict(exposure=0.0), "exposure is 0; it must be > 0")]:
        with pytest.raises(ValueError, match=words):
            image.save(tmp_path / "a.png", **options)
        with pytest.raises(ValueError, match=words):
            image.save(tmp_path / "a.exr", **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_pixels_that_are_not_finite(bad, tmp_path):
    data = np.ones((3, 4, 2))
    data[1, 2, 0] = bad
    image = cpm.Image(data, [450, 650])
    for gamut in ("clip", "desaturate", "keep"):
        with pytest.warns(UserWarning, match="1 of 12 pixels are not finite, the first at row 1, column 2; black here"):
            shown = image.to_rgb(gamut=gamut)
        np.testing.assert_array_equal(shown[1, 2], 0.0)
        assert np.isfinite(shown).all() and shown[0, 0].max() > 0.5
    with pytest.warns(UserWarning, match="NaN here"):
        linear = image.to_rgb(encode=False)
    assert np.isnan(linear[1, 2]).all() and np.isfinite(linear).sum() == 33
    with pytest.warns(UserWarning):
        image.save(tmp_path / "a.png")
    with pytest.warns(UserWarning):
        assert not cpm.Image(np.full((2, 2, 1), np.nan), [550]).to_rgb().any()
