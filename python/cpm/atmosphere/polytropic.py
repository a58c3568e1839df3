"""The two-layer atmosphere of Hohenkerk and Sinclair.

C. Y. Hohenkerk and A. T. Sinclair, The computation of angular atmospheric refraction at large zenith angles, NAO
Technical Note 63 (1985); Explanatory Supplement to the Astronomical Almanac (1992), section 3.281. Below the tropopause

    T = T₀ − α (h − h₀),   τ = T/T₀,   p = (p₀ + W) τ^γ − W τ^δ,   e = e₀ τ^δ                                        (1)
    γ = g M_d/(R α),   δ = 18.36,   W = e₀ (1 − M_w/M_d) γ/(δ − γ)

above it T is constant and p, e fall exponentially.
"""

from __future__ import annotations

import numpy as np

from .._arrays import FloatArray, as_number
from ._profile import GAS_CONSTANT, MOLAR_DRY, MOLAR_VAPOUR, Profile

_DELTA = 18.36  # exponent of the vapour pressure's fall with temperature


class Polytropic(Profile):
    """Constant lapse rate to the tropopause, isothermal from there to 80 km.

    Parameters
    ----------
    T0, p0 : float
        Temperature (K) and pressure (Pa) at ``reference_height``.
    lapse : float
        −dT/dh, K/m.
    tropopause, reference_height : float
        Metres above sea level.
    humidity : float
        Relative humidity at ``reference_height``, a fraction.
    latitude : float
        Degrees; gravity depends on it, and does not on height.
    """

    radius = 6378120.0

    def __init__(
        self,
        T0: float,
        p0: float,
        lapse: float = 0.0065,
        tropopause: float = 11000.0,
        reference_height: float = 0.0,
        humidity: float = 0.0,
        latitude: float = 45.0,
    ) -> None:
        self.T0, self.p0 = as_number(T0, "T0"), as_number(p0, "p0")
        self.lapse, self.latitude = as_number(lapse, "lapse"), as_number(latitude, "latitude")
        self.reference_height = as_number(reference_height, "reference_height")
        self.tropopause = max(as_number(tropopause, "tropopause"), self.reference_height)
        self._relative = as_number(humidity, "humidity")
        self._check()
        self.ground = min(0.0, self.reference_height)
        self._gravity = 9.784 * (
            1.0 - 0.0026 * np.cos(np.radians(2.0 * self.latitude)) - 2.8e-7 * self.reference_height
        )
        self._vapour = self._vapour_at_reference()
        edge = np.array([self.tropopause])
        self._edge_temperature = float(self._temperature(edge)[0])
        pressure, vapour = self._troposphere(edge)
        self._edge_pressure, self._edge_vapour = float(pressure[0]), float(vapour[0])

    def _check(self) -> None:
        if not 100.0 <= self.T0 <= 400.0:
            raise ValueError(f"T0 is {self.T0:g} K; 100 to 400 are allowed: is it in °C?")
        if not 0.0 < self.p0 <= 2e5 or (self.p0 < 2000.0 and self.reference_height < 20e3):
            raise ValueError(f"p0 is {self.p0:g} Pa; 2000 to 200000 are allowed below 20 km: is it in hPa?")
        if not 0.0 <= self._relative <= 1.0:
            raise ValueError(f"humidity is {self._relative:g}; 0 to 1 are allowed: is it in percent?")
        if not abs(self.latitude) <= 90.0:
            raise ValueError(f"latitude is {self.latitude:g}; -90 to 90 are allowed")
        if not -500.0 <= self.reference_height < self.top:
            raise ValueError(f"reference_height is {self.reference_height:g} m; -500 to {self.top:g} are allowed")
        if not self.tropopause < self.top:
            raise ValueError(f"tropopause is {self.tropopause:g} m; below {self.top:g} is needed")
        if not abs(self.lapse) <= 0.1:
            raise ValueError(f"lapse is {self.lapse:g} K/m; -0.1 to 0.1 are allowed: is it in K/km?")
        coldest = self.T0 - self.lapse * (self.tropopause - self.reference_height)
        if not 50.0 <= coldest <= 1000.0:
            raise ValueError(
                f"lapse is {self.lapse:g} K/m and gives {coldest:g} K at the tropopause, {self.tropopause:g} m; "
                "50 to 1000 K are allowed"
            )

    def _vapour_at_reference(self) -> float:
        """e₀ from the relative humidity, Pa (A. L. Buck, J. Appl. Meteorol. 20, 1527 (1981), as the authors use it)."""
        celsius, hectopascal = self.T0 - 273.15, 0.01 * self.p0
        saturated = 10.0 ** ((0.7859 + 0.03477 * celsius) / (1.0 + 0.00412 * celsius))
        saturated *= 1.0 + hectopascal * (4.5e-6 + 6e-10 * celsius * celsius)
        return float(100.0 * self._relative * saturated / (1.0 - (1.0 - self._relative) * saturated / hectopascal))

    def _temperature(self, h: FloatArray) -> FloatArray:
        return self.T0 - self.lapse * (np.minimum(h, self.tropopause) - self.reference_height)

    def _troposphere(self, h: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Pressure and vapour pressure by (1)."""
        missing = 1.0 - MOLAR_VAPOUR / MOLAR_DRY
        rate = self._gravity * MOLAR_DRY / GAS_CONSTANT
        if self.lapse == 0.0:  # the limit of (1): γ → ∞, τ = 1
            surplus = -self._vapour * missing
            fall = np.exp(-rate * (h - self.reference_height) / self.T0)
            return (self.p0 + surplus) * fall - surplus, np.full_like(h, self._vapour)
        gamma = rate / self.lapse
        ratio = np.log(self._temperature(h) / self.T0)
        surplus = self._vapour * missing * gamma / (_DELTA - gamma)
        damp = np.exp(_DELTA * ratio)
        return (self.p0 + surplus) * np.exp(gamma * ratio) - surplus * damp, self._vapour * damp

    def _pressure(self, h: FloatArray) -> FloatArray:
        low = np.minimum(h, self.tropopause)
        above = self._gravity * MOLAR_DRY / (GAS_CONSTANT * self._edge_temperature) * (h - low)
        return self._troposphere(low)[0] * np.exp(-above)

    def _fraction(self, h: FloatArray) -> FloatArray:
        pressure, vapour = self._troposphere(np.minimum(h, self.tropopause))
        return vapour / pressure

    def _rate(self, h: FloatArray) -> FloatArray:
        # In the stratosphere all of the gas falls off with the dry scale height, as in the source.
        fraction = np.where(h < self.tropopause, self._fraction(h), 0.0)
        molar = MOLAR_DRY - (MOLAR_DRY - MOLAR_VAPOUR) * fraction
        return self._gravity * molar / (GAS_CONSTANT * self._temperature(h))

    def _kinks(self) -> list[float]:
        return [self.tropopause]

    def __repr__(self) -> str:
        return (
            f"Polytropic(T0={self.T0:g}, p0={self.p0:g}, lapse={self.lapse:g}, tropopause={self.tropopause:g}, "
            f"reference_height={self.reference_height:g}, humidity={self._relative:g}, latitude={self.latitude:g})"
        )
