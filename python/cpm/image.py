"""Spectral pictures."""
from __future__ import annotations

import os
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

    def to_xyz(self) -> FloatArray:
        """CIE 1931 XYZ, 2° observer.

        Returns
        -------
        ndarray, shape (height, width, 3)
            Y is luminance in cd/m². A spectrum is constant in each of equal bins, linear in each of uneven ones, from
            edge to edge, times the bins' ``shape`` if they have one; one bin alone stands for a flat spectrum.
        """
        weights = (colorimetry.xyz_weights(self.wavelengths) if self._bins is None else
                   colorimetry.xyz_weights(self.wavelengths, self._bins.edges, self._bins.shape))
        return colorimetry.MAXIMUM_EFFICACY * (self.data @ weights)

    def to_rgb(self, colourspace: str = "sRGB", *, exposure: float | None = None, white: str | None = None,
               encode: bool = True) -> FloatArray:
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
            False: linear, neither clipped nor encoded.

        Returns
        -------
        ndarray, shape (height, width, 3)
            In [0, 1] and encoded, or linear.
        """
        xyz = self.to_xyz()
        factor = auto_exposure(xyz[..., 1]) if exposure is None else as_number(exposure, "exposure")
        if not factor > 0:
            raise ValueError(f"exposure is {factor:g}; it must be > 0")
        # One bin has no colour: shown grey.
        rgb = colorimetry.linear_rgb(xyz * factor, colourspace, "E" if len(self.wavelengths) == 1 else white)
        return colorimetry.encode(np.clip(rgb, 0.0, 1.0), colourspace) if encode else rgb

    def save(self, path: str | os.PathLike[str], *, exposure: float | None = None, white: str | None = None) -> None:
        """Write the picture; the suffix says how. Written beside its place, then renamed.

        Parameters
        ----------
        path : path
            ``.exr``: spectral OpenEXR in the layout of Fichet et al. 2021, with R, G, B for other viewers (linear sRGB;
            a flat spectrum of 1 W·m⁻²·sr⁻¹·nm⁻¹ has Y = 1). ``.png``: 8-bit sRGB.
        exposure, white
            For ``.png``: as in :meth:`to_rgb`.
        """
        check_suffix(path)
        with written_together([path]) as (beside,):
            self._write(beside, exposure, white)

    def _write(self, path: Path, exposure: float | None, white: str | None) -> None:
        if path.suffix.lower() == ".exr":
            relative = self.to_xyz() / (colorimetry.MAXIMUM_EFFICACY * colorimetry.flat_luminance())
            rgb = colorimetry.linear_rgb(relative, "sRGB", "E" if len(self.wavelengths) == 1 else None)
            self._handle.write_exr(os.fsencode(path), np.ascontiguousarray(rgb, dtype=np.float32))
            return
        from matplotlib.image import imsave

        rgb = self.to_rgb("sRGB", exposure=exposure, white=white)
        imsave(path, np.round(255.0 * rgb).astype(np.uint8), format="png")

    def __repr__(self) -> str:
        height, width, bins = self.data.shape
        return f"Image({width} x {height}, {bins} bins of {self.wavelengths[0]:g}-{self.wavelengths[-1]:g} nm)"


def save_all(image: Image, paths: list[Path], exposure: float | None = None, white: str | None = None) -> None:
    """Write one picture to several files; all of them or none."""
    with written_together(paths) as beside:
        for path in beside:
            image._write(path, exposure, white)


def check_suffix(path: str | os.PathLike[str]) -> None:
    """ValueError unless the suffix is one that can be written."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise ValueError(f"{os.fspath(path)}: suffix '{Path(path).suffix}'; {', '.join(SUFFIXES)} are allowed")


def auto_exposure(luminance: npt.NDArray[Any]) -> float:
    """The factor that brings a high percentile of the lit pixels to 1; 1 for a black picture."""
    lit = luminance[luminance > 0]
    return 1.0 / float(np.percentile(lit, AUTO_PERCENTILE)) if lit.size else 1.0
