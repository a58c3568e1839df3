"""Spectral EXR (DESIGN section 6): colour-science's reader of Fichet et al. 2021 gets back what was saved."""

import numpy as np
import pytest
from support import scenes

import cpm

colour = pytest.importorskip("colour")
oiio = pytest.importorskip("OpenImageIO")

WAVELENGTHS = [409.375, 456.25, 550.0, 620.5]


@pytest.fixture(scope="module")
def image():
    scene = scenes.room(
        scenes.curved_medium(),
        {"white": 0.75, "red": ([400, 700], [0.05, 0.6]), "green": ([400, 550, 700], [0.1, 0.5, 0.1])},
    )
    return cpm.render(scene, size=(24, 18), photons=30_000, nearest=50, wavelengths=WAVELENGTHS, seed=1, progress=False)


@pytest.fixture
def saved(image, tmp_path):
    path = tmp_path / "room.exr"
    image.save(path)
    return path


def test_spectrum_survives(image, saved):
    components, specification = colour.read_spectral_image_Fichet2021(str(saved), additional_data=True)
    assert specification.is_emissive
    wavelengths, values = components["S0"]
    order = np.argsort(wavelengths)
    np.testing.assert_allclose(np.asarray(wavelengths)[order], WAVELENGTHS, rtol=0, atol=5e-4)
    assert values.shape == (18, 24, 4)
    np.testing.assert_allclose(values[..., order], image.data, rtol=1e-6, atol=1e-12)
    assert image.data.max() > 0


def test_orientation_is_not_mirrored(image, saved):
    """A flipped write fails above, since the picture is not symmetric."""
    assert not np.allclose(image.data, image.data[::-1]) and not np.allclose(image.data, image.data[:, ::-1])


def test_layout(saved):
    """Channel names with a decimal comma, version and units as attributes, RGB beside the spectrum."""
    spec = oiio.ImageInput.open(str(saved)).spec()
    names = set(spec.channelnames)
    assert {"R", "G", "B"} <= names
    assert "S0.550,000nm" in names or any(n.startswith("S0.550,") and n.endswith("nm") for n in names)
    assert sum(n.startswith("S0.") for n in names) == 4
    attributes = {a.name: a.value for a in spec.extra_attribs}
    assert attributes["spectralLayoutVersion"] == "1.0"
    assert "W" in attributes["emissiveUnits"] and "nm" in attributes["emissiveUnits"]


def test_rgb_fallback(image, saved):
    """The R, G, B channels are the picture's own linear sRGB."""
    handle = oiio.ImageInput.open(str(saved))
    names, pixels = handle.spec().channelnames, handle.read_image("float")
    rgb = pixels[..., [names.index(c) for c in "RGB"]]
    assert np.all(np.isfinite(rgb)) and rgb.max() > 0
    xyz = image.to_xyz()
    assert xyz.shape == (18, 24, 3)
    matrix = np.array(
        [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
    )
    linear = xyz @ matrix.T
    bright = linear.max(axis=-1) > 0.2 * linear.max()
    scale = np.median(rgb[bright] / linear[bright])
    np.testing.assert_allclose(rgb[bright], scale * linear[bright], rtol=0.02, atol=0.02 * rgb.max())


def test_one_bin(tmp_path):
    """A film of one wavelength is a film."""
    scene = scenes.room(None, scenes.PAINTED)
    image = cpm.render(scene, size=(8, 6), photons=2000, nearest=20, wavelengths=[550.0], seed=1, progress=False)
    image.save(tmp_path / "one.exr")
    wavelengths, values = colour.read_spectral_image_Fichet2021(str(tmp_path / "one.exr"))["S0"]
    np.testing.assert_allclose(wavelengths, [550.0])
    np.testing.assert_allclose(values[..., 0], image.data[..., 0], rtol=1e-6, atol=1e-12)


def test_png(image, tmp_path):
    """PNG beside it: 8-bit sRGB of the right size, not black."""
    image.save(tmp_path / "room.png")
    pixels = oiio.ImageInput.open(str(tmp_path / "room.png")).read_image("uint8")
    assert pixels.shape[:2] == (18, 24) and pixels[..., :3].max() > 50


@pytest.mark.parametrize("name", ["room.txt", "room", "no/such/folder/room.exr"])
def test_bad_paths(image, tmp_path, name):
    """A suffix or folder that cannot be written: an error that names it, and no file left."""
    with pytest.raises((ValueError, OSError, cpm.Error), match="room"):
        image.save(tmp_path / name)
    assert not any(tmp_path.rglob("*"))
