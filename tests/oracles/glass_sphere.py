"""Caustic of a glass sphere on a floor by meridional ray optics.

A point source on the axis, `height` above the centre of a sphere (radius R, index n in n = 1);
floor `drop` below the centre.  All rays are meridional, so each path is a fan over the emission
angle θ: external reflection (weight F), or entry, k internal reflections, exit (weight
(1−F)² F^k), with F Fresnel's unpolarised reflectance, equal at every hit of one path.
Power of a ring is I·2π∫w sinθ dθ over the θ that land in it.
"""

from __future__ import annotations

import numpy as np

from .radiometry import fresnel


def _refract(d, m, ratio):
    """Refract unit d at unit normal m with d·m < 0; (N, 2) each."""
    cosine = -np.sum(d * m, axis=1, keepdims=True)
    return ratio * d + (ratio * cosine - np.sqrt(1 - ratio**2 * (1 - cosine**2))) * m


def _chord(x, d):
    """Next point on the unit circle from x along d (pointing inward)."""
    return x - 2 * np.sum(x * d, axis=1, keepdims=True) * d


def floor_radii(n, *, height, radius, drop, samples=200_000, reflections=6):
    """Signed floor radius and power per unit intensity of every path, arrays (M,).

    `samples` emission angles equally spaced in cosθ over the sphere's cone.  The order is the
    external reflection first, then k = 0 … `reflections` (each `samples` long, unless upward).
    """
    limit = np.sqrt(1 - (radius / height) ** 2)
    cosine = limit + (1 - limit) * (np.arange(samples) + 0.5) / samples
    sine = np.sqrt(1 - cosine**2)
    solid_angle = 2 * np.pi * (1 - limit) / samples
    d = np.stack([sine, -cosine], axis=1)  # (ρ, y), units of the sphere's radius
    start = np.array([0.0, height / radius])
    along = -(d @ start)
    x = start + d * (along - np.sqrt(along**2 - start @ start + 1))[:, None]
    weight = fresnel(-np.sum(x * d, axis=1), 1.0, n)
    floor, out = -drop / radius, []

    def land(x, d, power):
        down = d[:, 1] < 0
        t = (floor - x[:, 1]) / np.where(down, d[:, 1], -1.0)
        out.append(np.stack([np.where(down, x[:, 0] + t * d[:, 0], np.inf) * radius, power], axis=1))

    land(x, d - 2 * np.sum(x * d, axis=1, keepdims=True) * x, weight * solid_angle)
    d, power = _refract(d, x, 1 / n), (1 - weight) * solid_angle
    for _ in range(reflections + 1):
        x = _chord(x, d)
        land(x, _refract(d, -x, n), power * (1 - weight))
        d, power = d - 2 * np.sum(x * d, axis=1, keepdims=True) * x, power * weight
    rho, power = np.concatenate(out).T
    keep = np.isfinite(rho)
    return rho[keep], power[keep]


def ring_power(n, edges, **geometry):
    """Power (per unit intensity) of the caustic in each ring between radii `edges` (K+1,): (K,)."""
    rho, power = floor_radii(n, **geometry)
    return np.histogram(np.abs(rho), bins=edges, weights=power)[0]


def paraxial_image(n, *, height, radius):
    """Distance below the centre at which paraxial rays meet: 1/v = 2(n−1)/(nR) − 1/u."""
    return 1 / (2 * (n - 1) / (n * radius) - 1 / height)


def fold_radius(n, *, height, radius, drop, samples=200_000):
    """Radius of the bright ring: where ρ(θ) of the twice-refracted rays turns (dρ/dθ = 0)."""
    rho = floor_radii(n, height=height, radius=radius, drop=drop, samples=samples, reflections=0)[0][-samples:]
    rising = np.diff(rho[::-1])  # from the axis outward
    turn = int(np.argmax(rising < 0))
    return float(rho[::-1][turn])
