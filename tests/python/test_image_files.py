"""Spectral pictures to files and back."""

import numpy as np
import pytest

import cpm

WAVELENGTHS = np.array([402.5, 550.0, 551.25, 700.0])


def picture():
    data = np.random.default_rng(3).uniform(0, 5, (5, 7, 4)).astype(np.float32)
    return cpm.Image(data, WAVELENGTHS)


def test_exr_comes_back_to_the_last_bit(tmp_path):
    picture().save(tmp_path / "a.exr")
    back = cpm.Image.load(tmp_path / "a.exr")
    np.testing.assert_array_equal(back.data, picture().data)
    np.testing.assert_allclose(back.wavelengths, WAVELENGTHS, atol=1e-3)


def test_another_writer(tmp_path):
    """Written by OpenImageIO, channels in any order, among others."""
    import OpenImageIO

    names = ["S1.550,000nm", "S0.600,000nm", "R", "S0.500nm"]
    values = np.random.default_rng(4).random((2, 3, 4)).astype(np.float32)
    spec = OpenImageIO.ImageSpec(3, 2, 4, OpenImageIO.FLOAT)
    spec.channelnames = names
    out = OpenImageIO.ImageOutput.create(str(tmp_path / "b.exr"))
    assert out.open(str(tmp_path / "b.exr"), spec) and out.write_image(values) and out.close()
    back = cpm.Image.load(tmp_path / "b.exr")
    np.testing.assert_array_equal(back.wavelengths, [500.0, 600.0])
    np.testing.assert_array_equal(back.data, values[..., [3, 1]])


def test_what_is_no_spectral_picture(tmp_path):
    (tmp_path / "text.exr").write_text("not a picture")
    with pytest.raises(ValueError, match=r"text.exr: not an OpenEXR file"):
        cpm.Image.load(tmp_path / "text.exr")
    with pytest.raises(FileNotFoundError, match=r"none.exr: no such file"):
        cpm.Image.load(tmp_path / "none.exr")
    picture().save(tmp_path / "rgb.png")
    with pytest.raises(ValueError, match=r"rgb.png: no spectral channels such as S0.550,000nm; it has R, G, B"):
        cpm.Image.load(tmp_path / "rgb.png")
