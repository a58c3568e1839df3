"""What ``Scene.add_mesh`` and ``Scene.add_sphere`` return."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import FloatArray, Vector

if TYPE_CHECKING:
    from .materials import Material

__all__ = ["Shape"]


@dataclass(frozen=True, eq=False)
class Shape:
    """A shape of one scene: to be an area light, to bound a medium, to be told from ``rays.shape``.

    Attributes
    ----------
    index : int
        What ``rays.shape`` holds for rays that hit it.
    name : str
        Used in messages; may be "".
    material : Material
    vertices, faces : ndarray, shape (V, 3) and (F, 3), or None
        Of a mesh; metres.
    center, radius
        Of a sphere; metres. None for a mesh.
    """

    index: int
    name: str
    material: Material
    vertices: FloatArray | None = field(default=None, repr=False)
    faces: np.ndarray | None = field(default=None, repr=False)
    center: Vector | None = None
    radius: float | None = None
    _owner: Any = field(default=None, repr=False)

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of its box, metres."""
        if self.vertices is None:
            assert self.center is not None and self.radius is not None
            return np.subtract(self.center, self.radius), np.add(self.center, self.radius)
        used = self.vertices[np.unique(self.faces)] if self.faces is not None and self.faces.size else self.vertices
        return used.min(axis=0), used.max(axis=0)


def extent_of(shapes: Sequence[Shape]) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner of the box of all; the unit box where there are none."""
    if not shapes:
        return np.zeros(3), np.ones(3)
    lows, highs = zip(*(shape.extent for shape in shapes), strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)
