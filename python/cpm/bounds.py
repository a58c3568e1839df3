"""Where a bounded medium is: a box, a sphere, or a closed shape of the scene."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, Union

from ._arrays import Vector, VectorLike, as_number, as_vector

if TYPE_CHECKING:
    from .shapes import Shape

__all__ = ["Bounds", "Box", "Sphere"]


@dataclass(frozen=True)
class Box:
    """An axis-parallel box.

    Parameters
    ----------
    low, high : array_like, shape (3,)
        Opposite corners, metres; ``low < high`` in each coordinate.
    """

    low: Vector
    high: Vector

    def __init__(self, low: VectorLike, high: VectorLike) -> None:
        corners = as_vector(low, "low"), as_vector(high, "high")
        for axis, (a, b) in enumerate(zip(*corners, strict=True)):
            if not a < b:
                raise ValueError(f"box has low[{axis}] = {a:g} and high[{axis}] = {b:g}; low < high is needed")
        object.__setattr__(self, "low", corners[0])
        object.__setattr__(self, "high", corners[1])

    @classmethod
    def unchecked(cls, low: Vector, high: Vector) -> Box:
        """A box that may be infinite, as an extent is where nothing bends."""
        box = object.__new__(cls)
        object.__setattr__(box, "low", tuple(float(x) for x in low))
        object.__setattr__(box, "high", tuple(float(x) for x in high))
        return box


@dataclass(frozen=True)
class Sphere:
    """A ball.

    Parameters
    ----------
    center : array_like, shape (3,)
        Metres.
    radius : float
        Metres, > 0.
    """

    center: Vector
    radius: float

    def __init__(self, center: VectorLike, radius: float) -> None:
        radius = as_number(radius, "radius")
        if not radius > 0:
            raise ValueError(f"radius is {radius:g}; it must be > 0")
        object.__setattr__(self, "center", as_vector(center, "center"))
        object.__setattr__(self, "radius", radius)


Bounds: TypeAlias = Union[Box, Sphere, "Shape"]
