"""Closed forms of the exact paths of DESIGN section 2.

Notation: p optical momentum, g the gradient, s = p·ĝ its part along ĝ, q = |p − s ĝ| the rest,
which is conserved.  Both the parabola (LinearSquared, over σ) and the catenary (Linear, over l)
need, between s₀ and s₁ = s₀ + Δs with e = √(q² + s²),

    ∫ ds/e   = asinh(s₁/q) − asinh(s₀/q)
    ∫ s ds/e = e₁ − e₀                       = Δs (s₁+s₀)/(e₁+e₀)
    ∫ e ds   = ½[s₁e₁ − s₀e₀ + q²∫ds/e]

each written so that nothing cancels when Δs is small (measured in `test_oracles`).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from .fields import vector
from .rays import Ray


def _asinh_difference(s0, s1, ds, q):
    """asinh(s₁/q) − asinh(s₀/q), by asinh of one quotient when both have one sign."""
    e0, e1 = np.hypot(q, s0), np.hypot(q, s1)
    if s0 * s1 > 0.0:
        return np.arcsinh(ds * (s1 + s0) / (s1 * e0 + s0 * e1))
    return np.arcsinh(s1 / q) - np.arcsinh(s0 / q) if q > 0.0 else np.inf


def _integral_of_e(s0, s1, ds, q):
    """∫ √(q² + s²) ds."""
    e0, e1 = np.hypot(q, s0), np.hypot(q, s1)
    area = 0.5 * (ds * e1 + s0 * ds * (s1 + s0) / (e1 + e0)) if e1 + e0 > 0 else 0.0
    return area + (0.5 * q * q * _asinh_difference(s0, s1, ds, q) if q > 0.0 else 0.0)


def _split(p, g):
    """|g|, ĝ, s, q, and the unit vector of the conserved part of p."""
    size = np.linalg.norm(g)
    unit = g / size
    s = p @ unit
    rest = p - s * unit
    rest -= (rest @ unit) * unit
    q = np.linalg.norm(rest)
    return size, unit, s, q, rest / q if q > 0 else np.zeros(3)


# --- straight -------------------------------------------------------------------------------


def homogeneous(n, origin, direction, *, length=None, until=None) -> Ray:
    """Straight: position r₀ + d l, optical path n l."""
    origin, d = vector(origin), vector(direction)
    d = d / np.linalg.norm(d)
    if until is not None:
        point, normal = vector(until[0]), vector(until[1])
        length = normal @ (point - origin) / (normal @ d)
    return Ray(origin + d * length, n * d, length, n * length, length / n)


# --- n² linear: a parabola in σ ---------------------------------------------------------------


def parabola(r0, p0, g, sigma):
    """Position and momentum at σ: r₀ + p₀σ + gσ²/4, p₀ + gσ/2."""
    return r0 + p0 * sigma + g * (sigma * sigma / 4), p0 + g * (sigma / 2)


def parabola_arc_length(p0, g, sigma):
    """l(σ) = ∫|p| dσ with ds = |g|/2 dσ."""
    size = np.linalg.norm(g)
    if size == 0.0:
        return np.linalg.norm(p0) * sigma
    size, _, s, q, _ = _split(p0, g)
    ds = 0.5 * size * sigma
    return _integral_of_e(s, s + ds, ds, q) * 2.0 / size


def parabola_optical_path(p0, g, sigma):
    """L(σ) = ∫|p|² dσ = |p₀|²σ + (p₀·g)σ²/2 + |g|²σ³/12."""
    return (p0 @ p0) * sigma + (p0 @ g) * sigma**2 / 2 + (g @ g) * sigma**3 / 12


def parabola_sigma_of_length(p0, g, length):
    """Invert l(σ): l is monotone, so bracket, then Newton with dl/dσ = |p|."""
    if length == 0.0:
        return 0.0
    high = length / np.linalg.norm(p0)
    while parabola_arc_length(p0, g, high) < length:
        high *= 2.0
    sigma = brentq(lambda s: parabola_arc_length(p0, g, s) - length, 0.0, high, xtol=1e-15 * high, rtol=1e-15)
    n = np.linalg.norm(parabola(np.zeros(3), p0, g, sigma)[1])
    return sigma - (parabola_arc_length(p0, g, sigma) - length) / n if n > 1e-3 else sigma


def smallest_positive_root(a, b, c, after=0.0):
    """Smallest root of a x² + b x + c above `after`, or inf; without cancellation."""
    if a == 0.0:
        roots = [-c / b] if b else []
    else:
        disc = b * b - 4 * a * c
        if disc < 0:
            return np.inf
        t = -0.5 * (b + np.copysign(np.sqrt(disc), b))
        roots = [t / a] + ([c / t] if t else [])
    return min((x for x in roots if x > after), default=np.inf)


def parabola_sigma_of_plane(r0, p0, g, point, normal, after=0.0):
    """σ of the first crossing of a plane after the start, or inf."""
    return smallest_positive_root(normal @ g / 4, normal @ p0, normal @ (r0 - point), after)


def linear_squared(n_squared, gradient, medium_origin, origin, direction, *, length=None, until=None) -> Ray:
    """`LinearSquared`: the parabola, by arc length or to a plane."""
    g, r0, d = vector(gradient), vector(origin), vector(direction)
    n0 = np.sqrt(n_squared + g @ (r0 - vector(medium_origin)))
    p0 = n0 * d / np.linalg.norm(d)
    if until is None:
        sigma = parabola_sigma_of_length(p0, g, length)
    else:
        sigma = parabola_sigma_of_plane(r0, p0, g, vector(until[0]), vector(until[1]))
    r, p = parabola(r0, p0, g, sigma)
    return Ray(r, p, parabola_arc_length(p0, g, sigma), parabola_optical_path(p0, g, sigma), sigma)


# --- n linear: a catenary, explicit in arc length ---------------------------------------------


def linear(n, gradient, medium_origin, origin, direction, *, length=None, until=None, reach=1e3) -> Ray:
    """`Linear`: p(l) = p₀ + g l, r = r₀ + ∫ p/|p| dl."""
    g, r0, d = vector(gradient), vector(origin), vector(direction)
    p0 = (n + g @ (r0 - vector(medium_origin))) * d / np.linalg.norm(d)
    size, unit, s, q, across = _split(p0, g)

    def at(arc):
        ds = size * arc
        e0, e1 = np.hypot(q, s), np.hypot(q, s + ds)
        along = arc * (2 * s + ds) / (e1 + e0)
        sideways = q * _asinh_difference(s, s + ds, ds, q) / size if q > 0 else 0.0
        return r0 + unit * along + across * sideways

    if until is not None:
        point, normal = vector(until[0]), vector(until[1])
        grid = np.linspace(0.0, reach, 20001)[1:]
        gap = np.array([normal @ (at(a) - point) for a in grid])
        flip = np.nonzero(np.sign(gap) != np.sign(gap[0]))[0]
        length = brentq(lambda a: normal @ (at(a) - point), grid[flip[0] - 1], grid[flip[0]], xtol=1e-15, rtol=1e-15)
    ds = size * length
    optical = _integral_of_e(s, s + ds, ds, q) / size
    return Ray(at(length), p0 + g * length, length, optical)
