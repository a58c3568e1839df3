"""Atmospheres: temperature, pressure and humidity as functions of height, and the refraction that they cause.

=====================  =====================================================================
``USStandard1976``     the standard atmosphere to 86 km
``Polytropic``         constant lapse rate below an isothermal stratosphere (Hohenkerk and Sinclair)
``Table``              measured levels; ``read_sounding`` reads them from a radiosonde's text file
``HotSurface``         any of these over a road or a desert: an exponential layer of warm (or cold) air
``Inversion``          any of these over a cold sea: colder air below a height
=====================  =====================================================================

Every profile has ``temperature(h)`` (K), ``pressure(h)`` (Pa), ``vapour_pressure(h)`` (Pa), ``humidity(h)`` (fraction),
``density(h)`` (kg/m³) and ``refractivity(h, wavelength, model)`` (n − 1), of heights in metres above the level that it
counts from, of any shape. :func:`refraction` bends a star's light; :class:`cpm.media.Atmosphere` fills a scene.
"""

from ._profile import Profile
from ._refraction import refraction
from .layers import HotSurface, Inversion
from .polytropic import Polytropic
from .sounding import read_sounding
from .standard import USStandard1976
from .table import Table

__all__ = ["HotSurface", "Inversion", "Polytropic", "Profile", "Table", "USStandard1976", "read_sounding", "refraction"]
