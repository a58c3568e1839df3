"""A plane through a scene: its axes, the walls that it cuts, the index on it, a fan of rays from a light."""
from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import FloatArray
from .bounds import Box, Sphere
from .lights import Area, Environment, Spot, Sun
from .scene import Scene
from .shapes import extent_of

__all__ = ["Section", "light_source"]


class Section:
    """A plane with axes ``across`` and ``up``."""

    def __init__(self, origin: FloatArray, across: FloatArray, up: FloatArray) -> None:
        self.origin, self.across, self.up = origin, across, up
        self.normal = np.cross(across, up)

    @classmethod
    def through(cls, scene: Scene, light: Any) -> Section:
        """Through the light and its target (or the scene's middle), upright."""
        origin, target = light_source(light)
        if target is None:
            target = 0.5 * np.add(*extent_of(scene.shapes))
        up = np.array(scene.camera.up if scene.camera is not None else (0.0, 1.0, 0.0), dtype=float)
        up /= np.linalg.norm(up)
        along = np.subtract(target, origin)
        across: FloatArray = along - (along @ up) * up
        if np.linalg.norm(across) < 1e-9 * max(float(np.linalg.norm(along)), 1e-300):  # straight down
            axis = np.eye(3)[int(np.argmin(np.abs(up)))]
            across = axis - (axis @ up) * up
        return cls(origin, across / np.linalg.norm(across), up)

    def flat(self, points: FloatArray) -> FloatArray:
        """(…, 3) to (…, 2), metres in the plane (its own origin has the world's coordinates along the axes)."""
        return np.stack([points @ self.across, points @ self.up], axis=-1)

    def fan(self, scene: Scene, light: Any, count: int) -> tuple[FloatArray, FloatArray]:
        """Origin and directions in the plane: over a spot's cone, over what a point can reach."""
        origin, target = light_source(light)
        if target is not None:
            middle, half = target - origin, np.radians(light.cutoff) if isinstance(light, Spot) else 0.5 * np.pi
        else:
            middle, half = self._towards(scene, origin)
        angle = np.arctan2(middle @ self.up, middle @ self.across)
        # Middles of equal parts: no ray along the very edge of the cone, none twice at ±180°.
        angles = angle + half * ((2.0 * np.arange(count) + 1.0) / count - 1.0)
        directions = np.cos(angles)[:, None] * self.across + np.sin(angles)[:, None] * self.up
        return np.broadcast_to(origin, directions.shape), directions

    def _towards(self, scene: Scene, origin: FloatArray) -> tuple[FloatArray, float]:
        """Middle and half-width of the angles in which the scene is seen: the circle less its widest empty part."""
        seen = self.edges(scene).reshape(-1, 2) - self.flat(origin)
        if not len(seen):
            return -self.up, np.pi
        angles = np.sort(np.arctan2(seen[:, 1], seen[:, 0]))
        gaps = np.diff(angles, append=angles[0] + 2.0 * np.pi)
        widest = int(np.argmax(gaps))
        if gaps[widest] < 0.5 * np.pi:  # all around
            return -self.up, np.pi
        half = np.pi - 0.5 * float(gaps[widest])
        middle = angles[widest] + gaps[widest] + half
        return np.cos(middle) * self.across + np.sin(middle) * self.up, half

    def edges(self, scene: Scene) -> FloatArray:
        """Segments (K, 2, 2) in which the shapes meet the plane."""
        segments = [np.zeros((0, 2, 2))]
        for shape in scene.shapes:
            found = self._of_sphere(shape) if shape.vertices is None else self._of_mesh(shape)
            segments.append(self.flat(found))
        return np.concatenate(segments)

    def _of_mesh(self, shape: Any) -> FloatArray:
        corners = shape.vertices[shape.faces]
        # Vertices that lie in the plane are moved off it, so that each triangle has two sides cut or none.
        sides = (corners - self.origin) @ self.normal
        sides = np.where(np.abs(sides) < 1e-12, 1e-12, sides)
        cut = (sides > 0) != (np.roll(sides, -1, axis=1) > 0)
        crossed = cut.sum(axis=1) == 2
        share = (sides / np.where(cut, sides - np.roll(sides, -1, axis=1), 1.0))[crossed]
        points = corners[crossed] + share[..., None] * (np.roll(corners, -1, axis=1) - corners)[crossed]
        return points[cut[crossed]].reshape(-1, 2, 3)

    def _of_sphere(self, shape: Any) -> FloatArray:
        height = (np.subtract(shape.center, self.origin)) @ self.normal
        if abs(height) >= shape.radius:
            return np.zeros((0, 2, 3))
        turn = np.linspace(0.0, 2.0 * np.pi, 129)
        ring = np.cos(turn)[:, None] * self.across + np.sin(turn)[:, None] * self.up
        points = shape.center - height * self.normal + np.sqrt(shape.radius**2 - height**2) * ring
        return np.stack([points[:-1], points[1:]], axis=1)

    def index(self, scene: Scene, x: FloatArray, y: FloatArray, wavelength: float) -> FloatArray:
        """n at the points (x, y) of the plane, at a wavelength (nm); NaN where there is no medium (n² ≤ 0)."""
        points = (x[..., None] * self.across + y[..., None] * self.up + (self.origin @ self.normal) * self.normal)
        places = points.reshape(-1, 3)
        n = scene.medium.evaluate(places, wavelength)[0]
        for bounds, medium in scene._fillings:  # the last wins
            inside = self._inside(bounds, places)
            if inside.any():
                n[inside] = medium.evaluate(places[inside], wavelength)[0]
        n[~(n > 0)] = np.nan
        return n.reshape(x.shape)

    def _inside(self, bounds: Any, points: FloatArray) -> Any:
        if isinstance(bounds, Box):
            return ((points > bounds.low) & (points < bounds.high)).all(axis=1)
        if isinstance(bounds, Sphere) or bounds.vertices is None:
            return np.linalg.norm(points - bounds.center, axis=1) < bounds.radius
        # A closed mesh: an odd number of its edges in the plane lies beside a point.
        x, y = self.flat(points).T
        inside = np.zeros(len(points), dtype=bool)
        for (x0, y0), (x1, y1) in self.flat(self._of_mesh(bounds)):
            crossed = (y0 > y) != (y1 > y)
            inside ^= crossed & (x < x0 + (y - y0) / ((y1 - y0) or 1.0) * (x1 - x0))
        return inside

    @property
    def place(self) -> str:
        """Where the plane is, in words."""
        for name, unit in zip("xyz", np.eye(3), strict=True):
            if abs(abs(self.normal @ unit) - 1.0) < 1e-9:
                return f"{name} = {self.origin @ unit + 0.0:.4g} m"
        return f"through ({', '.join(f'{part:.4g}' for part in self.origin)}) m"

    @staticmethod
    def label(axis: FloatArray) -> str:
        """"x, m" for an axis of the world, else its direction."""
        for name, unit in zip("xyz", np.eye(3), strict=True):
            if abs(abs(axis @ unit) - 1.0) < 1e-9:
                return f"{name}, m" if axis @ unit > 0 else f"−{name}, m"
        return f"along ({', '.join(f'{part:.2f}' for part in axis)}), m"


def light_source(light: Any) -> tuple[FloatArray, FloatArray | None]:
    """Where a light's rays start, and what it is aimed at."""
    if isinstance(light, (Sun, Environment)):
        raise ValueError(f"light is a {type(light).__name__}, infinitely far away; rays are drawn from other lights only")
    if not isinstance(light, Area):
        return np.array(light.position), np.array(light.target) if isinstance(light, Spot) else None
    if light.shape.vertices is None:
        return np.array(light.shape.center), None
    corners = light.shape.vertices[light.shape.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = corners.mean(axis=1)
    weights = np.linalg.norm(normals, axis=1)
    center, normal = np.average(middle, axis=0, weights=weights), normals.sum(axis=0)
    length = float(np.linalg.norm(normal))
    # Off the surface, on its bright side, so that the fan does not start by hitting it.
    offset = normal / length if length else np.zeros(3)
    return center + 1e-6 * float(np.abs(corners).max()) * offset, center + offset
