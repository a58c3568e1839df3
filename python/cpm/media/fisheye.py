"""Maxwell's fish-eye."""
from __future__ import annotations

from .. import _core
from .._arrays import VectorLike, as_number, as_vector
from ..bounds import Bounds
from ..dispersion import Dispersion
from ._base import Medium


class Fisheye(Medium):
    """n = n₀/(1 + r²/a²): rays are circles, and each point r has a sharp image at −r a²/|r|².

    Parameters
    ----------
    n : float
        n₀ at the centre, > 0.
    radius : float
        a, where n = n₀/2; metres, > 0.
    center : array_like, shape (3,)
        Metres.
    dispersion : Dispersion or str, optional
        Scales n₀ − 1, so that the field stays a fish-eye: rays of all wavelengths run along the same circles.
    bounds : Box, Sphere or Shape, optional

    Raises
    ------
    ValueError
        ``n`` or ``radius`` not positive, numbers that are not finite.

    Notes
    -----
    J. C. Maxwell, Cambridge and Dublin Mathematical Journal 8, 1854. n falls below any bound far away: a ray that goes
    where n is 1e-6 of its start ends with ``CUTOFF``.
    """

    def __init__(self, n: float, radius: float, center: VectorLike = (0.0, 0.0, 0.0),
                 dispersion: Dispersion | str | None = None, bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        self.n, self.radius = as_number(n, "n"), as_number(radius, "radius")
        self.center = as_vector(center, "center")
        self._handle = _core.fisheye(self.n, self.radius, self.center, self._dispersion_core())
