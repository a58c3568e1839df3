"""A profile of measured levels."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import air
from .._arrays import FloatArray, as_array, one_of
from ._profile import GAS_CONSTANT, MOLAR_DRY, MOLAR_VAPOUR, Profile, geopotential, gravity, nodes_between

_STEP = 100.0  # metres: between where pressure is integrated and kept


class Table(Profile):
    """Levels of temperature, pressure and humidity.

    Parameters
    ----------
    h : array_like, shape (K,)
        Geometric heights, metres, strictly increasing, K ≥ 2.
    T : array_like, shape (K,)
        K.
    p : array_like, shape (K,), or float, optional
        Pa. One number: the pressure at h[0], and the rest by hydrostatics of the moist air. Default 101325.
    rh : array_like, shape (K,), or float, optional
        Relative humidity over liquid water, a fraction. Default: dry.
    interpolation : {"linear", "monotone"}
        Of temperature between the levels: with a kink at each level, or with continuous slope (Fritsch and Carlson
        1980). Kinks of temperature are seen in mirages; smooth tables want "monotone".

    Notes
    -----
    Between levels with given pressures ln p follows hydrostatics through both ends. Below the first level and above the
    last one the air is isothermal, with their share of vapour, up to 80 km. The ground is at h[0].
    """

    def __init__(
        self,
        h: npt.ArrayLike,
        T: npt.ArrayLike,
        p: npt.ArrayLike | None = None,
        rh: npt.ArrayLike | None = None,
        interpolation: str = "linear",
    ) -> None:
        self.h, self.T = as_array(h, "h"), as_array(T, "T")
        if self.h.ndim != 1 or self.h.size < 2:
            raise ValueError(f"h has shape {self.h.shape}; at least 2 heights are needed")
        self.interpolation = one_of(interpolation, "interpolation", ("linear", "monotone"))
        self.rh = as_array(0.0 if rh is None else rh, "rh")
        if not self.rh.ndim:
            self.rh = np.full(self.h.shape, self.rh)
        given = as_array(101325.0 if p is None else p, "p")
        self._check(given)
        self.ground = float(self.h[0])
        self.top = max(80e3, float(self.h[-1]))
        self._slopes = _monotone_slopes(self.h, self.T) if interpolation == "monotone" else None
        self._knots: FloatArray
        self._logs: FloatArray
        self._hydrostatic = not given.ndim
        if self._hydrostatic:
            self._integrate(float(given))
            self.p = np.exp(np.interp(self.h, self._knots, self._logs))
        else:
            self.p, self._knots, self._logs = given, self.h, np.log(given)
        self._ends = [self._end(0), self._end(-1)]

    def _check(self, given: FloatArray) -> None:
        for values, name, low, high, unit, hint in (
            (self.T, "T", 100.0, 400.0, " K", ": is it in °C?"),
            (self.rh, "rh", 0.0, 1.5, "", ": a fraction; is it in percent?"),
            (np.atleast_1d(given), "p", 1e-3, 2e5, " Pa", ""),
        ):
            if name != "p" or given.ndim:
                if values.shape != self.h.shape:
                    raise ValueError(f"{name} has shape {values.shape}; h has {self.h.shape}")
            bad = np.flatnonzero(~((values >= low) & (values <= high)))
            if bad.size:
                raise ValueError(f"{name}[{bad[0]}] is {values[bad[0]]:g}{unit}; {low:g} to {high:g} are allowed{hint}")
        rising = np.isfinite(self.h) & (np.abs(self.h) < 1e5)
        rising[1:] &= np.diff(self.h) > 0
        if not rising.all():
            i = int(np.flatnonzero(~rising)[0])
            raise ValueError(f"h[{i}] is {self.h[i]:g} m; heights must be finite, below 100 km and increase strictly")
        if given.ndim and not (np.diff(given) < 0).all():
            i = int(np.flatnonzero(~(np.diff(given) < 0))[0]) + 1
            raise ValueError(
                f"p[{i}] is {given[i]:g} Pa; pressure must fall with height, p[{i - 1}] is {given[i - 1]:g}"
            )
        if not given.ndim and given < 2000.0:
            raise ValueError(f"p is {float(given):g} Pa at h[0]; at least 2000 is needed: is it in hPa?")

    # Temperature and humidity.

    def _temperature(self, h: FloatArray) -> FloatArray:
        if self._slopes is None:
            return np.interp(h, self.h, self.T)
        x = np.clip(h, self.h[0], self.h[-1])
        i = np.clip(np.searchsorted(self.h, x, side="right") - 1, 0, self.h.size - 2)
        width = self.h[i + 1] - self.h[i]
        t = (x - self.h[i]) / width
        return (
            (1 + 2 * t) * (1 - t) ** 2 * self.T[i]
            + t * (1 - t) ** 2 * width * self._slopes[i]
            + t * t * (3 - 2 * t) * self.T[i + 1]
            + t * t * (t - 1) * width * self._slopes[i + 1]
        )

    def _fraction_at(self, h: FloatArray, pressure: FloatArray) -> FloatArray:
        t = self._temperature(h)
        vapour = air.vapour_pressure(t, pressure, np.interp(h, self.h, self.rh))
        return np.minimum(vapour / pressure, 0.5)

    # Pressure: at knots, and from the knot below by a short integral.

    def _rate_at(self, h: FloatArray, pressure: FloatArray) -> FloatArray:
        molar = MOLAR_DRY - (MOLAR_DRY - MOLAR_VAPOUR) * self._fraction_at(h, pressure)
        return gravity(h) * molar / (GAS_CONSTANT * self._temperature(h))

    def _integrate(self, first: float) -> None:
        """Knots, ln p at each. d ln p/dh depends on p through the vapour's share only."""
        pieces = [
            np.linspace(a, b, max(1, int(np.ceil((b - a) / _STEP))), endpoint=False)
            for a, b in zip(self.h[:-1], self.h[1:], strict=True)
        ]
        self._knots = np.concatenate([*pieces, self.h[-1:]])
        self._logs = np.empty_like(self._knots)
        self._logs[0] = np.log(first)
        for i in range(self._knots.size - 1):
            self._logs[i + 1] = self._logs[i] - self._fall(np.array([i]), self._knots[i + 1 : i + 2])[0]

    def _fall(self, i: npt.NDArray[np.intp], h: FloatArray) -> FloatArray:
        """ln p_i − ln p(h), between knots i and i + 1."""
        start = self._knots[i]
        nodes, weights = nodes_between(start, h)
        pressure = np.exp(self._logs[i])
        guess = pressure[..., None] * np.exp(-self._rate_at(start, pressure)[..., None] * (nodes - start[..., None]))
        return np.asarray(np.sum(weights * self._rate_at(nodes, guess), axis=-1))

    def _stretch(self, i: npt.NDArray[np.intp]) -> FloatArray:
        """Measured fall of ln p between knots over the hydrostatic one: 1 where it was not measured."""
        if self._hydrostatic:
            return np.ones(i.shape)
        return (self._logs[i] - self._logs[i + 1]) / self._fall(i, self._knots[i + 1])

    def _pressure(self, h: FloatArray) -> FloatArray:
        x = np.clip(h, self._knots[0], self._knots[-1])
        i = np.clip(np.searchsorted(self._knots, x, side="right") - 1, 0, self._knots.size - 2)
        log = self._logs[i] - self._fall(i, x) * self._stretch(i)
        for end, beyond in zip(self._ends, (h < x, h > x), strict=True):
            log = np.where(beyond, end[1] - end[2] * (geopotential(h) - end[0]), log)
        return np.exp(log)

    def _end(self, i: int) -> tuple[float, float, float]:
        """Geopotential height, ln p and fall of ln p with geopotential height, of the isothermal air beyond a level."""
        height, pressure = self.h[i], np.exp(self._logs[i])
        rate = float(self._rate_at(np.array([height]), np.array([pressure]))[0] / gravity(height))
        return float(geopotential(height)), float(self._logs[i]), rate * 9.80665

    def _fraction(self, h: FloatArray) -> FloatArray:
        inside = np.clip(h, self.h[0], self.h[-1])
        return self._fraction_at(inside, self._pressure(inside))

    def _rate(self, h: FloatArray) -> FloatArray:
        inside = np.clip(h, self.h[0], self.h[-1])
        rate = self._rate_at(inside, self._pressure(inside)) * gravity(h) / gravity(inside)
        i = np.clip(np.searchsorted(self._knots, inside, side="right") - 1, 0, self._knots.size - 2)
        return np.where(h == inside, self._stretch(i), 1.0) * rate

    def _kinks(self) -> list[float]:
        return list(self.h)

    def __repr__(self) -> str:
        return f"Table({self.h.size} levels, {self.h[0]:g} to {self.h[-1]:g} m)"


def _monotone_slopes(x: FloatArray, y: FloatArray) -> FloatArray:
    """Slopes that keep a cubic Hermite interpolant monotone (Fritsch and Butland's weighted harmonic mean)."""
    width, slope = np.diff(x), np.diff(y) / np.diff(x)
    slopes = np.empty_like(y)
    slopes[0], slopes[-1] = slope[0], slope[-1]
    left, right = slope[:-1], slope[1:]
    first, second = 2 * width[1:] + width[:-1], width[1:] + 2 * width[:-1]
    same = left * right > 0
    safe_left, safe_right = np.where(same, left, 1.0), np.where(same, right, 1.0)
    slopes[1:-1] = np.where(same, (first + second) / (first / safe_left + second / safe_right), 0.0)
    return slopes
