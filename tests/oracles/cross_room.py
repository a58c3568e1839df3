"""The cross room of DESIGN section 12, and its direct light in closed form.

n² = n0² + slope·y (1.69 − 0.10 y curved; slope 0 and n0 = 1 straight).  From the spot S a photon
follows r = S + p₀σ + gσ²/4 with |p₀| = n_S.  A point r is reached where

    Δx² + Δz² + (Δy − slope σ²/4)² = n_S² σ²,          Δ = r − S,

a quadratic in u = σ²; its smaller root is the direct path, the larger the lofted one (which no
photon of the spot's cone takes).  Photon power is constant along the ray, so on a horizontal
floor E = I dΩ/dA with dΩ/dA = |∂d/∂x × ∂d/∂z|, d = p₀/n_S, ∂σ from the quadratic.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

SPOT = np.array([-5.0, 6.5, 0.0])
TARGET = np.array([-2.0, 2.35, 0.0])
HALF_ANGLE = np.radians(14.0)
INTENSITY = 100.0
WALL = -2.0
#: Upright and bar of the cross on the wall x = −2: (z low, z high, y low, y high).
UPRIGHT, BAR = (-0.3, 0.3, 0.8, 3.2), (-1.2, 1.2, 1.7, 2.3)
#: The wall beside the cross: (y0, y1, z0, z1).
PANELS = [
    (0, 0.8, -2, 2), (3.2, 4, -2, 2), (0.8, 1.7, -2, -0.3), (0.8, 1.7, 0.3, 2),
    (2.3, 3.2, -2, -0.3), (2.3, 3.2, 0.3, 2), (1.7, 2.3, -2, -1.2), (1.7, 2.3, 1.2, 2),
]  # fmt: skip
#: Corners of the cross, counter-clockwise, as (z, y).
OUTLINE = [
    (-0.3, 0.8), (0.3, 0.8), (0.3, 1.7), (1.2, 1.7), (1.2, 2.3), (0.3, 2.3),
    (0.3, 3.2), (-0.3, 3.2), (-0.3, 2.3), (-1.2, 2.3), (-1.2, 1.7), (-0.3, 1.7),
]  # fmt: skip


def quads():
    """Walls as (corner, edge a, edge b, paint); normals a × b point into the room."""
    walls = [
        ((-2, 0, -2), (0, 0, 4), (4, 0, 0), "white"),
        ((-2, 4, -2), (4, 0, 0), (0, 0, 4), "white"),
        ((2, 0, -2), (0, 0, 4), (0, 4, 0), "white"),
        ((-2, 0, -2), (4, 0, 0), (0, 4, 0), "red"),
        ((-2, 0, 2), (0, 4, 0), (4, 0, 0), "green"),
    ]
    for y0, y1, z0, z1 in PANELS:
        walls.append(((-2, y0, z0), (0, y1 - y0, 0), (0, 0, z1 - z0), "white"))
    return walls


def mesh(paints=("white", "red", "green")):
    """Vertices (V, 3) and faces (F, 3) of the walls of those paints."""
    vertices, faces = [], []
    for corner, a, b, paint in quads():
        if paint in paints:
            corner, a, b = (np.array(v, float) for v in (corner, a, b))
            k = len(vertices)
            vertices += [corner, corner + a, corner + a + b, corner + b]
            faces += [[k, k + 1, k + 2], [k, k + 2, k + 3]]
    return np.array(vertices), np.array(faces, dtype=np.int64)


def through_cross(z, y):
    """Whether (z, y) on the left wall lies in the hole."""
    z, y = np.asarray(z), np.asarray(y)
    upright = (z > UPRIGHT[0]) & (z < UPRIGHT[1]) & (y > UPRIGHT[2]) & (y < UPRIGHT[3])
    return upright | ((z > BAR[0]) & (z < BAR[1]) & (y > BAR[2]) & (y < BAR[3]))


@dataclass(frozen=True)
class Room:
    """Direct light in the room filled with n² = n_squared + slope·y."""

    n_squared: float
    slope: float

    @property
    def n_spot(self):
        """Index at the spot."""
        return np.sqrt(self.n_squared + self.slope * SPOT[1])

    def _quadratic(self, offset):
        """a u² + b u + c = 0 for u = σ²."""
        a = self.slope**2 / 16
        b = -(self.n_spot**2 + 0.5 * self.slope * offset[..., 1])
        return a, b, np.sum(offset**2, axis=-1)

    def sigma_to(self, points):
        """σ (N,) of the direct path from the spot to `points` (N, 3)."""
        a, b, c = self._quadratic(np.asarray(points, float) - SPOT)
        return np.sqrt(2 * c / (-b + np.sqrt(b * b - 4 * a * c)))

    def momentum_to(self, points):
        """p₀ (N, 3) at the spot of the path to `points`."""
        offset, sigma = np.asarray(points, float) - SPOT, self.sigma_to(points)
        p = offset / sigma[..., None]
        p[..., 1] -= self.slope * sigma / 4
        return p

    def in_cone(self, points):
        """Whether the spot emits towards `points` (N, 3)."""
        axis = (TARGET - SPOT) / np.linalg.norm(TARGET - SPOT)
        return self.momentum_to(points) @ axis / self.n_spot > np.cos(HALF_ANGLE)

    def on_wall(self, points):
        """(z, y) at which the path to `points` (N, 3) crosses the plane of the left wall."""
        p = self.momentum_to(points)
        sigma = (WALL - SPOT[0]) / p[..., 0]
        return SPOT[2] + p[..., 2] * sigma, SPOT[1] + p[..., 1] * sigma + self.slope * sigma**2 / 4

    def lit(self, x, z):
        """Whether floor points (x, z) see the spot through the cross."""
        points = floor_points(x, z)
        return self.in_cone(points) & through_cross(*self.on_wall(points))

    def solid_angle_density(self, x, z):
        """dΩ/dA (1/m²) of the map floor (x, z) → direction at the spot."""
        points = floor_points(x, z)
        offset, sigma = points - SPOT, self.sigma_to(points)
        a, b, _ = self._quadratic(offset)
        derivative = (2 * a * sigma**2 + b) * 2 * sigma  # ∂(quadratic)/∂σ
        tangents = []
        for axis in (0, 2):
            d_sigma = -2 * offset[..., axis] / derivative
            d = -offset / sigma[..., None] ** 2 * d_sigma[..., None]
            d[..., axis] += 1 / sigma
            d[..., 1] -= self.slope / 4 * d_sigma
            tangents.append(d / self.n_spot)
        return np.linalg.norm(np.cross(*tangents), axis=-1)

    def irradiance(self, x, z):
        """Direct irradiance (W/m²/nm) on the floor at (x, z), black walls."""
        return np.where(self.lit(x, z), INTENSITY * self.solid_angle_density(x, z), 0.0)

    def floor_of_direction(self, directions):
        """Floor (x, z) that unit directions (N, 3) at the spot reach, walls ignored."""
        p = self.n_spot * np.asarray(directions, float)
        a, b, c = self.slope / 4, p[..., 1], SPOT[1]
        sigma = 2 * c / (-b + np.sqrt(b * b - 4 * a * c))
        return SPOT[0] + p[..., 0] * sigma, SPOT[2] + p[..., 2] * sigma

    def outline(self, per_edge=64):
        """Floor polylines of the lit figure's edges: the hole's rim, then the cone's rim; each (M, 2)."""
        corners = np.array(OUTLINE + OUTLINE[:1])
        t = np.linspace(0, 1, per_edge, endpoint=False)[:, None]
        rim = np.concatenate([a + t * (b - a) for a, b in itertools.pairwise(corners)] + [corners[:1]])
        points = np.stack([np.full(len(rim), WALL), rim[:, 1], rim[:, 0]], axis=1)
        hole = np.stack(self.floor_of_direction(self.momentum_to(points) / self.n_spot), axis=1)
        axis = (TARGET - SPOT) / np.linalg.norm(TARGET - SPOT)
        side = np.array([0.0, 0.0, 1.0])
        third = np.cross(axis, side)
        phi = np.linspace(0, 2 * np.pi, 721)[:, None]
        ring = np.cos(HALF_ANGLE) * axis + np.sin(HALF_ANGLE) * (np.cos(phi) * side + np.sin(phi) * third)
        return hole, np.stack(self.floor_of_direction(ring), axis=1)

    def distance_to_edge(self, x, z):
        """Distance (N,) in metres from floor points to the nearest edge of the lit figure."""
        edges = np.concatenate(self.outline(256))
        at = np.stack([np.asarray(x), np.asarray(z)], axis=-1)
        return np.min(np.linalg.norm(at[:, None] - edges[None], axis=-1), axis=1)

    def lit_points(self, spacing, margin):
        """A regular grid of floor points (N, 2), lit and at least `margin` from every edge and wall."""
        axis = np.arange(-2 + spacing / 2, 2, spacing)
        x, z = (v.ravel() for v in np.meshgrid(axis, axis, indexing="ij"))
        inside = (np.abs(x) < 2 - margin) & (np.abs(z) < 2 - margin)
        keep = inside & self.lit(x, z) & (self.distance_to_edge(x, z) > margin)
        return np.stack([x[keep], z[keep]], axis=1)

    def floor_power(self, cells=2000):
        """Direct power (W/nm) on the floor, midpoint rule."""
        h = 4 / cells
        axis = -2 + h * (np.arange(cells) + 0.5)
        x, z = np.meshgrid(axis, axis, indexing="ij")
        return float(np.sum(self.irradiance(x.ravel(), z.ravel())) * h * h)


def floor_points(x, z):
    """(N, 3) points with y = 0."""
    x, z = np.broadcast_arrays(np.asarray(x, float), np.asarray(z, float))
    return np.stack([x, np.zeros_like(x), z], axis=-1)


STRAIGHT, CURVED = Room(1.0, 0.0), Room(1.69, -0.10)
