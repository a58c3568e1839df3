"""Refractive-index fields as Python callables.

A field is called with one point `r` (3,) in metres and returns ``(n_squared, half_gradient)``:
n² (float) and ½∇(n²) (3,), the right-hand side of the ray equation of DESIGN section 1,

    dr/dσ = p,   dp/dσ = ½∇(n²),   |p| = n.

A field also has `max_step`, a bound on the oracle's step in metres where its derivatives
jump (infinite where it is analytic).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


def vector(values) -> np.ndarray:
    """(3,) float64."""
    return np.asarray(values, dtype=np.float64).reshape(3)


@dataclass(frozen=True)
class Homogeneous:
    """n constant."""

    n: float
    max_step: float = np.inf

    def __call__(self, r):
        return self.n**2, np.zeros(3)


@dataclass(frozen=True)
class LinearSquared:
    """n² = n_squared + g·(r − origin), g in 1/m."""

    n_squared: float
    gradient: tuple
    origin: tuple = (0.0, 0.0, 0.0)
    max_step: float = np.inf

    def __call__(self, r):
        g = vector(self.gradient)
        return self.n_squared + g @ (r - vector(self.origin)), 0.5 * g


@dataclass(frozen=True)
class Linear:
    """n = n + g·(r − origin); ½∇(n²) = n g."""

    n: float
    gradient: tuple
    origin: tuple = (0.0, 0.0, 0.0)
    max_step: float = np.inf

    def __call__(self, r):
        g = vector(self.gradient)
        n = self.n + g @ (r - vector(self.origin))
        return n * n, n * g


@dataclass(frozen=True)
class OfHeight:
    """n = f(h), h = up·(r − origin); `f` returns (n, dn/dh)."""

    profile: object
    up: tuple = (0.0, 1.0, 0.0)
    origin: tuple = (0.0, 0.0, 0.0)
    max_step: float = np.inf

    def __call__(self, r):
        up = vector(self.up)
        n, slope = self.profile(up @ (r - vector(self.origin)))
        return n * n, n * slope * up


@dataclass(frozen=True)
class Parabolic:
    """n² = n²(1 − α²ρ²), ρ the distance from the axis through `origin`."""

    n: float
    alpha: float
    axis: tuple = (0.0, 0.0, 1.0)
    origin: tuple = (0.0, 0.0, 0.0)
    max_step: float = np.inf

    def __call__(self, r):
        axis = vector(self.axis) / np.linalg.norm(self.axis)
        y = r - vector(self.origin)
        y = y - (y @ axis) * axis
        return self.n**2 * (1 - self.alpha**2 * (y @ y)), -((self.n * self.alpha) ** 2) * y


@dataclass(frozen=True)
class OfRadius:
    """n² = f(r), r = |r − center|; `f` returns (n², dn²/dr)."""

    profile: object
    center: tuple = (0.0, 0.0, 0.0)
    max_step: float = np.inf

    def __call__(self, r):
        y = r - vector(self.center)
        distance = np.linalg.norm(y)
        square, slope = self.profile(distance)
        return square, 0.5 * slope * y / distance if distance > 0 else np.zeros(3)


def luneburg(radius, center=(0.0, 0.0, 0.0), **options):
    """n² = 2 − r²/R² inside, 1 outside."""
    inside = lambda r: (2 - (r / radius) ** 2, -2 * r / radius**2)  # noqa: E731
    return OfRadius(lambda r: inside(r) if r < radius else (1.0, 0.0), center, **options)


def fisheye(n, radius, center=(0.0, 0.0, 0.0), **options):
    """n = n₀/(1 + r²/a²)."""

    def profile(r):
        w = 1 + (r / radius) ** 2
        return (n / w) ** 2, -4 * n**2 * r / radius**2 / w**3

    return OfRadius(profile, center, **options)


def eaton(radius, center=(0.0, 0.0, 0.0), **options):
    """n² = 2R/r − 1 inside, 1 outside."""
    inside = lambda r: (2 * radius / r - 1, -2 * radius / r**2)  # noqa: E731
    return OfRadius(lambda r: inside(r) if r < radius else (1.0, 0.0), center, **options)


@dataclass(frozen=True)
class Sources:
    """n = 1 + Σ m/d^k; `directions` (K, 3) of lines, zero for points."""

    centers: tuple
    strengths: tuple
    exponents: tuple
    directions: tuple
    max_step: float = np.inf

    def __call__(self, r):
        n, gradient = 1.0, np.zeros(3)
        for c, m, k, d in zip(self.centers, self.strengths, self.exponents, self.directions, strict=True):
            y, d = r - vector(c), vector(d)
            if np.any(d):
                y = y - (y @ d) * d / (d @ d)
            distance = np.linalg.norm(y)
            n += m / distance**k
            gradient = gradient - k * m * y / distance ** (k + 2)
        return n * n, n * gradient


@dataclass(frozen=True)
class OfIndex:
    """n = f(r) for any smooth `f` returning (n, ∇n)."""

    index: object
    max_step: float = np.inf

    def __call__(self, r):
        n, gradient = self.index(r)
        return n * n, n * np.asarray(gradient)


def numerical_half_gradient(medium, r, step=1e-5):
    """½∇(n²) by central differences of the field's own n²; checks the gradients above."""
    r = vector(r)
    gradient = np.empty(3)
    for axis in range(3):
        d = np.zeros(3)
        d[axis] = step
        gradient[axis] = (medium(r + d)[0] - medium(r - d)[0]) / (4 * step)
    return gradient
