"""A ray about one gravity centre, n = 1 + m/d^k, by quadrature: Bouguer's n d sin φ = b is all that is used.

In the plane of the ray, from the distance d₁ to d₂ outward (inward the same, mirrored at the nearest point, where n d = b):

    arc length  ∫ n d/√(n²d² − b²) dd        angle  ∫ b/(d √(n²d² − b²)) dd        optical path  ∫ n² d/√(n²d² − b²) dd

The root's zero at the nearest point d₀ is taken out by d = d₀ + s².
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from .fields import vector
from .rays import Ray


def _integral(f, a, b):
    return quad(f, a, b, epsabs=1e-14, epsrel=1e-13, limit=400)[0]


def ray(strength, power, center, origin, direction, *, length) -> Ray:
    """The end after an arc length; the ray must not fall in, and have a nearest point that lies ahead or behind."""
    center = vector(center)
    r, d = vector(origin) - center, vector(direction) / np.linalg.norm(direction)
    index = lambda x: 1 + strength / x**power  # noqa: E731
    start = np.linalg.norm(r)
    first = r / start
    side = d - (d @ first) * first
    side /= np.linalg.norm(side)
    sine, inward = np.linalg.norm(np.cross(first, d)), d @ first < 0
    b = index(start) * start * sine
    grid = np.linspace(start, 1e-3 * start, 4001)
    below = np.nonzero(index(grid) * grid < b)[0]
    if not len(below):
        raise ValueError("no nearest point: the ray falls in, forward or backward")
    least = brentq(lambda x: index(x) * x - b, grid[below[0]], grid[below[0] - 1], xtol=1e-16, rtol=1e-15)

    def excess(x):
        """(n²d² − b²)/(d − d₀), without cancellation."""
        if x == least:
            return 2 * b * (1 + (1 - power) * strength / x**power)
        gap = x - least
        # n d − n₀ d₀ = gap + m (d^(1−k) − d₀^(1−k))
        rise = gap + strength * least ** (1 - power) * np.expm1((1 - power) * np.log1p(gap / least))
        return rise / gap * (index(x) * x + b)

    def between(weight, near, far):
        """∫ weight(d)/√(n²d² − b²) dd between two distances, by s = √(d − d₀)."""
        f = lambda s: 2 * weight(least + s * s) / np.sqrt(excess(least + s * s))  # noqa: E731
        return _integral(f, np.sqrt(max(near - least, 0.0)), np.sqrt(max(far - least, 0.0)))

    arc, turn, path = (lambda x: index(x) * x), (lambda x: b / x), (lambda x: index(x) ** 2 * x)
    if inward:
        way_in = between(arc, least, start)
        if length <= way_in:
            end = brentq(lambda x: between(arc, x, start) - length, least, start, xtol=1e-16, rtol=1e-15)
            angle, optical, sign = between(turn, end, start), between(path, end, start), -1
        else:
            end = brentq(lambda x: between(arc, least, x) - (length - way_in), least, start + length, xtol=1e-16, rtol=1e-15)
            angle = between(turn, least, start) + between(turn, least, end)
            optical, sign = between(path, least, start) + between(path, least, end), 1
    else:
        end = brentq(lambda x: between(arc, start, x) - length, start, start + length, xtol=1e-16, rtol=1e-15)
        angle, optical, sign = between(turn, start, end), between(path, start, end), 1
    out = np.cos(angle) * first + np.sin(angle) * side
    across = np.cos(angle) * side - np.sin(angle) * first
    n = index(end)
    radial = sign * np.sqrt(max((n * end - b) * (n * end + b), 0.0)) / end
    return Ray(center + end * out, radial * out + b / end * across, length, optical)
