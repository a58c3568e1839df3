"""Gröller's gravity centres and lines."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _core
from .._arrays import as_array, as_points
from ..bounds import Bounds
from ..dispersion import Dispersion
from ._base import Medium


class Sources(Medium):
    """n = 1 + Σ mᵢ/dᵢᵏ, dᵢ the distance from a point or from an infinite line.

    A ray that falls into an attracting source (m > 0) ends with ``CAPTURED``, one that meets n² ≤ 0 before a repelling
    one with ``CUTOFF``.

    Parameters
    ----------
    centers : array_like, shape (K, 3) or (3,)
        The points; on a line any point of it. Metres.
    strengths : float or array_like, shape (K,)
        m, metresᵏ; > 0 attracts, < 0 repels.
    exponent : float or array_like, shape (K,)
        k, in (0, 64].
    directions : array_like, shape (K, 3) or (3,), optional
        Of the lines, need not be unit; a row (0, 0, 0) leaves a point. Default: all are points.
    dispersion : Dispersion or str, optional
        Scales n − 1.
    bounds : Box, Sphere or Shape, optional

    Raises
    ------
    ValueError
        Names the first bad source: numbers that are not finite, an exponent out of range; lists of different lengths.

    Notes
    -----
    E. Gröller, Nonlinear ray tracing: visualizing strange worlds. The Visual Computer 11, 1995. About one centre light
    runs round at r = ((k − 1)m)^(1/k), unstably; below that orbit's impact parameter r + m r^(1−k) it is captured
    (k = 2: r = √m, 2√m).
    """

    def __init__(self, centers: npt.ArrayLike, strengths: npt.ArrayLike, exponent: npt.ArrayLike = 2.0,
                 directions: npt.ArrayLike | None = None, dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        self.centers = as_points(centers, "centers")
        count = len(self.centers)
        if not count:
            raise ValueError("centers is empty; one source at least is needed")
        self.strengths = _for_each(strengths, "strengths", count)
        self.exponent = _for_each(exponent, "exponent", count)
        self.directions = as_points(np.zeros((count, 3)) if directions is None else directions, "directions")
        if len(self.directions) not in (1, count):
            raise ValueError(f"directions has shape {self.directions.shape}; ({count}, 3) is needed")
        self.directions = np.ascontiguousarray(np.broadcast_to(self.directions, (count, 3)))
        self._handle = _core.sources(self.centers, self.directions, self.strengths, self.exponent,
                                     self._dispersion_core())


def _for_each(value: npt.ArrayLike, name: str, count: int) -> npt.NDArray[np.float64]:
    """One number for each source."""
    numbers = np.atleast_1d(as_array(value, name))
    if numbers.ndim != 1 or numbers.size not in (1, count):
        raise ValueError(f"{name} has shape {numbers.shape}; a number or ({count},) is needed")
    return np.ascontiguousarray(np.broadcast_to(numbers, count))
