"""Lights.

``intensity`` is the actual W/sr/nm in the medium at the light. ``radiance`` is basic, W·m⁻²·sr⁻¹·nm⁻¹: what the surface
would show in vacuum; in index n it emits n² times it.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ._arrays import Vector, VectorLike, as_number, as_vector
from .shapes import Shape
from .spectra import Spectrum, SpectrumLike, as_spectrum

__all__ = ["Area", "Light", "Point", "Spot"]


def _emission(value: SpectrumLike, name: str) -> Spectrum:
    spectrum = as_spectrum(value, name)
    bad = np.flatnonzero(~(spectrum.values >= 0))
    if bad.size:
        raise ValueError(f"{name} is {spectrum.values[bad[0]]:g}; it must be >= 0")
    return spectrum


@dataclass(frozen=True, init=False)
class Point:
    """A point that shines evenly in all directions.

    Parameters
    ----------
    position : array_like, shape (3,)
        Metres.
    intensity : spectrum
        W/sr/nm.
    """

    position: Vector
    intensity: Spectrum

    def __init__(self, position: VectorLike, intensity: SpectrumLike) -> None:
        object.__setattr__(self, "position", as_vector(position, "position"))
        object.__setattr__(self, "intensity", _emission(intensity, "intensity"))


@dataclass(frozen=True, init=False)
class Spot:
    """A point that shines evenly inside a cone.

    Parameters
    ----------
    position, target : array_like, shape (3,)
        Metres.
    cutoff : float
        Half-angle of the cone, degrees, in (0, 180].
    intensity : spectrum
        W/sr/nm inside the cone.
    """

    position: Vector
    target: Vector
    cutoff: float
    intensity: Spectrum

    def __init__(self, position: VectorLike, target: VectorLike, cutoff: float, intensity: SpectrumLike) -> None:
        object.__setattr__(self, "position", as_vector(position, "position"))
        object.__setattr__(self, "target", as_vector(target, "target"))
        if self.position == self.target:
            raise ValueError(f"position and target are both {self.position}; the spot has no direction")
        object.__setattr__(self, "cutoff", as_number(cutoff, "cutoff"))
        if not 0 < self.cutoff <= 180:
            raise ValueError(f"cutoff is {self.cutoff:g} degrees; more than 0, at most 180 is allowed")
        object.__setattr__(self, "intensity", _emission(intensity, "intensity"))


@dataclass(frozen=True, init=False)
class Area:
    """A shape that shines on the side of its geometric normal, (b − a) × (c − a).

    Parameters
    ----------
    shape : Shape
        Of the scene that the light is added to.
    radiance : spectrum
        Basic radiance, W·m⁻²·sr⁻¹·nm⁻¹.
    """

    shape: Shape
    radiance: Spectrum

    def __init__(self, shape: Shape, radiance: SpectrumLike) -> None:
        if not isinstance(shape, Shape):
            raise TypeError(f"shape is {shape!r}; what Scene.add_mesh or add_sphere returned is needed")
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "radiance", _emission(radiance, "radiance"))


Light: TypeAlias = Point | Spot | Area


def light_spectrum(light: Light) -> Spectrum:
    """What it emits, W/sr/nm or W·m⁻²·sr⁻¹·nm⁻¹."""
    return light.radiance if isinstance(light, Area) else light.intensity
