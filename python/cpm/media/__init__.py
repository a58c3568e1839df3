"""Media: refractive index fields n(r, λ).

==================  ============================================  ==============================
``Homogeneous``     constant n                                    straight; no integrator runs
``LinearSquared``   n² linear in position                         exact: parabolas
``Linear``          n linear in position                          exact: catenaries
``Layered``         table of height, flat or spherical            exact where ``"linear-squared"``
``Grid``            samples on a grid                             integrated
``Parabolic``       n² = n₀²(1 − α²ρ²), a fibre                   exact: sinusoids
``Luneburg``        n² = 2 − r²/R² in a ball                      exact: ellipses
``Fisheye``         n = n₀/(1 + r²/a²)                            exact: circles
``Eaton``           n² = 2R/r − 1 in a ball                       exact: Kepler's ellipses
``Sources``         1 + Σ m/dᵏ, points and lines                  integrated
``Atmosphere``      air of a profile of :mod:`cpm.atmosphere`     integrated
``Expression``      a formula in x, y, z, r, wavelength           integrated
``Sum``             ``a + b``: refractivities added               integrated
==================  ============================================  ==============================
"""
from ._base import Medium, as_medium
from .atmosphere import Atmosphere
from .expression import Expression
from .fisheye import Fisheye
from .grid import AIR_GLADSTONE_DALE, Grid
from .homogeneous import Homogeneous
from .layered import Layered
from .lenses import Eaton, Luneburg
from .linear import Linear, LinearSquared
from .parabolic import Parabolic
from .sources import Sources
from .sum import Sum

__all__ = [
    "AIR_GLADSTONE_DALE",
    "Atmosphere",
    "Eaton",
    "Expression",
    "Fisheye",
    "Grid",
    "Homogeneous",
    "Layered",
    "Linear",
    "LinearSquared",
    "Luneburg",
    "Medium",
    "Parabolic",
    "Sources",
    "Sum",
    "as_medium",
]
