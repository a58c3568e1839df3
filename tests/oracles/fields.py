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
