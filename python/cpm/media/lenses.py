"""Lenses that fill a ball and have n = 1 at its surface and outside: Luneburg's and Eaton's."""
from __future__ import annotations

from .. import _core
from .._arrays import VectorLike, as_number, as_vector
from ..bounds import Bounds, Sphere
from ..dispersion import Dispersion
from ._base import Medium


class _Lens(Medium):
    """A lens of one radius about a centre."""

    def __init__(self, radius: float, center: VectorLike = (0.0, 0.0, 0.0), dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        self.radius, self.center = as_number(radius, "radius"), as_vector(center, "center")

    def _own_bounds(self) -> Sphere:
        return Sphere(self.center, self.radius)


class Luneburg(_Lens):
    """n² = 2 − r²/R² within the radius, 1 outside: parallel light meets at the antipode.

    Paths are ellipses about the centre, straight outside.

    Parameters
    ----------
    radius : float
        R, metres, > 0.
    center : array_like, shape (3,)
        Metres.
    dispersion : Dispersion or str, optional
        Scales n² − 1.
    bounds : Box, Sphere or Shape, optional
        Default in a scene's list: the lens's own sphere.

    Raises
    ------
    ValueError
        ``radius`` not positive, numbers that are not finite.

    Notes
    -----
    R. K. Luneburg, Mathematical Theory of Optics, 1944.
    """

    def __init__(self, radius: float, center: VectorLike = (0.0, 0.0, 0.0), dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        super().__init__(radius, center, dispersion, bounds)
        self._handle = _core.luneburg(self.radius, self.center, self._dispersion_core())


class Eaton(_Lens):
    """n² = 2R/r − 1 within the radius, 1 outside: every ray leaves antiparallel to how it came.

    Paths are Kepler's ellipses with the centre as focus, straight outside. n has no bound at the centre. By ``exact``
    a ray straight at it turns back there, as all its neighbours do. Integrated rays end with ``CAPTURED`` where n is
    above 1e6 of their start (within 2e-12 R for a ray from outside, whose impact parameter is then below 2e-6 R), or
    where the rounding of coordinates leaves |p|² − n² worth less than 1e-3 (with a centre a radius from the origin,
    impact parameters below 1e-3 R).

    Parameters
    ----------
    radius : float
        R, metres, > 0.
    center : array_like, shape (3,)
        Metres.
    dispersion : Dispersion or str, optional
        Scales n² − 1, by more than ½ (else paths would not be ellipses: refused when such a wavelength is used).
    bounds : Box, Sphere or Shape, optional
        Default in a scene's list: the lens's own sphere.

    Raises
    ------
    ValueError
        ``radius`` not positive, numbers that are not finite.

    Notes
    -----
    J. E. Eaton, Trans. IRE Antennas and Propagation 4, 1952.
    """

    def __init__(self, radius: float, center: VectorLike = (0.0, 0.0, 0.0), dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        super().__init__(radius, center, dispersion, bounds)
        self._handle = _core.eaton(self.radius, self.center, self._dispersion_core())
