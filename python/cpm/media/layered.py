"""n as a table of height."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _core
from .._arrays import VectorLike, as_array, as_number, as_vector, one_of
from ..bounds import Bounds
from ..dispersion import Dispersion
from ._base import Medium

_ALLOWED = ("cubic", "linear-squared", "step")


class Layered(Medium):
    """Flat or spherical layers; outside the table its end values hold.

    Parameters
    ----------
    heights : array_like, shape (K,)
        Metres along ``up`` from ``origin``, strictly increasing; K ≥ 2 (≥ 1 for "step"). With ``radius``, above the
        sphere; all > −``radius``.
    n : array_like, shape (K,)
        Index at each height, > 0.
    up : array_like, shape (3,)
        Need not be unit.
    origin : array_like, shape (3,)
        Where height is 0, metres.
    radius : float, optional
        Spherical layers: heights are above a sphere of this radius, metres, whose centre is at
        ``origin`` − ``radius``·``up``, so that ``origin`` is on the ground. Default: flat.
    interpolation : {"cubic", "linear-squared", "step"}
        C² natural spline of n; n² linear between samples, in height (a parabola per layer, exact) or, spherical, in the
        squared distance from the centre (circular or hyperbolic functions, exact); n constant from a height to the next
        with Snell's law between (the discrete layers of Berger and Trout).
    kinks : array_like, shape (M,)
        Of "cubic": those of ``heights`` where the slope of n may jump, as at a tropopause. The spline is made of
        natural ones that meet there.
    dispersion : Dispersion or str, optional
    bounds : Box, Sphere or Shape, optional
    """

    def __init__(self, heights: npt.ArrayLike, n: npt.ArrayLike, up: VectorLike = (0.0, 1.0, 0.0),
                 origin: VectorLike = (0.0, 0.0, 0.0), radius: float | None = None,
                 interpolation: str = "cubic", dispersion: Dispersion | str | None = None, bounds: Bounds | None = None,
                 kinks: npt.ArrayLike = ()) -> None:
        super().__init__(dispersion, bounds)
        self.radius = None if radius is None else as_number(radius, "radius")
        if self.radius is not None and self.radius <= 0:
            raise ValueError(f"radius is {self.radius:g}; it must be > 0 metres, or None for flat layers")
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
        self._handle = _core.layered(self.heights, self.n, self.up, self.origin, self.radius or 0.0,
                                     _core.INTERPOLATION[self.interpolation], self._dispersion_core(),
                                     self._kinks(np.atleast_1d(as_array(kinks, "kinks"))))

    def _kinks(self, kinks: npt.NDArray[np.float64]) -> list[int]:
        if kinks.ndim != 1:
            raise ValueError(f"kinks has shape {kinks.shape}; a list of heights is needed")
        missing = np.flatnonzero(~np.isin(kinks, self.heights[1:-1]))
        if missing.size:
            raise ValueError(f"kinks[{missing[0]}] is {kinks[missing[0]]:g} m; one of heights is needed, "
                             "neither the first nor the last")
        return sorted({int(i) for i in np.searchsorted(self.heights, kinks)})
