"""Places in pictures to a fraction of a pixel: what gallery tests measure, and where a camera should show it.

Pixels: x right, y down, from the picture's upper left corner; pixel (row, column) covers [column, column + 1] ×
[row, row + 1].
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from . import rays


class Camera:
    """The pinhole camera of DESIGN section 8."""

    def __init__(self, size, origin, target, up, fov):
        self.size, self.origin = np.array(size, float), np.array(origin, float)
        self.forward = np.subtract(target, origin) / np.linalg.norm(np.subtract(target, origin))
        right = np.cross(self.forward, up)
        self.right = right / np.linalg.norm(right)
        self.above = np.cross(self.right, self.forward)
        self.scale = self.size[0] / 2 / np.tan(np.radians(fov) / 2)

    @classmethod
    def of(cls, scene, size):
        """That of a scene, as its file gave it."""
        c = scene.camera
        return cls(size, c.origin, c.target, c.up, c.fov)

    def direction(self, pixel):
        """Unit direction through a place (2,) of the picture."""
        x, y = (np.asarray(pixel, float) - self.size / 2) / self.scale
        d = self.forward + x * self.right - y * self.above
        return d / np.linalg.norm(d)

    def pixel(self, point):
        """Where a point is seen along a straight line."""
        d = np.subtract(point, self.origin)
        d = d / (d @ self.forward)
        return self.size / 2 + self.scale * np.array([d @ self.right, -(d @ self.above)])

    def pixel_along(self, medium, point, plane_normal, near=None):
        """Where a point of a plane is seen along a curved ray, by DOP853 and Newton's steps; `near`: a guess."""
        normal = np.asarray(plane_normal, float)
        axes = np.linalg.svd(normal[None])[2][1:]

        def miss(pixel):
            end = rays.trace(medium, self.origin, self.direction(pixel), until=(point, normal)).position
            return axes @ (end - point)

        at = np.array(self.pixel(point) if near is None else near, float)
        for _ in range(30):
            error = miss(at)
            if np.linalg.norm(error) < 1e-9:
                return at
            slope = np.stack([(miss(at + h) - miss(at - h)) / 0.02 for h in 0.01 * np.eye(2)], axis=1)
            step = np.linalg.solve(slope, error)
            at = at - step * min(1.0, 5.0 / np.linalg.norm(step))
        raise AssertionError(f"no ray to {point} near {near}: {error}")


def corner(values, near, half=5):
    """Where two light and two dark squares meet, near a place, in a picture (H, W): fit of two crossing edges."""
    column, row = (int(np.floor(c)) for c in near)
    window = values[row - half : row + half + 1, column - half : column + half + 1]
    y, x = np.mgrid[-half : half + 1, -half : half + 1] + 0.5
    middle, swing = window.mean(), np.ptp(window) / 2

    def model(p):
        dx, dy = x - p[0], y - p[1]
        edges = [np.tanh((dx * np.cos(a) + dy * np.sin(a)) / p[4]) for a in p[2:4]]
        return p[5] + p[6] * edges[0] * edges[1]

    fits = []
    for turn in np.radians([0, 30, 60]):
        for sign in (1, -1):
            start = [near[0] - column, near[1] - row, turn, turn + np.pi / 2, 0.5, middle, sign * swing]
            fits.append(least_squares(lambda p: (model(p) - window).ravel(), start))
    best = min(fits, key=lambda fit: fit.cost)
    return np.array([column, row]) + best.x[:2]
