"""Media: refractive index fields n(r, λ).

==================  ============================================  ==============================
``Homogeneous``     constant n                                    straight; no integrator runs
``LinearSquared``   n² linear in position                         exact: parabolas
``Linear``          n linear in position                          exact: catenaries
``Layered``         table of height, flat or spherical            exact where ``"linear-squared"``
``Grid``            samples on a grid                             integrated
``Atmosphere``      air of a profile of :mod:`cpm.atmosphere`     integrated
``Expression``      a formula in x, y, z, r, wavelength           integrated
``Sum``             ``a + b``: refractivities added               integrated
==================  ============================================  ==============================

One module a medium: parabolic, Luneburg, fish-eye, Eaton, sources and atmospheres take their places beside these.
"""
from ._base import Medium, as_medium
from .atmosphere import Atmosphere
from .expression import Expression
from .grid import Grid
from .homogeneous import Homogeneous
from .layered import Layered
from .linear import Linear, LinearSquared
from .sum import Sum

__all__ = [
    "Atmosphere",
    "Expression",
    "Grid",
    "Homogeneous",
    "Layered",
    "Linear",
    "LinearSquared",
    "Medium",
    "Sum",
    "as_medium",
]
