"""The graded-index fibre."""
from __future__ import annotations

from .. import _core
from .._arrays import VectorLike, as_number, as_vector
from ..bounds import Bounds
from ..dispersion import Dispersion
from ._base import Medium


class Parabolic(Medium):
    """n² = n₀²(1 − α²ρ²), ρ the distance from an axis: a SELFOC fibre. Rays are sinusoids along it.

    Their period is 2πp_z/(n₀α), p_z = n cos θ the part of the momentum along the axis. Beyond ρ = 1/α, n² is not
    positive: a ray that gets there head on ends with ``CUTOFF``, others turn back before.

    Parameters
    ----------
    n : float
        n₀ on the axis, > 0.
    alpha : float
        α, 1/m, ≥ 0.
    axis : array_like, shape (3,)
        Need not be unit.
    origin : array_like, shape (3,)
        A point of the axis, metres.
    dispersion : Dispersion or str, optional
        Scales n² − 1, as of all media defined by n².
    bounds : Box, Sphere or Shape, optional

    Raises
    ------
    ValueError
        ``n`` not positive, ``alpha`` negative, an axis without a direction, numbers that are not finite.
    """

    def __init__(self, n: float, alpha: float, axis: VectorLike = (0.0, 0.0, 1.0),
                 origin: VectorLike = (0.0, 0.0, 0.0), dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        self.n, self.alpha = as_number(n, "n"), as_number(alpha, "alpha")
        self.axis, self.origin = as_vector(axis, "axis"), as_vector(origin, "origin")
        self._handle = _core.parabolic(self.n, self.alpha, self.axis, self.origin, self._dispersion_core())
