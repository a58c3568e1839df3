"""Layers of warmer or colder air on top of any profile.

T = T_b + ΔT(h). Hydrostatics, with the share of vapour of the base, gives

    ln p = ln p_b + ∫ q_b (1 − T_b/T) dh   from the ground,   q_b = −d ln p_b/dh                                     (1)

so that the pressure at the ground is the base's: what a barometer there says.
"""

from __future__ import annotations

import numpy as np

from .._arrays import FloatArray, as_number
from ._profile import Profile, nodes_between

_STEP = 250.0  # metres, between where the integral of (1) is kept


class _Changed(Profile):
    """A base and a difference of temperature."""

    def __init__(self, base: Profile, features: list[float]) -> None:
        if not isinstance(base, Profile):
            raise TypeError(f"base is {base!r}; a profile of cpm.atmosphere is needed")
        self.base = base
        self.ground, self.top, self.radius = base.ground, base.top, base.radius
        self._own = [h for h in features if h < self.top]
        lowest = self.ground - 2 * _STEP
        knots = np.unique(
            np.concatenate(
                [
                    np.arange(lowest, self.top, _STEP),
                    [self.ground],
                    [h for h in [*self._own, *base._kinks(), *base._features()] if lowest < h < self.top],
                ]
            )
        )
        air = knots[knots >= self.ground]
        temperature = self._temperature(air)
        if not (np.abs(temperature - 275.0) <= 225.0).all():
            bad = int(np.argmax(np.abs(temperature - 275.0)))
            raise ValueError(
                f"{type(self).__name__} gives {temperature[bad]:g} K at {air[bad]:g} m; 50 to 500 K are allowed"
            )
        self._knots = knots
        pieces = self._correction(knots[:-1], knots[1:])
        self._sums = np.concatenate([[0.0], np.cumsum(pieces)])
        self._sums -= self._sums[np.searchsorted(knots, self.ground)]

    def _difference(self, h: FloatArray) -> FloatArray:
        raise NotImplementedError

    def _temperature(self, h: FloatArray) -> FloatArray:
        return self.base._temperature(h) + self._difference(h)

    def _correction(self, low: FloatArray, high: FloatArray) -> FloatArray:
        nodes, weights = nodes_between(low, high)
        difference = self._difference(nodes)
        warmer = difference / (self.base._temperature(nodes) + difference)
        return np.asarray(np.sum(weights * self.base._rate(nodes) * warmer, axis=-1))

    def _pressure(self, h: FloatArray) -> FloatArray:
        i = np.clip(np.searchsorted(self._knots, h, side="right") - 1, 0, self._knots.size - 1)
        return self.base._pressure(h) * np.exp(self._sums[i] + self._correction(self._knots[i], h))

    def _fraction(self, h: FloatArray) -> FloatArray:
        return self.base._fraction(h)

    def _rate(self, h: FloatArray) -> FloatArray:
        return self.base._rate(h) * self.base._temperature(h) / self._temperature(h)

    def _kinks(self) -> list[float]:
        return self.base._kinks()

    def _features(self) -> list[float]:
        return self.base._features() + self._own


def _check_thickness(thickness: float) -> None:
    if not 1e-4 <= thickness <= 1e5:
        raise ValueError(f"thickness is {thickness:g} m; 0.0001 to 100000 are allowed")


class HotSurface(_Changed):
    """Air over a surface of another temperature: T = T_base + excess · exp(−(h − ground)/thickness).

    Parameters
    ----------
    base : Profile
        What is above.
    excess : float
        K at the surface, -80 to 500; negative over a cold one.
    thickness : float
        Height over which the excess falls to 1/e, metres.
    """

    def __init__(self, base: Profile, excess: float, thickness: float) -> None:
        self.excess, self.thickness = as_number(excess, "excess"), as_number(thickness, "thickness")
        if not -80.0 <= self.excess <= 500.0:
            raise ValueError(f"excess is {self.excess:g} K; -80 to 500 are allowed")
        _check_thickness(self.thickness)
        ground = base.ground if isinstance(base, Profile) else 0.0
        steps = (0.25, 0.5, 1, 1.5, 2, 3, 4, 6, 8, 12, 16, 24, 32, 40)
        super().__init__(base, [ground + self.thickness * k for k in (*steps, *(-k for k in steps))])

    def _difference(self, h: FloatArray) -> FloatArray:
        # Under the ground it goes on for half a thickness and then stays bounded: no ray sees it, but integrators step
        # there.
        x = (h - self.base.ground) / self.thickness
        deep = np.exp(2.0 * np.minimum(x + 0.5, 0.0))
        return self.excess * np.exp(-np.maximum(x, -0.5)) * (1.5 - 0.5 * deep)

    def __repr__(self) -> str:
        return f"HotSurface({self.base!r}, excess={self.excess:g}, thickness={self.thickness:g})"


class Inversion(_Changed):
    """Cold air below warm air: T = T_base − strength · ½ (1 − tanh(2 (h − height)/thickness)).

    Above the inversion the air is the base's; below it is colder by ``strength``.

    Parameters
    ----------
    base : Profile
        What is above.
    height : float
        Of the middle of the inversion, metres, counted as the base counts.
    strength : float
        K; negative makes a layer through which temperature falls.
    thickness : float
        Metres; 96 % of the change happens within it.
    """

    def __init__(self, base: Profile, height: float, strength: float, thickness: float) -> None:
        self.height, self.strength = as_number(height, "height"), as_number(strength, "strength")
        self.thickness = as_number(thickness, "thickness")
        _check_thickness(self.thickness)
        if isinstance(base, Profile) and not base.ground <= self.height < base.top:
            raise ValueError(f"height is {self.height:g} m; {base.ground:g} to {base.top:g} are allowed")
        steps = np.array([0.125, 0.25, 0.375, 0.5, 0.75, 1, 1.5, 2, 3, 4, 6, 8, 10])
        around = np.concatenate([-steps, [0.0], steps])
        super().__init__(base, list(self.height + self.thickness * around))

    def _difference(self, h: FloatArray) -> FloatArray:
        return -0.5 * self.strength * (1.0 - np.tanh(2.0 * (h - self.height) / self.thickness))

    def __repr__(self) -> str:
        numbers = f"height={self.height:g}, strength={self.strength:g}, thickness={self.thickness:g}"
        return f"Inversion({self.base!r}, {numbers})"
