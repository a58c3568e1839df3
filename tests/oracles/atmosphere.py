"""Refraction by means that share nothing with the library's.

The atmosphere is Hohenkerk and Sinclair's as the Explanatory Supplement to the Astronomical Almanac (1992), section
3.281, gives it; the integral is over the zenith distance ψ along the ray (Auer and Standish), whose height is found by
a root finder; `bend` follows any n(r) by an ODE in arc length, through turning points.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

ARC_SECOND = np.degrees(1) * 3600

#: PAL `refro`: sea level, 288.15 K, 1013.25 hPa, dry, 6.5 K/km, latitude 45°, 0.574 µm; degrees to arc seconds.
PAL = {45: 57.08, 75: 209.93, 80: 312.90, 85: 579.05, 87: 841.84, 88: 1065.58, 89: 1410.34, 89.5: 1656.20, 90: 1976.62}
#: The same at the horizon by wavelength: µm to arc minutes.
PAL_HORIZON = {0.45: 33.348, 0.50: 33.147, 0.55: 33.000, 0.65: 32.805, 0.70: 32.737}
#: PAL with 80 % humidity at 90°, arc seconds.
PAL_HUMID = 1963.30


class HohenkerkSinclair:
    """n and dn/dr of the two-layer atmosphere; hectopascal and kelvin as in the source."""

    radius, tropopause, top = 6378120.0, 11000.0, 80000.0

    def __init__(self, height=0.0, t0=288.15, p0=1013.25, humidity=0.0, um=0.574, latitude=45.0, lapse=0.0065):
        gas, dry, wet, delta = 8314.32, 28.9644, 18.0152, 18.36
        self.t0, self.height, self.lapse, self.delta = t0, height, lapse, delta
        gravity = 9.784 * (1 - 0.0026 * np.cos(2 * np.radians(latitude)) - 0.00000028 * height)
        a = (287.6155 + 1.62887 / um**2 + 0.01360 / um**4) * 273.15e-6 / 1013.25
        self.scale = gravity * dry / gas
        self.gamma = self.scale / lapse
        c = t0 - 273.15
        saturated = 10 ** ((0.7859 + 0.03477 * c) / (1 + 0.00412 * c)) * (1 + p0 * (4.5e-6 + 6e-10 * c * c))
        vapour = humidity * saturated / (1 - (1 - humidity) * saturated / p0)
        w = vapour * (1 - wet / dry) * self.gamma / (delta - self.gamma)
        self.c1, self.c2 = a * (p0 + w) / t0, (a * w + 11.2684e-6 * vapour) / t0
        self.nt = self._low(self.tropopause)[0]
        self.tt = t0 - lapse * (self.tropopause - height)

    def _low(self, h):
        t = (self.t0 - self.lapse * (h - self.height)) / self.t0
        n1 = self.c1 * t ** (self.gamma - 1) - self.c2 * t ** (self.delta - 1)
        slope = self.c1 * (self.gamma - 1) * t ** (self.gamma - 2) - self.c2 * (self.delta - 1) * t ** (self.delta - 2)
        return n1, -slope * self.lapse / self.t0

    def index(self, h):
        """n − 1 and its slope, 1/m."""
        if h <= self.tropopause:
            return self._low(h)
        n1 = self.nt * np.exp(-self.scale / self.tt * (h - self.tropopause))
        return n1, -self.scale / self.tt * n1

    def refraction(self, zenith):
        """Arc seconds, zenith ≤ 90°."""
        k = (1 + self.index(self.height)[0]) * (self.radius + self.height) * np.sin(np.radians(zenith))

        def height_at(psi, low, high):
            def surplus(h):
                return (1 + self.index(h)[0]) * (self.radius + h) * np.sin(psi) - k

            if surplus(low) >= 0:
                return low
            return high if surplus(high) <= 0 else brentq(surplus, low, high, xtol=1e-7, rtol=1e-15)

        def integrand(psi, low, high):
            h = height_at(psi, low, high)
            n1, slope = self.index(h)
            r = self.radius + h
            return -r * slope / (1 + n1 + r * slope)

        total, edges = 0.0, [self.height, self.tropopause, self.top]
        hair = 1e-6  # metres: the slope jumps at the tropopause
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            psi = [np.arcsin(min(1.0, k / ((1 + self.index(h)[0]) * (self.radius + h)))) for h in (low, high)]
            inside = low + (hair if low == self.tropopause else 0), high
            total += quad(integrand, psi[1], psi[0], args=inside, epsabs=1e-13, epsrel=1e-12, limit=400)[0]
        return total * ARC_SECOND


def bend(index, start, zenith, top, rtol=1e-12):
    """Refraction (radians) of the ray from radius `start` until it passes radius `top`, or None if it never does.

    index(r) gives (n − 1, dn/dr). dr = cos ψ dl, dψ = −sin ψ (1/r + n'/n) dl, dR = −(n'/n) sin ψ dl.
    """

    def slope(_, y):
        r, psi, _ = y
        n1, dn = index(r)
        bent = dn / (1 + n1)
        return np.cos(psi), -np.sin(psi) * (1 / r + bent), -bent * np.sin(psi)

    def out(_, y):
        return y[0] - top

    out.terminal, out.direction = True, 1
    found = solve_ivp(
        slope,
        (0, 4e6),
        [start, np.radians(zenith), 0.0],
        method="DOP853",
        rtol=rtol,
        atol=[1e6 * rtol, 1e-2 * rtol, 1e-2 * rtol],
        events=out,
        max_step=2e4,
    )
    return found.y[2, -1] if found.t_events[0].size else None
