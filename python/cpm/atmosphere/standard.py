"""The U.S. Standard Atmosphere 1976 (NOAA-S/T 76-1562, NASA, USAF)."""

from __future__ import annotations

import numpy as np

from .._arrays import FloatArray
from ._profile import GAS_CONSTANT, MOLAR_DRY, STANDARD_GRAVITY, Profile, geometric, geopotential, gravity

# Table 4: geopotential height (m) of each layer's base, and its gradient of molecular temperature (K/m).
_BASES = np.array([0.0, 11e3, 20e3, 32e3, 47e3, 51e3, 71e3])
_LAPSES = np.array([-6.5e-3, 0.0, 1e-3, 2.8e-3, 0.0, -2.8e-3, -2e-3])
_RATE = STANDARD_GRAVITY * MOLAR_DRY / GAS_CONSTANT  # K/m


def _layers() -> tuple[FloatArray, FloatArray]:
    """Temperature and pressure at the bases (eqs. 23, 33a, 33b)."""
    temperature, pressure = [288.15], [101325.0]
    for lapse, thickness in zip(_LAPSES, np.diff(_BASES), strict=False):
        t = temperature[-1] + lapse * thickness
        ratio = (temperature[-1] / t) ** (_RATE / lapse) if lapse else np.exp(-_RATE * thickness / t)
        temperature.append(t)
        pressure.append(pressure[-1] * ratio)
    return np.array(temperature), np.array(pressure)


class USStandard1976(Profile):
    """The standard atmosphere of mid latitudes: dry, 288.15 K and 101325 Pa at sea level, to 86 km.

    Heights are geometric. Temperatures are the standard's molecular-scale temperatures, which hold for density and
    refraction; above 80 km kinetic ones are up to 0.04 % lower. Below sea level the lowest layer goes on.
    """

    top = 86e3

    def __init__(self) -> None:
        self._base_temperature, self._base_pressure = _layers()

    def _layer(self, h: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Base temperature and pressure, lapse, height above the base."""
        height = geopotential(h)
        i = np.clip(np.searchsorted(_BASES, height, side="right") - 1, 0, _BASES.size - 1)
        return self._base_temperature[i], self._base_pressure[i], _LAPSES[i], height - _BASES[i]

    def _temperature(self, h: FloatArray) -> FloatArray:
        temperature, _, lapse, above = self._layer(h)
        return temperature + lapse * above

    def _pressure(self, h: FloatArray) -> FloatArray:
        temperature, pressure, lapse, above = self._layer(h)
        sloped = lapse != 0.0
        slope = np.where(sloped, lapse, 1.0)
        power = -_RATE / slope * np.log1p(np.where(sloped, lapse * above / temperature, 0.0))
        return pressure * np.exp(np.where(sloped, power, -_RATE * above / temperature))

    def _rate(self, h: FloatArray) -> FloatArray:
        return gravity(h) * MOLAR_DRY / (GAS_CONSTANT * self._temperature(h))

    def _kinks(self) -> list[float]:
        return list(geometric(_BASES[1:]))

    def __repr__(self) -> str:
        return "USStandard1976()"
