"""n or n² linear in position; both have exact paths."""
from __future__ import annotations

from .. import _core
from .._arrays import VectorLike, as_number, as_vector
from ..bounds import Bounds
from ..dispersion import Dispersion
from ._base import Medium

_ORIGIN = (0.0, 0.0, 0.0)


class LinearSquared(Medium):
    """n² = n₀² + g·(r − r₀): rays are parabolas.

    Parameters
    ----------
    n_squared : float
        n₀² at ``origin``.
    gradient : array_like, shape (3,)
        g, 1/m.
    origin : array_like, shape (3,)
        r₀, metres.
    dispersion : Dispersion or str, optional
    bounds : Box, Sphere or Shape, optional
    """

    def __init__(self, n_squared: float, gradient: VectorLike, origin: VectorLike = _ORIGIN,
                 dispersion: Dispersion | str | None = None, bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        self.n_squared = as_number(n_squared, "n_squared")
        self.gradient, self.origin = as_vector(gradient, "gradient"), as_vector(origin, "origin")
        self._handle = _core.linear_squared(self.n_squared, self.gradient, self.origin, self._dispersion_core())


class Linear(Medium):
    """n = n₀ + g·(r − r₀): rays are catenaries.

    Parameters
    ----------
    n : float
        n₀ at ``origin``.
    gradient : array_like, shape (3,)
        g, 1/m.
    origin : array_like, shape (3,)
        r₀, metres.
    dispersion : Dispersion or str, optional
    bounds : Box, Sphere or Shape, optional
    """

    def __init__(self, n: float, gradient: VectorLike, origin: VectorLike = _ORIGIN,
                 dispersion: Dispersion | str | None = None, bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        self.n = as_number(n, "n")
        self.gradient, self.origin = as_vector(gradient, "gradient"), as_vector(origin, "origin")
        self._handle = _core.linear(self.n, self.gradient, self.origin, self._dispersion_core())
