"""Spectral bins to XYZ and RGB, with colour-science's tables."""
from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import FloatArray
from ._colour import colour_science

#: lm/W at the peak of V(λ).
MAXIMUM_EFFICACY = 683.0

_OBSERVER = "CIE 1931 2 Degree Standard Observer"


def bin_edges(wavelengths: FloatArray) -> FloatArray:
    """Edges (nm, bins + 1) of bins that reach half-way to their neighbours."""
    middles = 0.5 * (wavelengths[1:] + wavelengths[:-1])
    first, last = 1.5 * wavelengths[[0, -1]] - 0.5 * wavelengths[[1, -2]]
    return np.concatenate([[first], middles, [last]])


def xyz_weights(wavelengths: FloatArray) -> FloatArray:
    """Integrals of the CIE 1931 colour matching functions over the bins, nm, shape (bins, 3).

    One bin alone stands for a flat spectrum.
    """
    observer = colour_science().MSDS_CMFS[_OBSERVER]
    table = np.asarray(observer.values, dtype=float)
    positions = np.asarray(observer.wavelengths, dtype=float)
    steps = 0.5 * (table[1:] + table[:-1]) * np.diff(positions)[:, None]
    integral = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    if len(wavelengths) == 1:
        return integral[-1:]
    edges = bin_edges(wavelengths)
    at_edges = np.stack([np.interp(edges, positions, integral[:, i]) for i in range(3)], axis=1)
    return np.diff(at_edges, axis=0)


def flat_luminance() -> float:
    """∫ȳ dλ, nm: the relative luminance of a flat spectrum of 1 per nm."""
    return float(xyz_weights(np.array([550.0]))[0, 1])


def whitepoint(name: str) -> FloatArray:
    """xy of an illuminant by its colour-science name."""
    illuminants = colour_science().CCS_ILLUMINANTS[_OBSERVER]
    if name not in illuminants:
        raise ValueError(f"white is {name!r}; an illuminant such as D65, E or A is needed")
    return np.asarray(illuminants[name], dtype=float)


def linear_rgb(xyz: npt.NDArray[Any], colourspace: str, white: str | None) -> FloatArray:
    """XYZ to linear RGB; ``white`` names the illuminant that is to come out neutral."""
    space = _space(colourspace)
    source = space.whitepoint if white is None else whitepoint(white)
    rgb = colour_science().XYZ_to_RGB(xyz, space, source, "CAT02", apply_cctf_encoding=False)
    return np.asarray(rgb, dtype=float)


def encode(rgb: FloatArray, colourspace: str) -> FloatArray:
    """Linear RGB in [0, 1] to the colour space's own encoding."""
    return np.asarray(_space(colourspace).cctf_encoding(rgb), dtype=float)


def _space(name: str) -> Any:
    spaces = colour_science().RGB_COLOURSPACES
    if name not in spaces:
        raise ValueError(f"colourspace is {name!r}; one of colour-science's is needed, such as sRGB, Display P3, ITU-R "
                         "BT.2020, ACEScg")
    return spaces[name]
