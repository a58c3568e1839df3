"""Astronomical refraction through a spherically symmetric profile.

Along a ray n r sin ψ = k is constant, ψ being the angle from the vertical, and the ray turns by

    R = ∫ f k/√Q dr,   f = −n'/n,   Q = n² r² − k²                                                                  (1)

over the heights that it passes. Auer and Standish (Astron. J. 119, 2472 (2000)) integrate over ψ instead, which takes
the root away at a turning point, and fails where n r has an extremum: in a duct. Here each thin layer takes f linear
and Q quadratic in height, from their values at its ends and middle, which has a closed form without cancellation
whatever Q does: with w = √Q at the ends, d the thickness, C the coefficient of Q's square term,

    ∫ dr/√Q = (2 d/S) A(C d²/S²),   S = w_a + w_b,   A(x) = artanh(√x)/√x, arctan(√−x)/√−x                           (2)
    ∫ (r − r_m) dr/√Q = −d² (w_b − w_a)/(3 S²)   (for C = 0; f varies little)                                        (3)

A ray that goes down is followed to where Q = 0 and back up. Layers end where n r has an extremum, so that Q is
monotonic within each.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .._arrays import FloatArray, as_array, as_number, one_of
from ..air import MODELS
from ._knots import breaks, sample
from ._profile import Profile

# Layers over which f changes by a factor e, and the most that an interval which a cubic would serve is split into:
# 1e-4 arc seconds at the horizon.
_FINE, _SPLIT = 180, 10


def refraction(
    profile: Profile,
    zenith: npt.ArrayLike,
    wavelength: npt.ArrayLike = 574.0,
    height: npt.ArrayLike = 0.0,
    refractivity: str = "ciddor",
    *,
    radius: float | None = None,
    unreachable: str = "raise",
) -> Any:
    """Astronomical refraction: true minus apparent zenith distance.

    Parameters
    ----------
    profile : Profile
        Of :mod:`cpm.atmosphere`.
    zenith : array_like
        Apparent zenith distance, degrees, 0 to 180; beyond 90 the ray goes down first.
    wavelength : array_like
        nm, in vacuum.
    height : array_like
        Of the observer, metres, as the profile counts. All three broadcast. Above the profile's top a ray that does not
        come down into the air is not refracted.
    refractivity : {"ciddor", "edlen", "iag1999"}
        Index of air.
    radius : float, optional
        Of the level that heights count from, metres; default the profile's.
    unreachable : {"raise", "nan"}
        A ray that meets the ground, or is trapped in a duct and never leaves the air, has no refraction: an error that
        names the first one, or NaN in its place.

    Returns
    -------
    float or ndarray
        Degrees, ≥ 0 in ordinary air.
    """
    if not isinstance(profile, Profile):
        raise TypeError(f"profile is {profile!r}; a profile of cpm.atmosphere is needed")
    one_of(refractivity, "refractivity", MODELS)
    one_of(unreachable, "unreachable", ("raise", "nan"))
    r = profile.radius if radius is None else as_number(radius, "radius")
    if not r > 0:
        raise ValueError(f"radius is {r:g} m; above 0 is needed")
    z, w, h = (
        as_array(value, name) for value, name in ((zenith, "zenith"), (wavelength, "wavelength"), (height, "height"))
    )
    bad = np.flatnonzero(~((np.atleast_1d(z) >= 0) & (np.atleast_1d(z) <= 180)).ravel())
    if bad.size:
        raise ValueError(f"zenith[{bad[0]}] is {np.atleast_1d(z).ravel()[bad[0]]:g} degrees; 0 to 180 are allowed")
    heights = np.atleast_1d(h).ravel()
    bad = np.flatnonzero(~(np.isfinite(heights) & (heights > -r)))
    if bad.size:
        raise ValueError(f"height[{bad[0]}] is {heights[bad[0]]:g} m; finite and above -{r:g} is needed")

    z, w, h = np.broadcast_arrays(z, w, h)
    out, why = np.empty(z.shape), np.zeros(z.shape, dtype=np.int8)
    pairs, which = np.unique(np.stack([w.ravel(), h.ravel()], axis=1), axis=0, return_inverse=True)
    for i, (one_wavelength, one_height) in enumerate(pairs):
        here = (which.ravel() == i).reshape(z.shape)
        layers = _Layers(profile, float(one_wavelength), float(one_height), r, refractivity)
        out[here], why[here] = layers.bend(z[here])
    lost = np.flatnonzero(why.ravel())
    if lost.size and unreachable == "raise":
        where = f"[{lost[0]}]" if z.ndim else ""
        what = (
            "meets the ground" if why.ravel()[lost[0]] == _GROUND else "is trapped in a duct and never leaves the air"
        )
        raise ValueError(
            f'zenith{where} is {z.ravel()[lost[0]]:g} degrees: the ray {what}; unreachable="nan" gives NaN there'
        )
    return np.degrees(out) if out.ndim else float(np.degrees(out))


_GROUND, _DUCT = 1, 2


class _Layers:
    """What (1) to (3) need of each layer, for one wavelength and one observer; heights ascend."""

    def __init__(self, profile: Profile, wavelength: float, height: float, radius: float, model: str) -> None:
        def index(h: FloatArray) -> FloatArray:
            return np.asarray(profile.refractivity(h, wavelength, model))

        self.outside = height >= profile.top
        ground = min(profile.ground, height)
        starts = breaks(profile, ground, profile.top)
        if not self.outside:
            starts = np.unique(np.append(starts, height))
        knots = sample(index, starts, lambda value: np.maximum(1e-12, 1e-8 * value))
        knots = _split(knots, index)

        # x = n r − n₀ r₀, from small terms: n r itself has 1e-9 m of rounding.
        own = 0.0 if self.outside else float(index(np.array(height)))
        self.momentum = (1.0 + own) * (radius + height)

        def offset(h: FloatArray, n: FloatArray) -> FloatArray:
            return (h - height) + ((radius + h) * n - (radius + height) * own)

        knots = _with_extrema(knots, lambda h: offset(h, index(h)))
        h = np.empty(2 * knots.size - 1)  # ends and middles
        h[::2], h[1::2] = knots, 0.5 * (knots[1:] + knots[:-1])
        n = index(h)
        x = offset(h, n)
        q = x * (2.0 * self.momentum + x)  # Q at k = n₀ r₀
        bend = np.log1p((n[:-1] - n[1:]) / (1.0 + n[1:]))  # ∫ f dr of half a layer
        self.d, self.x = np.diff(knots), x[::2]
        self.curve = 2.0 * (q[:-2:2] - 2.0 * q[1:-1:2] + q[2::2]) / self.d**2
        self.whole, self.change = bend[::2] + bend[1::2], bend[1::2] - bend[::2]
        self.start = knots.size - 1 if self.outside else int(np.searchsorted(knots, height))

    def bend(self, zenith: FloatArray) -> tuple[FloatArray, npt.NDArray[np.int8]]:
        """R in radians, and why there is none (0 where there is)."""
        # k = n₀ r₀ sin z, and n₀ r₀ − k without cancellation near the horizon.
        self.less = self.momentum * 2.0 * np.sin(np.radians(0.5 * (90.0 - zenith))) ** 2
        self.k = self.momentum - self.less
        total, why = np.zeros(zenith.shape), np.zeros(zenith.shape, dtype=np.int8)
        down = zenith > 90.0
        if self.start + 1 < self.x.size and self.x[self.start + 1] < self.x[self.start]:
            down |= zenith == 90.0  # on the ceiling of a duct a level ray starts down
        self._down(np.flatnonzero(down), total, why)
        if not self.outside:
            self._up(np.flatnonzero(why == 0), total, why)
        total[why > 0] = np.nan
        return total, why

    def _root(self, i: int, rays: Any) -> FloatArray:
        """Q at knot i."""
        gap = self.x[i] + self.less[rays]
        return np.asarray(gap * (self.x[i] + self.momentum + self.k[rays]))

    def _up(self, rays: Any, total: FloatArray, why: npt.NDArray[np.int8]) -> None:
        below = np.sqrt(np.maximum(self._root(self.start, rays), 0.0))
        for i in range(self.start, self.d.size):
            above = self._root(i + 1, rays)
            turned = above <= 0.0
            if turned.any():
                why[rays[turned]] = _DUCT
                rays, below, above = rays[~turned], below[~turned], above[~turned]
            if not rays.size:
                return
            above = np.sqrt(above)
            total[rays] += self.k[rays] * self._layer(i, self.d[i], self.whole[i], below, above)
            below = above

    def _down(self, rays: Any, total: FloatArray, why: npt.NDArray[np.int8]) -> None:
        above = np.maximum(self._root(self.start, rays), 0.0)
        if self.outside:  # rays that pass over the air
            rays, above = rays[above > 0.0], above[above > 0.0]
        for i in range(self.start - 1, -1, -1):
            if not rays.size:
                return
            below = self._root(i, rays)
            ends = below <= 0.0
            if ends.any():
                total[rays[ends]] += 2.0 * self.k[rays[ends]] * self._turn(i, below[ends], above[ends])
                rays, below, above = rays[~ends], below[~ends], above[~ends]
            part = self._layer(i, self.d[i], self.whole[i], np.sqrt(below), np.sqrt(above))
            total[rays] += 2.0 * self.k[rays] * part
            above = below
        why[rays] = _GROUND

    def _layer(self, i: int, d: Any, whole: Any, below: FloatArray, above: FloatArray) -> FloatArray:
        """(2) and (3), without k, of thickness d in which ∫ f dr is ``whole``."""
        s = below + above
        slope = 4.0 * self.change[i] / self.d[i] ** 2
        return np.asarray(
            (2.0 * whole / s) * _area(self.curve[i] * (d / s) ** 2) - slope * d * d * (above - below) / (3.0 * s * s)
        )

    def _turn(self, i: int, below: FloatArray, above: FloatArray) -> FloatArray:
        """From where Q = 0 in layer i to its upper end."""
        d, curve = self.d[i], self.curve[i]
        slope = (above - below) / d + curve * d  # of Q at the upper end
        s = 2.0 * above / (slope + np.sqrt(np.maximum(slope * slope - 4.0 * curve * above, 0.0)))
        s = np.minimum(np.where(above > 0.0, s, 0.0), d)
        mean = self.whole[i] / d + 4.0 * self.change[i] / d**2 * 0.5 * (d - s)
        out = np.zeros_like(s)
        some = s > 0.0
        out[some] = self._layer(i, s[some], (mean * s)[some], np.zeros(int(some.sum())), np.sqrt(above[some]))
        return out


def _area(x: FloatArray) -> FloatArray:
    """A of (2). x < 1; 1 is a ray that stays at an extremum for ever."""
    series = 1.0 + x * (1 / 3 + x * (1 / 5 + x * (1 / 7 + x * (1 / 9 + x * (1 / 11)))))
    far = np.abs(x) > 1e-3
    if far.any():
        y = x[far]
        root = np.sqrt(np.minimum(np.abs(y), np.where(y > 0, 1.0 - 1e-15, np.inf)))
        series[far] = np.where(y > 0, np.arctanh(np.minimum(root, 1.0 - 1e-16)), np.arctan(root)) / root
    return series


def _split(knots: FloatArray, index: Any) -> FloatArray:
    """Cuts intervals where f changes by more than a hundredth or so; half a layer's f against the other's tells."""
    n, middle = index(knots), index(0.5 * (knots[1:] + knots[:-1]))
    lower, upper = n[:-1] - middle, middle - n[1:]
    change = 4.0 * np.abs(upper - lower) / (np.abs(upper) + np.abs(lower) + 1e-300)
    pieces = np.clip(np.ceil(_FINE * change), 1, _SPLIT).astype(int)
    first = np.repeat(knots[:-1], pieces)
    part = np.arange(first.size) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.append(first + part * np.repeat(np.diff(knots) / pieces, pieces), knots[-1])


def _with_extrema(knots: FloatArray, offset: Any) -> FloatArray:
    """Adds the heights where n r has an extremum, to rounding."""
    x = offset(knots)
    step = np.sign(np.diff(x))
    turns = np.flatnonzero(step[:-1] * step[1:] < 0)
    if not turns.size:
        return knots
    low, high, sign = knots[turns], knots[turns + 2], step[turns]
    for _ in range(60):  # golden ratio would save a third of the evaluations; ducts are few
        third = (high - low) / 3.0
        left = sign * offset(low + third) < sign * offset(high - third)
        low, high = np.where(left, low + third, low), np.where(left, high, high - third)
    found = 0.5 * (low + high)
    near = knots[np.clip(np.searchsorted(knots, found), 1, knots.size - 1)]
    below = knots[np.clip(np.searchsorted(knots, found), 1, knots.size - 1) - 1]
    apart = np.minimum(np.abs(near - found), np.abs(found - below)) > 1e-9 * (1.0 + np.abs(found))
    return np.unique(np.concatenate([knots, found[apart]]))
