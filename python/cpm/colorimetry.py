"""Spectral bins to XYZ and RGB, with colour-science's tables."""
from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import FloatArray, one_of
from ._colour import colour_science

#: lm/W at the peak of V(λ).
MAXIMUM_EFFICACY = 683.0

#: The default; whitepoints too are its.
OBSERVER = "CIE 1931 2 Degree Standard Observer"

#: What may become of colours that a display cannot show, by the names that users give.
GAMUTS = ("clip", "desaturate", "keep")


def bin_edges(wavelengths: FloatArray) -> FloatArray:
    """Edges (nm, bins + 1) of bins that reach half-way to their neighbours."""
    middles = 0.5 * (wavelengths[1:] + wavelengths[:-1])
    first, last = 1.5 * wavelengths[[0, -1]] - 0.5 * wavelengths[[1, -2]]
    return np.concatenate([[first], middles, [last]])


def matching_functions(wavelengths: npt.ArrayLike, observer: str = OBSERVER) -> FloatArray:
    """An observer's x̄, ȳ, z̄, shape (N, 3): linear between the table's wavelengths, 0 beyond it."""
    positions, table = observer_table(observer)
    return np.stack([np.interp(wavelengths, positions, table[:, i], left=0.0, right=0.0) for i in range(3)], axis=1)


def observer_table(name: str) -> tuple[FloatArray, FloatArray]:
    """Wavelengths (N,), nm, and x̄, ȳ, z̄ there (N, 3) of an observer by its colour-science name."""
    known = colour_science().MSDS_CMFS
    if name not in known:
        raise ValueError(f"observer is {name!r}; one of colour-science's is needed, such as {OBSERVER}, "
                         "CIE 1964 10 Degree Standard Observer, CIE 2015 2 Degree Standard Observer")
    return np.asarray(known[name].wavelengths, dtype=float), np.asarray(known[name].values, dtype=float)


def xyz_weights(wavelengths: FloatArray, observer: str = OBSERVER, edges: FloatArray | None = None,
                shape: Any = None) -> FloatArray:
    """What a spectrum's values at bin centres are multiplied by to give XYZ, nm, shape (bins, 3).

    The spectrum is constant in each of equal bins; in uneven ones it goes through the value at the centre with the slope
    of the parabola through it and its neighbours, since steps would be off by the first power of the width. With a
    ``shape`` (a function of wavelength, > 0 at the centres) that is said of the spectrum over its shape. Bins that have
    no ``edges`` (bins + 1, nm) reach half-way to their neighbours. One bin alone stands for a flat spectrum.
    """
    positions, table = observer_table(observer)
    steps = 0.5 * (table[1:] + table[:-1]) * np.diff(positions)[:, None]
    integral = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    if len(wavelengths) == 1 and shape is None:
        return integral[-1:]
    cells = bin_edges(wavelengths) if edges is None else edges
    widths = np.diff(cells)
    if shape is None and np.ptp(widths) <= 1e-6 * widths.mean():
        at_edges = np.stack([np.interp(cells, positions, integral[:, i]) for i in range(3)], axis=1)
        return np.diff(at_edges, axis=0)
    moments = np.array([_moments(*cell, shape, observer) for cell in zip(cells[:-1], cells[1:], wavelengths, strict=True)])
    weights = moments[:, 0] + (_slopes(wavelengths).T @ moments[:, 1] if len(wavelengths) > 1 else 0.0)
    return np.asarray(weights if shape is None else weights / shape(wavelengths)[:, None])


def _slopes(x: FloatArray) -> FloatArray:
    """The matrix (N, N) that makes slopes of values at x: of a parabola through three neighbours, of a line at the
    ends."""
    below, above = np.diff(x)[:-1], np.diff(x)[1:]
    matrix, inner = np.zeros((x.size, x.size)), np.arange(1, x.size - 1)
    matrix[inner, inner - 1] = -above / (below * (below + above))
    matrix[inner, inner] = (above - below) / (below * above)
    matrix[inner, inner + 1] = below / (above * (below + above))
    for at, left in ((0, 0), (x.size - 1, x.size - 2)):
        matrix[at, left], matrix[at, left + 1] = np.array([-1.0, 1.0]) / (x[left + 1] - x[left])
    return matrix


def _moments(low: float, high: float, center: float, shape: Any, observer: str) -> FloatArray:
    """Integrals of the matching functions, times the shape, and of these times the distance from the centre: (2, 3)."""
    grid = np.linspace(low, high, max(65, int(4 * (high - low))))
    seen = matching_functions(grid, observer) * (1.0 if shape is None else shape(grid)[:, None])
    return np.asarray(np.trapezoid([seen, seen * (grid - center)[:, None]], grid, axis=1))


def flat_luminance() -> float:
    """∫ȳ dλ, nm: the relative luminance of a flat spectrum of 1 per nm."""
    return float(xyz_weights(np.array([550.0]))[0, 1])


def whitepoint(name: str) -> FloatArray:
    """xy of an illuminant by its colour-science name."""
    illuminants = colour_science().CCS_ILLUMINANTS[OBSERVER]
    if name not in illuminants:
        raise ValueError(f"white is {name!r}; an illuminant such as D65, E or A is needed")
    return np.asarray(illuminants[name], dtype=float)


def linear_rgb(xyz: npt.NDArray[Any], colourspace: str, white: str | None) -> FloatArray:
    """XYZ to linear RGB; ``white`` names the illuminant that is to come out neutral."""
    space = _space(colourspace)
    source = space.whitepoint if white is None else whitepoint(white)
    rgb = colour_science().XYZ_to_RGB(xyz, space, source, "CAT02", apply_cctf_encoding=False)
    return np.asarray(rgb, dtype=float)


def into_gamut(rgb: FloatArray, colourspace: str, gamut: str, highest: float = 1.0) -> FloatArray:
    """Linear RGB brought into [0, highest] in the way that ``gamut`` names; NaN stays.

    "desaturate" mixes each colour with the grey of its own luminance, as little as it takes: luminance stays and, in
    linear RGB, so does the hue (the dominant wavelength). What is brighter than white becomes white.
    """
    if gamut == "keep":
        return rgb
    if gamut == "clip":
        return np.clip(rgb, 0.0, highest)
    luminance = np.asarray(_space(colourspace).matrix_RGB_to_XYZ, dtype=float)[1]
    grey = np.clip(rgb @ luminance, 0.0, highest)[..., None]
    away = rgb - grey
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(away > 0, (highest - grey) / away, -grey / away)
    share = np.clip(np.where(away == 0, 1.0, room).min(axis=-1, keepdims=True), 0.0, 1.0)
    with np.errstate(invalid="ignore"):
        return np.clip(grey + share * away, 0.0, highest)  # rounding alone is left to clip


def as_gamut(name: str) -> str:
    """``name`` if it is one of :data:`GAMUTS`."""
    return one_of(name, "gamut", GAMUTS)


def encode(rgb: FloatArray, colourspace: str) -> FloatArray:
    """Linear RGB in [0, 1] to the colour space's own encoding."""
    return np.asarray(_space(colourspace).cctf_encoding(rgb), dtype=float)


def _space(name: str) -> Any:
    spaces = colour_science().RGB_COLOURSPACES
    if name not in spaces:
        raise ValueError(f"colourspace is {name!r}; one of colour-science's is needed, such as sRGB, Display P3, ITU-R "
                         "BT.2020, ACEScg")
    return spaces[name]
