"""Paths about an axis or a centre: fibre, Luneburg lens, fish-eye, Eaton lens (DESIGN section 2).

Each is a curve r(x) of a parameter of its own with p(x), dl/dx and dσ/dx known; arc length and optical path are
Gauss–Legendre sums over panels, the end is a root by brentq, so nothing here is an elliptic integral.

* fibre, Luneburg: y'' = −ω² y in σ, hence y = y₀ cos ωσ + p₀ sin ωσ/ω;
* fish-eye: the circle through r and its image c − (r−c) a²/|r−c|² that leaves r along d;
* Eaton: Kepler's ellipse, n² = 2R/r − 1 = vis-viva with GM = R and semi-major axis R; by Newton on nothing: the
  eccentric anomaly is the parameter.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from .fields import vector
from .rays import Ray

_X, _W = np.polynomial.legendre.leggauss(40)


def integral(f, a, b, panel):
    """∫ f over [a, b] in panels of at most `panel`; f takes an array."""
    if b == a:
        return 0.0
    count = max(1, int(np.ceil(abs(b - a) / panel)))
    edges = np.linspace(a, b, count + 1)
    mid, half = 0.5 * (edges[1:] + edges[:-1])[:, None], 0.5 * np.diff(edges)[:, None]
    return float(np.sum(half * _W * f(mid + half * _X)))


class Curve:
    """r(x), p(x), dl/dx for x ≥ 0 (an array of them), up to x = `end`; panels of `panel` in x."""

    def __init__(self, at, speed, panel, end=np.inf):
        self.at, self.speed, self.panel, self.end = at, speed, panel, end

    def length(self, x):
        return integral(self.speed, 0.0, x, self.panel)

    def optical_path(self, x):
        return integral(lambda t: self.speed(t) * np.linalg.norm(self.at(t)[1], axis=-1), 0.0, x, self.panel)

    def x_of_length(self, length):
        high = self.panel
        while self.length(high) < length:
            high *= 2
        x = brentq(lambda t: self.length(t) - length, 0.0, high, xtol=1e-16 * high, rtol=1e-15)
        return x - (self.length(x) - length) / float(self.speed(np.array([x]))[0])

    def x_of_plane(self, point, normal, step):
        """First crossing after the start, looked for in steps of `step`, or inf."""
        point, normal = vector(point), vector(normal)
        last = min(self.end, 2000 * step)
        xs = np.append(np.arange(step * 1e-6, last, step), last)
        gaps = (self.at(xs)[0] - point) @ normal
        flips = np.nonzero(np.sign(gaps[1:]) != np.sign(gaps[:-1]))[0]
        if not len(flips):
            return np.inf
        i = flips[0]
        gap = lambda x: float((self.at(np.array([x]))[0][0] - point) @ normal)  # noqa: E731
        return brentq(gap, xs[i], xs[i + 1], xtol=1e-16, rtol=1e-15)

    def ray(self, x):
        r, p = self.at(np.array([x]))
        return Ray(r[0], p[0], self.length(x), self.optical_path(x))


def _unit(v):
    return vector(v) / np.linalg.norm(v)


def _oscillation(r0, p0, y0, along, omega):
    """y'' = −ω² y with the part `along` of p0 going straight on."""
    across = p0 - along

    def at(x):
        x = np.asarray(x)[..., None]
        c, s = np.cos(omega * x), np.sin(omega * x)
        r = r0 + y0 * (c - 1) + across * s / omega + along * x
        return r, along + across * c - omega * y0 * s

    return Curve(at, lambda x: np.linalg.norm(at(x)[1], axis=-1), 0.1 / omega)


def parabolic_curve(n, alpha, axis, base, origin, direction):
    axis, r0 = _unit(axis), vector(origin)
    y0 = r0 - vector(base)
    y0 = y0 - (y0 @ axis) * axis
    p0 = n * np.sqrt(1 - alpha**2 * (y0 @ y0)) * _unit(direction)
    return _oscillation(r0, p0, y0, (p0 @ axis) * axis, n * alpha)


def fisheye_curve(n, radius, center, origin, direction):
    center, r0, d = vector(center), vector(origin), _unit(direction)
    y = r0 - center
    index = lambda r: n / (1 + np.sum((r - center) ** 2, axis=-1) / radius**2)  # noqa: E731
    side = y - (y @ d) * d
    if np.linalg.norm(side) < 1e-14 * np.linalg.norm(y) or not np.any(y):
        straight = lambda x: r0 + np.asarray(x)[..., None] * d  # noqa: E731
        return Curve(lambda x: (straight(x), index(straight(x))[..., None] * d), np.ones_like, 0.05 * radius)
    image = -y * radius**2 / (y @ y)
    normal = side / np.linalg.norm(side)  # the circle's centre is y + t normal, as far from the image as from y
    t = (image - y) @ (image - y) / (2 * (image - y) @ normal)
    middle, big = r0 + t * normal, abs(t)

    def at(x):
        angle = np.asarray(x)[..., None] / big
        e = -np.sign(t) * normal
        r = middle + big * (e * np.cos(angle) + d * np.sin(angle))
        return r, index(r)[..., None] * (d * np.cos(angle) - e * np.sin(angle))

    return Curve(at, np.ones_like, 0.05 * min(radius, big))


def luneburg_curve(radius, center, origin, direction):
    """Inside only."""
    r0 = vector(origin)
    y0 = r0 - vector(center)
    p0 = np.sqrt(2 - y0 @ y0 / radius**2) * _unit(direction)
    curve = _oscillation(r0, p0, y0, np.zeros(3), 1 / radius)
    off = lambda x: np.linalg.norm(curve.at(np.array([x]))[0][0] - vector(center)) - radius  # noqa: E731
    curve.end = _first_outside(off, 1e-3 * radius, np.pi * radius)
    return curve


def eaton_curve(radius, center, origin, direction):
    """Inside only; not straight at the centre."""
    center, r0, d = vector(center), vector(origin), _unit(direction)
    y = r0 - center
    r = np.linalg.norm(y)
    p = np.sqrt(2 * radius / r - 1) * d
    momentum = np.cross(y, p)
    e_vector = np.cross(p, momentum) / radius - y / r  # Laplace, Runge, Lenz
    e, q2 = np.linalg.norm(e_vector), momentum @ momentum / radius**2
    along, across = e_vector / e, np.cross(momentum, e_vector)
    across /= np.linalg.norm(across)
    start = np.arctan2(y @ across / np.sqrt(q2), y @ along + radius * e)

    def at(x):
        angle = (start + np.asarray(x))[..., None]
        c, s = np.cos(angle), np.sin(angle)
        position = radius * ((c - e) * along + np.sqrt(q2) * s * across)
        away = radius * (q2 / (1 + e) + 2 * e * np.sin(angle / 2) ** 2)
        return center + position, radius / away * (np.sqrt(q2) * c * across - s * along)

    speed = lambda x: radius * np.sqrt(q2 + (e * np.sin(start + x)) ** 2)  # noqa: E731
    off = lambda x: np.linalg.norm(at(np.array([x]))[0][0] - center) - radius  # noqa: E731
    return Curve(at, speed, 0.02, _first_outside(off, 1e-3, 2 * np.pi))


def _first_outside(off, step, most):
    """Root of `off`, negative inside, after a start that may lie on the sphere."""
    x = step
    if off(1e-9 * step) > 0 and off(step) > 0:
        return 0.0
    while off(x) < 0:
        if x > most:
            return np.inf
        x += step
    return brentq(off, max(x - step, 1e-9 * step), x, xtol=1e-16, rtol=1e-15)


def _follow(curve, length, until, step):
    x = curve.x_of_length(length) if until is None else curve.x_of_plane(*until, step)
    return curve.ray(x)


def parabolic(n, alpha, axis, base, origin, direction, *, length=None, until=None) -> Ray:
    curve = parabolic_curve(n, alpha, axis, base, origin, direction)
    return _follow(curve, length, until, 0.05 / (n * alpha))


def fisheye(n, radius, center, origin, direction, *, length=None, until=None) -> Ray:
    return _follow(fisheye_curve(n, radius, center, origin, direction), length, until, 0.01 * radius)


def _ball(make, radius, center, origin, direction, *, length):
    """Outside, inside, outside."""
    center, r, d = vector(center), vector(origin), _unit(direction)
    arc = optical = 0.0
    for _ in range(3):
        y = r - center
        outside = np.linalg.norm(y) - radius
        if abs(outside) <= 1e-14 * radius:
            outside = y @ d
        if outside >= 0:
            chord2 = radius**2 - np.sum((y - (y @ d) * d) ** 2)
            reach = -(y @ d) - np.sqrt(chord2) if y @ d < 0 and chord2 > 0 else np.inf
            if arc + reach >= length:
                return Ray(r + (length - arc) * d, d, length, optical + length - arc)
            r, arc, optical = r + reach * d, arc + reach, optical + reach
            continue
        curve = make(radius, center, r, d)
        whole = curve.length(curve.end) if np.isfinite(curve.end) else np.inf
        if arc + whole >= length:
            end = curve.ray(curve.x_of_length(length - arc))
            return Ray(end.position, end.momentum, length, optical + end.optical_path)
        end = curve.ray(curve.end)
        r, d, arc, optical = end.position, end.direction, arc + whole, optical + end.optical_path
    raise RuntimeError("still inside")


def luneburg(radius, center, origin, direction, *, length) -> Ray:
    return _ball(luneburg_curve, radius, center, origin, direction, length=length)


def eaton(radius, center, origin, direction, *, length) -> Ray:
    return _ball(eaton_curve, radius, center, origin, direction, length=length)
