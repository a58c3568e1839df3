"""Spherical layers without our code: heights in long double, ODEs that end at each face, straight segments with Snell.

ρ = |r − centre|, centre = origin − R·up, h = ρ − R taken in 80-bit arithmetic (7e-13 m at R = 6.4e6 m), so that no
formula against cancellation is shared with what is tested.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from .fields import vector

LONG = np.longdouble


def height(r, radius, up=(0, 1, 0), origin=(0, 0, 0)):
    """h (float) and the unit vector away from the centre (3,)."""
    out = np.asarray(r, LONG) - np.asarray(origin, LONG) + LONG(radius) * np.asarray(up, LONG)
    rho = np.sqrt(out @ out)
    return float(rho - LONG(radius)), np.asarray(out / rho, float)


class OfHeight:
    """n = 1 + f(h), `f` returning (N, dN/dh): a field for `oracles.rays.trace`."""

    def __init__(self, refractivity, radius, up=(0, 1, 0), origin=(0, 0, 0), max_step=np.inf):
        self.refractivity, self.frame, self.max_step = refractivity, (radius, up, origin), max_step

    def __call__(self, r):
        h, out = height(r, *self.frame)
        value, slope = self.refractivity(h)
        return (1 + value) ** 2, (1 + value) * slope * out


def linear_squared(heights, n, radius, position, direction, length, up=(0, 1, 0), origin=(0, 0, 0)):
    """Position, momentum and optical path after `length` metres: DOP853 at 1e-13 in each layer, ended at its faces."""
    heights, n2 = np.asarray(heights, float), np.asarray(n, float) ** 2
    rho = radius + heights
    centre = vector(origin) - radius * vector(up)
    slopes = np.concatenate([[0.0], np.diff(n2) / np.diff(rho**2), [0.0]])
    base = np.concatenate([[n2[0]], n2])
    foot = np.concatenate([[rho[0]], rho])
    out = vector(position) - centre
    layer = int(np.searchsorted(rho, np.linalg.norm(out), side="right"))
    square = base[layer] + slopes[layer] * (out @ out - foot[layer] ** 2)
    d = vector(direction) / np.linalg.norm(direction)
    y = np.concatenate([out, np.sqrt(square) * d, [0.0, 0.0]])
    for _ in range(10_000):
        c = slopes[layer]

        def slope(_s, y, c=c, layer=layer):
            square = base[layer] + c * (y[:3] @ y[:3] - foot[layer] ** 2)
            return np.concatenate([y[3:6], c * y[:3], [np.sqrt(square), square]])

        def arrived(_s, y):
            return y[6] - length

        events = [arrived]
        for side, bound in ((-1, layer - 1), (1, layer)):
            if 0 <= bound < len(rho):
                def face(_s, y, at=rho[bound]):
                    return np.linalg.norm(y[:3]) - at

                face.direction = side
                events.append(face)
            else:
                events.append(lambda _s, y: 1.0)
        for event in events:
            event.terminal = True
        run = solve_ivp(slope, (0, 10 * length + 1), y, "DOP853", rtol=1e-13, atol=1e-14, events=events,
                        max_step=length / 20)
        assert run.success and run.status == 1
        y = run.y[:, -1]
        if len(run.t_events[0]):
            return centre + y[:3], y[3:6], y[7]
        layer += 1 if len(run.t_events[2]) else -1
    raise RuntimeError("too many layers")


def step(heights, n, radius, position, direction, length, up=(0, 1, 0), origin=(0, 0, 0)):
    """Straight segments, n[i] from heights[i] to heights[i+1], the ends held; Snell in vectors at each sphere."""
    rho, n = radius + np.asarray(heights, float), np.asarray(n, float)
    index = np.concatenate([[n[0]], n])
    centre = vector(origin) - radius * vector(up)
    q, d = vector(position) - centre, vector(direction) / np.linalg.norm(direction)
    layer, left, optical = int(np.searchsorted(rho, np.linalg.norm(q), side="right")), length, 0.0
    for _ in range(100_000):
        b = q @ d
        best, inward = np.inf, False
        for bound in (layer - 1, layer):
            if not 0 <= bound < len(rho):
                continue
            disc = b * b - (q @ q - rho[bound] ** 2)
            if disc < 0:
                continue
            for t in (-b - np.sqrt(disc), -b + np.sqrt(disc)):
                if 1e-9 < t < best:
                    best, inward = t, bound == layer - 1
        if best >= left:
            return centre + q + left * d, index[layer] * d, optical + index[layer] * left
        q, left, optical = q + best * d, left - best, optical + best * index[layer]
        normal = q / np.linalg.norm(q)
        behind = layer - 1 if inward else layer + 1
        cosine, ratio = d @ normal, index[layer] / index[behind]
        across = ratio * (d - cosine * normal)
        rest = 1 - across @ across
        if rest < 0:
            d = d - 2 * cosine * normal
        else:
            d, layer = across + np.sign(cosine) * np.sqrt(rest) * normal, behind
    raise RuntimeError("too many layers")
