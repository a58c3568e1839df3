"""What all profiles share."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import air
from .._arrays import FloatArray, as_array

#: Universal gas constant J/(kmol K) and molar masses kg/kmol, as USSA 1976 and Hohenkerk and Sinclair have them.
GAS_CONSTANT, MOLAR_DRY, MOLAR_VAPOUR = 8314.32, 28.9644, 18.0152

#: Gravity at sea level m/s², and the radius with which the standard atmosphere lets it fall off, m.
STANDARD_GRAVITY, GRAVITY_RADIUS = 9.80665, 6356766.0


class Profile:
    """A vertical profile of air. Immutable.

    Attributes
    ----------
    ground : float
        Lowest height, metres: where rays meet the ground.
    top : float
        Above it there is no air.
    radius : float
        Of the level that heights count from, metres, when the profile is used without one of its own.
    """

    ground: float = 0.0
    top: float = 80e3
    radius: float = 6371e3

    # What a profile defines, for finite heights of any shape, as if there were no top.

    def _temperature(self, h: FloatArray) -> FloatArray:
        raise NotImplementedError

    def _pressure(self, h: FloatArray) -> FloatArray:
        raise NotImplementedError

    def _fraction(self, h: FloatArray) -> FloatArray:
        """Molar fraction of water vapour."""
        return np.zeros_like(h)

    def _rate(self, h: FloatArray) -> FloatArray:
        """−d ln p/dh, 1/m."""
        raise NotImplementedError

    def _kinks(self) -> list[float]:
        """Heights where slopes jump."""
        return []

    def _features(self) -> list[float]:
        """Heights that resolve what varies over much less than a scale height."""
        return []

    # What it offers.

    def temperature(self, h: npt.ArrayLike) -> Any:
        """Temperature, K, at heights h (m); held above the top."""
        return _like(h, lambda x: self._temperature(np.minimum(x, self.top)))

    def pressure(self, h: npt.ArrayLike) -> Any:
        """Pressure, Pa, at heights h (m); 0 above the top."""
        return _like(h, self._below_top(self._pressure))

    def vapour_pressure(self, h: npt.ArrayLike) -> Any:
        """Partial pressure of water vapour, Pa, at heights h (m)."""
        return _like(h, self._below_top(lambda x: self._fraction(x) * self._pressure(x)))

    def humidity(self, h: npt.ArrayLike) -> Any:
        """Relative humidity over liquid water, a fraction, at heights h (m)."""
        return _like(
            h,
            self._below_top(
                lambda x: (
                    self._fraction(x)
                    * self._pressure(x)
                    / air.vapour_pressure(self._temperature(x), self._pressure(x), 1.0)
                )
            ),
        )

    def density(self, h: npt.ArrayLike) -> Any:
        """Density of the moist air, kg/m³, at heights h (m), as an ideal gas; 0 above the top."""

        def moist(x: FloatArray) -> FloatArray:
            molar = MOLAR_DRY - (MOLAR_DRY - MOLAR_VAPOUR) * self._fraction(x)
            return self._pressure(x) * molar / (GAS_CONSTANT * self._temperature(x))

        return _like(h, self._below_top(moist))

    def refractivity(self, h: npt.ArrayLike, wavelength: npt.ArrayLike, model: str = "ciddor") -> Any:
        """n − 1 of the air.

        Parameters
        ----------
        h : array_like
            Heights, metres.
        wavelength : array_like
            nm, in vacuum; broadcasts with ``h``.
        model : {"ciddor", "edlen", "iag1999"}
            See :func:`cpm.air.refractivity`.

        Returns
        -------
        float or ndarray
            Of the broadcast shape; 0 above the top.
        """

        def of(x: FloatArray) -> FloatArray:
            pressure = self._pressure(x)
            return air.refractivity(wavelength, self._temperature(x), pressure, self._fraction(x) * pressure, model)

        heights = _heights(h)
        value = np.where(heights > self.top, 0.0, of(np.minimum(heights, self.top)))
        return value if value.ndim else float(value)

    def _below_top(self, function: Any) -> Any:
        return lambda x: np.where(x > self.top, 0.0, function(np.minimum(x, self.top)))


def _heights(h: Any) -> FloatArray:
    heights = as_array(h, "h")
    bad = np.flatnonzero(~np.isfinite(np.atleast_1d(heights).ravel()))
    if bad.size:
        raise ValueError(f"h[{bad[0]}] is {np.atleast_1d(heights).ravel()[bad[0]]} m; finite heights are needed")
    return heights


def _like(h: Any, function: Any) -> Any:
    """An array for an array, a float for a number."""
    heights = _heights(h)
    values = function(np.atleast_1d(heights))
    return values if heights.ndim else float(values[0])


def geopotential(h: Any) -> Any:
    """Geopotential height of a geometric one, both metres."""
    return GRAVITY_RADIUS * h / (GRAVITY_RADIUS + h)


def geometric(height: Any) -> Any:
    """Geometric height of a geopotential one, both metres."""
    return GRAVITY_RADIUS * height / (GRAVITY_RADIUS - height)


def gravity(h: Any) -> Any:
    """m/s² at geometric height h (m)."""
    return STANDARD_GRAVITY * (GRAVITY_RADIUS / (GRAVITY_RADIUS + h)) ** 2


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def nodes_between(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gauss–Legendre points and weights of each interval, shape (..., 8): exact for polynomials of degree 15."""
    half = 0.5 * (high - low)[..., None]
    return low[..., None] + half * (1.0 + _NODES), half * _WEIGHTS
