"""Directions of the sky, the Sun's spectrum and limb, and images of all directions."""
from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _data
from ._arrays import FloatArray, Vector, VectorLike, as_array, as_vector, bin_centers
from ._exr import read_spectral
from .spectra import Spectrum


def compass(up: VectorLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit vectors up, north and east at a place where ``up`` is up.

    North is −z as far as that is level, so what a camera that looks along −z faces; where up is ±z it is +y. East is
    to its right.
    """
    axis = np.array(as_vector(up, "up"))
    if not np.any(axis):
        raise ValueError("up is (0, 0, 0); a direction is needed")
    axis = axis / np.linalg.norm(axis)
    for north in (np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])):
        level = north - (north @ axis) * axis
        if np.linalg.norm(level) > 1e-6:
            break
    level = level / np.linalg.norm(level)
    return axis, level, np.cross(level, axis)


def towards(elevation: float, azimuth: float, up: VectorLike) -> Vector:
    """Unit direction in which something at an elevation and an azimuth (degrees, clockwise from north) is seen."""
    axis, north, east = compass(up)
    e, a = np.radians(elevation), np.radians(azimuth)
    level = np.cos(e) * (np.cos(a) * north + np.sin(a) * east)
    return as_vector(np.sin(e) * axis + level, "direction")


def solar_irradiance() -> Spectrum:
    """The Sun's irradiance at one astronomical unit, W·m⁻²·nm⁻¹ (ASTM E490)."""
    table = _data.table("sun.toml")["irradiance"]
    grid = table["wavelengths"]
    wavelengths = np.arange(grid["first"], grid["last"] + 0.5 * grid["step"], grid["step"], dtype=float)
    return Spectrum(wavelengths, table["values"], "Sun")


def limb_darkening(wavelength: npt.ArrayLike) -> FloatArray:
    """Coefficients a₀ … a₅ of the Sun's limb darkening I(µ)/I(1) = Σ aᵢ µⁱ.

    Neckel's (2005) reference functions, by wavelength in nm; linear across the Balmer jump, which they leave out, held
    beyond their ends at 300 and 1100 nm.

    Returns
    -------
    ndarray, shape (..., 6)
    """
    wanted = as_array(wavelength, "wavelength")
    ranges = _data.table("sun.toml")["limb"]
    ends = np.array([end for part in ranges for end in part["range"]])
    made = np.empty((*wanted.shape, 6))
    at_ends = np.array([_of_range(part, end) for part in ranges for end in part["range"]])
    for k in range(6):  # where no range holds: between the ends
        made[..., k] = np.interp(wanted, ends, at_ends[:, k])
    for part in ranges:
        inside = (wanted >= part["range"][0]) & (wanted <= part["range"][1])
        made[inside] = _of_range(part, wanted[inside])
    return made


def _of_range(part: dict[str, Any], wavelength: Any) -> FloatArray:
    inverse = 1e3 / np.asarray(wavelength, dtype=float)[..., None]
    constant, first, fifth = (np.array(part[name]) for name in ("constant", "first", "fifth"))
    return np.asarray(constant + first * inverse + fifth * inverse**5)


def limb_table() -> FloatArray:
    """For the core: rows of wavelength and six coefficients, every 5 nm and where the law's ranges end."""
    ends = [end for part in _data.table("sun.toml")["limb"] for end in part["range"]]
    wavelengths = np.unique(np.concatenate([np.arange(300.0, 1101.0, 5.0), ends]))
    return np.column_stack([wavelengths, limb_darkening(wavelengths)])


class SkyImage:
    """Basic radiance from all directions, (height, width, bins): row 0 up, the middle column north, the right half east."""

    def __init__(self, wavelengths: npt.ArrayLike, values: npt.ArrayLike, name: str = "") -> None:
        self.wavelengths = np.atleast_1d(as_array(wavelengths, "wavelengths"))
        self.values = np.ascontiguousarray(as_array(values, "values"), dtype=np.float32)
        self.name = name
        if self.values.ndim != 3 or self.wavelengths.shape != self.values.shape[2:] or not self.values.size:
            raise ValueError(f"an environment's image has shape {self.values.shape} and {self.wavelengths.size} "
                             "wavelengths; (height, width, bins) and as many wavelengths as bins are needed")
        bad = np.argwhere(~(np.isfinite(self.values) & (self.values >= 0)))
        if bad.size:
            row, column, bin = bad[0]
            raise ValueError(f"an environment's image has {self.values[row, column, bin]:g} at row {row}, column "
                             f"{column}, bin {bin}; finite numbers >= 0 are needed")

    def at(self, wavelength: npt.ArrayLike) -> FloatArray:
        """Largest radiance of any direction: whether anything shines."""
        most = self.values.max(axis=(0, 1)).astype(float)
        return np.interp(as_array(wavelength, "wavelength"), self.wavelengths, most)

    def __repr__(self) -> str:
        height, width, bins = self.values.shape
        return f"SkyImage({self.name or 'values'}, {width} x {height} pixels, {bins} wavelengths)"


def as_sky_image(value: Any) -> SkyImage | None:
    """An image from a cpm.Image, ``(wavelengths, values)`` with values of three dimensions, a path (spectral .exr), or
    ``{"file": ..., "wavelengths": ..., "scale": ...}`` (.exr, .npy); None if it is none of these (so a spectrum)."""
    if isinstance(value, SkyImage):
        return value
    if hasattr(value, "data") and hasattr(value, "wavelengths") and np.ndim(value.data) == 3:
        return SkyImage(value.wavelengths, value.data)
    if isinstance(value, (tuple, list)) and len(value) == 2 and np.ndim(value[1]) == 3:
        return SkyImage(value[0], value[1])
    if isinstance(value, Path):
        return read_sky(value)
    if isinstance(value, Mapping) and "file" in value and is_sky_file(value["file"]):
        unknown = set(value) - {"file", "wavelengths", "scale"}
        if unknown:
            raise ValueError(f"radiance has {sorted(unknown)[0]!r}; file, wavelengths, scale are allowed")
        return read_sky(value["file"], value.get("wavelengths"), value.get("scale", 1.0))
    return None


def is_sky_file(name: Any) -> bool:
    """Whether it names an image rather than a table of two columns."""
    return os.fspath(name).lower().endswith((".exr", ".npy"))


def read_sky(path: str | os.PathLike[str], wavelengths: Any = None, scale: float = 1.0) -> SkyImage:
    """A lat-long image of basic radiance from a spectral EXR or a .npy of shape (height, width, bins).

    Raises
    ------
    ValueError
        An RGB file (its spectrum is unknown: convert it to a spectral one), wavelengths missing for a .npy or given for
        an .exr, a wrong shape.
    """
    name = os.fspath(path)
    if name.lower().endswith(".exr"):
        if wavelengths is not None:
            raise ValueError(f"{name}: wavelengths are given, but a spectral EXR has its own")
        try:
            values, found = read_spectral(path)
        except ValueError as error:
            if "no spectral channels" in str(error):
                raise ValueError(f"{error}: RGB has no spectrum; convert it to channels S0.…nm first") from None
            raise
        return SkyImage(found, scale * values, Path(path).name)
    if not name.lower().endswith(".npy"):
        raise ValueError(f"{name}: an environment is an .exr or a .npy")
    if not Path(path).is_file():
        raise FileNotFoundError(f"{name}: no such file")
    if wavelengths is None:
        raise ValueError(f"{name}: a .npy needs wavelengths, one for each of its bins")
    try:
        loaded = np.load(path, allow_pickle=False)
    except (OSError, EOFError, ValueError) as error:
        raise ValueError(f"{name}: a .npy file of numbers is needed ({error})") from None
    if isinstance(wavelengths, Mapping):
        wavelengths = bin_centers(wavelengths["from"], wavelengths["to"], wavelengths["bins"])
    return SkyImage(wavelengths, scale * loaded, Path(path).name)
