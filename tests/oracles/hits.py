"""First hits of parabolas (r₀ + p₀σ + gσ²/4) on triangles and spheres, by the roots of their polynomials."""

from __future__ import annotations

import numpy as np

from .closed_forms import parabola, smallest_positive_root


def triangle(r0, p0, g, a, b, c, after=0.0):
    """σ of the first crossing inside triangle abc after `after`, or inf; both sides count."""
    normal = np.cross(b - a, c - a)
    sigma = smallest_positive_root(normal @ g / 4, normal @ p0, normal @ (r0 - a), after)
    while np.isfinite(sigma):
        point, _ = parabola(r0, p0, g, sigma)
        inside = [np.cross(v - u, point - u) @ normal >= 0 for u, v in ((a, b), (b, c), (c, a))]
        if all(inside):
            return sigma
        sigma = smallest_positive_root(normal @ g / 4, normal @ p0, normal @ (r0 - a), sigma * (1 + 1e-12))
    return np.inf


def mesh(r0, p0, g, vertices, faces, after=0.0):
    """(σ, index of the face) of the first triangle hit, or (inf, −1); vertices (V, 3), faces (F, 3)."""
    found = [triangle(r0, p0, g, *vertices[list(f)], after=after) for f in faces]
    best = int(np.argmin(found))
    return (found[best], best) if np.isfinite(found[best]) else (np.inf, -1)


def sphere(r0, p0, g, center, radius, after=1e-9):
    """σ of the first crossing of the sphere: smallest real root above `after` of the quartic |r(σ) − c|² = R²."""
    d = r0 - center
    quartic = [g @ g / 16, p0 @ g / 2, p0 @ p0 + d @ g / 2, 2 * d @ p0, d @ d - radius**2]
    roots = np.roots(np.trim_zeros(quartic, "f"))
    real = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
    real = real[real > after]
    if not len(real):
        return np.inf
    sigma = real[0]
    for _ in range(3):  # polish
        value, slope = np.polyval(quartic, sigma), np.polyval(np.polyder(quartic), sigma)
        sigma -= value / slope if slope else 0.0
    return float(sigma)
