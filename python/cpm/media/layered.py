"""n as a table of height."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _core
from .._arrays import VectorLike, as_array, as_vector, one_of
from ..bounds import Bounds
from ..dispersion import Dispersion
from ._base import Medium

_ALLOWED = ("cubic", "linear-squared", "step")


class Layered(Medium):
    """Planar layers; outside the table its end values hold.

    Parameters
    ----------
    heights : array_like, shape (K,)
        Metres along ``up`` from ``origin``, strictly increasing; K ≥ 2 (≥ 1 for "step").
    n : array_like, shape (K,)
        Index at each height, > 0.
    up : array_like, shape (3,)
        Need not be unit.
    origin : array_like, shape (3,)
        Where height is 0, metres.
    radius : None
        Planar layers. Spherical ones are not in this version.
    interpolation : {"cubic", "linear-squared", "step"}
        C² natural spline of n; n² linear between samples (a parabola per layer, exact); n constant from a height to
        the next with Snell's law between (the discrete layers of Berger and Trout).
    dispersion : Dispersion or str, optional
    bounds : Box, Sphere or Shape, optional
    """

    def __init__(self, heights: npt.ArrayLike, n: npt.ArrayLike, up: VectorLike = (0.0, 1.0, 0.0),
                 origin: VectorLike = (0.0, 0.0, 0.0), radius: float | None = None,
                 interpolation: str = "cubic", dispersion: Dispersion | str | None = None, bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        if radius is not None:
            raise _core.Error(f"radius is {radius!r}: spherical layers are not in this version; None (planar) is allowed")
        self.interpolation = one_of(interpolation, "interpolation", _ALLOWED)
        self.heights, self.n = as_array(heights, "heights"), as_array(n, "n")
        if self.heights.ndim != 1 or self.n.ndim != 1:
            raise ValueError(f"heights has shape {self.heights.shape} and n {self.n.shape}; two lists are needed")
        if len(self.heights) != len(self.n):
            raise ValueError(f"heights has {len(self.heights)} entries and n has {len(self.n)}; one n for each height "
                             "is needed")
        self.up, self.origin = as_vector(up, "up"), as_vector(origin, "origin")
        if not np.any(self.up):
            raise ValueError("up is (0, 0, 0); a direction is needed")
        self._handle = _core.layered(self.heights, self.n, self.up, self.origin,
                                     _core.INTERPOLATION[self.interpolation], self._dispersion_core())
