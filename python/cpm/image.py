"""Spectral pictures."""
from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core, colorimetry
from ._arrays import FloatArray, as_array, as_number
from ._exr import read_spectral
from ._files import written_together
from .photons import named_stats
from .settings import as_wavelengths, bins_of
from .wavelengths import Bins

__all__ = ["Image"]

#: What ``save`` can write.
SUFFIXES = (".exr", ".png")

#: Of the lit pixels' luminances, the one that automatic exposure maps to 1.
AUTO_PERCENTILE = 98.0


class Image:
    """A spectral picture.

    Parameters
    ----------
    data : array_like, shape (height, width, bins)
        Radiance, W·m⁻²·sr⁻¹·nm⁻¹.
    wavelengths : array_like, shape (bins,)
        Bin centres, nm, or Bins of :mod:`cpm.wavelengths`, whose edges the image keeps.

    Attributes
    ----------
    stats : dict
        Seconds per stage, counts and bytes of the render; ``features`` and ``left_out`` name what the scene needed and
        did not.
    """

    def __init__(self, data: npt.ArrayLike, wavelengths: npt.ArrayLike) -> None:
        values, centers = as_array(data, "data"), as_wavelengths(wavelengths)
        self._bins = bins_of(wavelengths)
        if values.ndim != 3 or values.shape[2] != len(centers) or not values.size:
            raise ValueError(f"data has shape {values.shape}; (height, width, {len(centers)}) is needed")
        self._take(_core.Image(values.astype(np.float32), centers))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Image:
        """Read a spectral OpenEXR file in the layout of Fichet et al. 2021, as :meth:`save` writes it.

        Parameters
        ----------
        path : path
            Its R, G, B are left aside. Needs OpenImageIO (``pip install openimageio``).

        Returns
        -------
        Image
            Without the ``stats`` of its render.

        Raises
        ------
        ValueError
            Not an OpenEXR file, or one without spectral channels.
        """
        return cls(*read_spectral(path))

    @classmethod
    def _of(cls, handle: _core.Image, bins: Bins | None = None) -> Image:
        image = cls.__new__(cls)
        image._bins = bins
        image._take(handle)
        return image

    def _take(self, handle: _core.Image) -> None:
        self._handle = handle
        self.stats: dict[str, Any] = named_stats(handle.stats())

    @property
    def data(self) -> npt.NDArray[np.float32]:
        """(height, width, bins), actual radiance at the pinhole, W·m⁻²·sr⁻¹·nm⁻¹; row 0 on top.

        The film itself, not a copy: read-only.
        """
        return self._handle.data

    @property
    def wavelengths(self) -> FloatArray:
        """(bins,), bin centres, nm."""
        return self._handle.wavelengths

    @property
    def edges(self) -> FloatArray:
        """(bins + 1,), nm: those of the Bins that were rendered, else half-way between centres.

        A file has centres alone: what :meth:`load` gives has edges half-way. One bin alone stands for all that is seen,
        360 to 830 nm.
        """
        if self._bins is not None:
            return self._bins.edges
        centers = self.wavelengths
        return colorimetry.bin_edges(centers) if len(centers) > 1 else np.array([360.0, 830.0])

    def to_xyz(self, observer: str = colorimetry.OBSERVER) -> FloatArray:
        """CIE XYZ.

        Parameters
        ----------
        observer : str
            A colour-science name: "CIE 1931 2 Degree Standard Observer", "CIE 1964 10 Degree Standard Observer", …

        Returns
        -------
        ndarray, shape (height, width, 3)
            Y is luminance in cd/m² (of that observer). A spectrum is constant in each of equal bins, linear in each of
            uneven ones, from edge to edge, times the bins' ``shape`` if they have one; one bin alone stands for a flat
            spectrum. NaN where a bin is.
        """
        bins = self._bins
        weights = (colorimetry.xyz_weights(self.wavelengths, observer) if bins is None else
                   colorimetry.xyz_weights(self.wavelengths, observer, bins.edges, bins.shape))
        with np.errstate(invalid="ignore"):  # of pixels that are not finite
            return colorimetry.MAXIMUM_EFFICACY * (self.data @ weights)

    def to_rgb(self, colourspace: str = "sRGB", *, exposure: float | None = None, white: str | None = None,
               encode: bool = True, gamut: str | None = None, observer: str = colorimetry.OBSERVER) -> FloatArray:
        """RGB for a display.

        Parameters
        ----------
        colourspace : str
            A colour-science name: "sRGB", "Display P3", "ITU-R BT.2020", …
        exposure : float, optional
            Factor on luminance (cd/m²) before encoding. Default: the 98th percentile of the lit pixels becomes 1.
        white : str, optional
            Illuminant that is to look neutral ("E" for flat lights). Default: none is adapted to; a flat spectrum is
            then a little pink on D65 displays, as it is.
        encode : bool
            False: linear, not encoded, without an upper bound.
        gamut : {"clip", "desaturate", "keep"}, optional
            What becomes of colours outside the display's triangle (spectral ones are: a channel is negative) and of
            those brighter than white. "clip" bounds each channel by itself, which shifts hues and brightens;
            "desaturate" mixes with the grey of the same luminance until all channels fit, which keeps luminance and
            dominant wavelength: for prisms and rainbows; "keep" leaves the numbers. Default: "clip", and "keep" where
            ``encode`` is False.
        observer : str
            As in :meth:`to_xyz`.

        Returns
        -------
        ndarray, shape (height, width, 3)
            In [0, 1] and encoded, or linear. Pixels that are not finite are NaN where ``encode`` is False, else black.

        Warns
        -----
        UserWarning
            Some pixels are not finite; says how many, and which is the first.
        """
        way = ("clip" if encode else "keep") if gamut is None else colorimetry.as_gamut(gamut)
        xyz = self.to_xyz(observer)
        unknown = ~np.isfinite(xyz).all(axis=-1)
        if unknown.any():
            row, column = np.argwhere(unknown)[0]
            warnings.warn(f"{unknown.sum()} of {unknown.size} pixels are not finite, the first at row {row}, column "
                          f"{column}; {'black' if encode else 'NaN'} here", stacklevel=2)
            xyz[unknown] = np.nan
        factor = auto_exposure(xyz[..., 1]) if exposure is None else check_exposure(exposure)
        # One bin has no colour: shown grey.
        rgb = colorimetry.linear_rgb(xyz * factor, colourspace, "E" if len(self.wavelengths) == 1 else white)
        rgb = colorimetry.into_gamut(rgb, colourspace, way, 1.0 if encode else np.inf)
        if not encode:
            return rgb
        rgb[unknown] = 0.0
        return colorimetry.encode(rgb, colourspace)

    def save(self, path: str | os.PathLike[str], *, exposure: float | None = None, white: str | None = None,
             gamut: str | None = None, observer: str = colorimetry.OBSERVER) -> None:
        """Write the picture; the suffix says how. Written beside its place, then renamed.

        Parameters
        ----------
        path : path
            ``.exr``: spectral OpenEXR in the layout of Fichet et al. 2021, with R, G, B for other viewers (linear sRGB;
            a flat spectrum of 1 W·m⁻²·sr⁻¹·nm⁻¹ has Y = 1). ``.png``: 8-bit sRGB.
        exposure, white, gamut, observer
            For ``.png``: as in :meth:`to_rgb`.
        """
        check_suffix(path)
        save_all(self, [Path(path)], exposure=exposure, white=white, gamut=gamut, observer=observer)

    def _write(self, path: Path, shown: dict[str, Any]) -> None:
        if path.suffix.lower() == ".exr":
            relative = self.to_xyz() / (colorimetry.MAXIMUM_EFFICACY * colorimetry.flat_luminance())
            rgb = colorimetry.linear_rgb(relative, "sRGB", "E" if len(self.wavelengths) == 1 else None)
            self._handle.write_exr(os.fsencode(path), np.ascontiguousarray(rgb, dtype=np.float32))
            return
        from matplotlib.image import imsave

        rgb = self.to_rgb("sRGB", **shown)
        imsave(path, np.round(255.0 * rgb).astype(np.uint8), format="png")

    def __repr__(self) -> str:
        height, width, bins = self.data.shape
        return f"Image({width} x {height}, {bins} bins of {self.wavelengths[0]:g}-{self.wavelengths[-1]:g} nm)"


def save_all(image: Image, paths: list[Path], **shown: Any) -> None:
    """Write one picture to several files; all of them or none. ``shown``: for PNG, of :meth:`Image.to_rgb`."""
    check_shown(**shown)
    with written_together(paths) as beside:
        for path in beside:
            image._write(path, shown)


def check_suffix(path: str | os.PathLike[str]) -> None:
    """ValueError unless the suffix is one that can be written."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise ValueError(f"{os.fspath(path)}: suffix '{Path(path).suffix}'; {', '.join(SUFFIXES)} are allowed")


def check_exposure(exposure: Any) -> float:
    """``exposure`` as a number; ValueError unless it is > 0."""
    factor = as_number(exposure, "exposure")
    if not factor > 0:
        raise ValueError(f"exposure is {factor:g}; it must be > 0")
    return factor


def check_shown(exposure: float | None = None, white: str | None = None, gamut: str | None = None,
                observer: str = colorimetry.OBSERVER) -> None:
    """ValueError for what :meth:`Image.to_rgb` would refuse: asked before a render, not after."""
    if exposure is not None:
        check_exposure(exposure)
    if white is not None:
        colorimetry.whitepoint(white)
    if gamut is not None:
        colorimetry.as_gamut(gamut)
    if observer != colorimetry.OBSERVER:
        colorimetry.observer_table(observer)


def auto_exposure(luminance: npt.NDArray[Any]) -> float:
    """The factor that brings a high percentile of the lit pixels to 1; 1 for a black picture."""
    lit = luminance[luminance > 0]
    return 1.0 / float(np.percentile(lit, AUTO_PERCENTILE)) if lit.size else 1.0
