"""The primary bow of a ball on a screen between lamp and ball, by meridional rays: all on one axis, z, in a field that
varies along it alone.

Lamp at z = `lamp`, ball of radius R about the origin, screen at z = `screen`: a ray enters, is reflected once
inside, leaves and lands at ρ. Outside, any field of `fields` (curves by SciPy's DOP853); inside, straight; Snell with
the local n of both sides. The bow is where ρ, as a function of where the ray leaves the lamp, has its maximum.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from .prisms import refract


def curve(field, start, direction, stop):
    """Position and direction where `stop`(position) first crosses 0, in three dimensions."""

    def slope(_sigma, y):
        return np.concatenate([y[3:], field(y[:3])[1]])

    def event(_sigma, y):
        return stop(y[:3])

    event.terminal = True
    n = np.sqrt(field(start)[0])
    first = np.concatenate([start, n * direction / np.linalg.norm(direction)])
    nudge = 1e-9  # off a surface that it starts on
    first[:3] += nudge * direction / np.linalg.norm(direction)
    # Short steps: none over the ball.
    s = solve_ivp(slope, (0, 20), first, "DOP853", rtol=1e-12, atol=1e-14, events=event, max_step=0.03)
    if not len(s.t_events[0]):
        return None
    y = s.y_events[0][0]
    for _ in range(3):  # the event is found on the dense output, of lower order: on along the tangent to the surface
        h = 1e-7 * y[3:] / np.linalg.norm(y[3:])
        gap = stop(y[:3])
        y[:3] = y[:3] - y[3:] * gap / ((stop(y[:3] + h) - gap) / 1e-7 * np.linalg.norm(y[3:]))
    return y[:3], y[3:] / np.linalg.norm(y[3:])


def landing(field, glass, angle, *, radius, lamp, screen):
    """ρ on the screen of the ray that leaves the lamp at `angle` (rad) from the axis; None if it misses the ball."""
    met = curve(field, np.array([0.0, 0.0, lamp]), np.array([np.sin(angle), 0.0, -np.cos(angle)]),
                lambda r: np.linalg.norm(r) - radius)  # fmt: skip
    if met is None:
        return None
    at, d = met
    d = refract(d, at / radius, np.sqrt(field(at)[0]), glass)
    for leg in range(2):
        at = at - 2 * (at @ d) * d
        at = at * radius / np.linalg.norm(at)
        if leg == 0:
            d = d - 2 * (d @ at) * at / radius**2
    d = refract(d, at / radius, glass, np.sqrt(field(at)[0]))
    end = curve(field, at, d, lambda r: r[2] - screen)
    return None if end is None else end[0][0]


def rim(field, glass, cone, **geometry):
    """ρ of the bow: the largest, for rays within 0.6 to 0.97 of the `cone` (rad) that holds the ball; to 1e-6 m."""
    best = minimize_scalar(lambda a: -abs(landing(field, glass, a, **geometry) or 0.0),
                           bounds=(0.6 * cone, 0.97 * cone), method="bounded", options={"xatol": 1e-6})  # fmt: skip
    return -best.fun
