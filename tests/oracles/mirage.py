"""Mirages by means that share nothing with the library's: air from its laws, rays by SciPy.

Dry air near the ground under the standard atmosphere: T = 288.15 K − 6.5 K/km of geopotential height, changed by a hot
surface or an inversion; p from hydrostatics, p(0) = 101325 Pa; n from Ciddor, Appl. Opt. 35, 1566 (1996), appendices A
and B, for 450 ppm of CO₂. Rays in the plane (x, y), over a flat Earth or a round one of radius R under x = 0:

    dx/dσ = p_x,   dy/dσ = p_y,   dp/dσ = ½∇n²(h),   h = y, or (2 R y + x² + y²)/(R + |r|)             (1)
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

GRAVITY, EARTH_OF_GRAVITY, GAS, MOLAR = 9.80665, 6356766.0, 8314.32, 28.9644


def hot_surface(excess, thickness):
    """ΔT(h), dΔT/dh of excess · exp(−h/thickness), above the ground."""

    def change(h):
        value = excess * np.exp(-h / thickness)
        return value, -value / thickness

    return change


def inversion(height, strength, thickness):
    """ΔT(h), dΔT/dh of air that is colder by `strength` under `height`."""

    def change(h):
        t = np.tanh(2 * (h - height) / thickness)
        return -0.5 * strength * (1 - t), strength * (1 - t * t) / thickness

    return change


class Air:
    """n(h) of the standard atmosphere below 11 km with the sum of some changes of temperature.

    Parameters
    ----------
    changes : callables
        As `hot_surface` returns them.
    wavelength : float
        nm.
    top : float
        Metres; the pressure is tabulated from 0 to there.
    finest : float
        Metres between the table's knots at the ground, growing by 1 % a knot.
    """

    def __init__(self, *changes, wavelength=550.0, top=300.0, finest=1e-3):
        self.changes = changes
        knots = [0.0]
        while knots[-1] < top:
            knots.append(knots[-1] + max(finest, 0.01 * knots[-1]))
        knots = np.array(knots)
        pieces = [quad(self._rate, a, b, epsabs=0, epsrel=1e-12)[0] for a, b in pairwise(knots)]
        self._log_p = CubicSpline(knots, np.log(101325.0) - np.concatenate([[0.0], np.cumsum(pieces)]))
        s = (1e3 / wavelength) ** 2
        standard = 1e-8 * (5792105 / (238.0185 - s) + 167917 / (57.362 - s))  # 15 °C, 101325 Pa, 450 ppm: eq. (1)
        self._scale = standard * 288.15 / 101325.0 * self._compressibility(101325.0, 288.15)[0]

    def temperature(self, h):
        """K and K/m."""
        low = EARTH_OF_GRAVITY + h
        t, slope = 288.15 - 0.0065 * EARTH_OF_GRAVITY * h / low, -0.0065 * (EARTH_OF_GRAVITY / low) ** 2
        for change in self.changes:
            more = change(h)
            t, slope = t + more[0], slope + more[1]
        return t, slope

    def _rate(self, h):
        """−d ln p/dh."""
        return GRAVITY * (EARTH_OF_GRAVITY / (EARTH_OF_GRAVITY + h)) ** 2 * MOLAR / (GAS * self.temperature(h)[0])

    @staticmethod
    def _compressibility(p, t):
        """Z and its derivatives by p and T, dry: appendix A, equation (12)."""
        c = t - 273.15
        a, da = 1.58123e-6 - 2.9331e-8 * c + 1.1043e-10 * c * c, -2.9331e-8 + 2.2086e-10 * c
        q, d = p / t, 1.83e-11
        return 1 - q * a + q * q * d, (-a + 2 * q * d) / t, -q * da - q / t * (-a + 2 * q * d)

    def __call__(self, h):
        """n − 1 and its slope, 1/m."""
        (t, dt), p = self.temperature(h), np.exp(self._log_p(h))
        z, by_p, by_t = self._compressibility(p, t)
        dp = -p * self._rate(h)
        n1 = self._scale * p / (t * z)
        return n1, n1 * (dp / p - dt / t - (by_p * dp + by_t * dt) / z)


def follow(air, height, angle, distance, radius=None, ground=0.0):
    """Ray that starts at (0, height), `angle` (rad) above the horizontal.

    Returns
    -------
    tuple of float
        y where x = distance (NaN if it meets the ground before), and the lowest h on the way.
    """

    def local(x, y):
        if radius is None:
            return y, 0.0, 1.0
        rho = np.hypot(x, radius + y)
        return (2 * radius * y + x * x + y * y) / (radius + rho), x / rho, (radius + y) / rho

    def slope(_, state):
        x, y, px, py = state
        h, ux, uy = local(x, y)
        n1, dn = air(max(h, ground - 0.01))
        pull = (1 + n1) * dn
        return px, py, pull * ux, pull * uy

    def arrives(_, state):
        return state[0] - distance

    def lands(_, state):
        return local(*state[:2])[0] - ground

    def turns(_, state):
        _, ux, uy = local(*state[:2])
        return state[2] * ux + state[3] * uy

    arrives.terminal = lands.terminal = True
    lands.direction = -1
    n = 1 + air(height)[0]
    start = [0.0, height, n * np.cos(angle), n * np.sin(angle)]
    run = solve_ivp(slope, (0, 2 * distance), start, "DOP853", rtol=1e-12, atol=[1e-6, 1e-12, 1e-14, 1e-15],
                    events=[arrives, lands, turns], max_step=distance / 20)
    low = min([height, *(local(*state[:2])[0] for state in run.y_events[2])])
    return (float(run.y_events[0][0][1]) if len(run.t_events[0]) else np.nan), low


def curve(air, height, angles, distance, radius=None):
    """Transfer curve: heights above the ground at `distance` that rays under `angles` (rad, (N,)) reach, NaN: landed.

    All rays in one system over x (p_x never vanishes here), (1) divided by p_x. Air goes on under the ground, so that
    rays that land may be followed and told by their lowest point afterwards: to 1e-3 m of height around a round Earth,
    exactly (`vanishing`) over a flat one.
    """
    angles = np.asarray(angles, float)
    count, n = angles.size, 1 + air(height)[0]

    def local(x, y):
        if radius is None:
            return y, 0.0, 1.0
        rho = np.hypot(x, radius + y)
        return (2 * radius * y + x * x + y * y) / (radius + rho), x / rho, (radius + y) / rho

    def slope(x, state):
        y, px, py = state.reshape(3, count)
        h, ux, uy = local(x, y)
        n1, dn = air(h)
        pull = (1 + n1) * dn / px
        return np.concatenate([py / px, pull * ux, pull * uy])

    start = np.concatenate([np.full(count, float(height)), n * np.cos(angles), n * np.sin(angles)])
    run = solve_ivp(slope, (0, distance), start, "DOP853", rtol=1e-12, atol=1e-13, max_step=distance / 200)
    assert run.success, run.message
    y = run.y[:count]
    h = local(run.t, y)[0]
    landed = h.min(axis=1) < 0 if radius is not None else angles < vanishing(air, height)
    return np.where(landed, np.nan, h[:, -1])


def vanishing(air, height):
    """Angle above the horizontal (rad, negative) under which rays meet a flat ground: n(0) = n(height) cos."""
    ratio = (air(0.0)[0] - air(height)[0]) / (1 + air(height)[0])
    return -2 * np.arcsin(np.sqrt(-ratio / 2))


def turning(air, height, angle):
    """Lowest height of a ray over a flat Earth: n(h) = n(height) cos(angle)."""
    lost = 2 * np.sin(angle / 2) ** 2 * (1 + air(height)[0])
    return brentq(lambda h: air(h)[0] - air(height)[0] + lost, 0.0, height, xtol=1e-15, rtol=1e-14)


def image(air, height, between, distance, seen, radius=None):
    """Angle (rad) within `between` under which the height `seen` above y = 0 appears at `distance`, to 1e-10."""
    return brentq(lambda angle: follow(air, height, angle, distance, radius)[0] - seen, *between, xtol=1e-10)


def runs(marks):
    """Number of unbroken runs of True."""
    marks = np.concatenate([[False], marks, [False]]).astype(int)
    return int(np.sum(np.diff(marks) == 1))
