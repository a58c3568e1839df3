"""Lights.

``intensity`` is the actual W/sr/nm in the medium at the light. ``radiance`` is basic, W·m⁻²·sr⁻¹·nm⁻¹: what the surface
would show in vacuum; in index n it emits n² times it.

``Sun`` and ``Environment`` are infinitely far away: a ray that crosses the scene's extent outward sees them by its
direction there, and photons come in there. For these photons only paths are started that cross a box about what there
is to be lit: the shapes, or ``aim``. Of a planet (shapes of 1000 km and more) that is what lies within 25 km of the
camera. A picture of the sky alone needs no photons and makes none.

Directions are a compass's: elevation from the level, azimuth clockwise seen from above, 0 in the north, which is −z as
far as it is level (what a camera that looks along −z faces; +x is east then), or +y where up is ±z. ``up`` is the
medium's (of an :class:`cpm.media.Atmosphere`: at its origin on the ground), else +y.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ._arrays import Vector, VectorLike, as_number, as_vector
from ._sky import SkyImage, as_sky_image, solar_irradiance
from .bounds import Box
from .shapes import Shape
from .spectra import Spectrum, SpectrumLike, as_spectrum

__all__ = ["SUN_RADIUS", "Area", "Environment", "Light", "Point", "Spot", "Sun"]

#: Mean angular radius of the Sun, degrees: 959.63″ (Allen's Astrophysical Quantities).
SUN_RADIUS = 0.2666


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


@dataclass(frozen=True, init=False)
class Sun:
    """The Sun's disc, darkened towards its limb.

    Parameters
    ----------
    elevation : float
        Of the disc's centre, degrees above the level: the true one, that of the straight line. Refraction shows it
        higher.
    azimuth : float
        Degrees, clockwise from north seen from above: see the module.
    radiance : spectrum, optional
        Basic radiance, W·m⁻²·sr⁻¹·nm⁻¹, its mean over the disc (irradiance over solid angle, whatever the limb
        darkening). Default: the irradiance of ASTM E490 at one astronomical unit over the disc's solid angle.
    angular_radius : float
        Degrees, above 0, below 90.
    limb_darkening : bool
        By wavelength (Neckel 2005), or an even disc.
    up : array_like, shape (3,), optional
        Default: the medium's, else +y.
    aim : Box, optional
        What its photons are to light; they start only on paths that cross it first. Nothing outside of it is lit by
        them, and what they could meet on their way to it hides it.
    """

    elevation: float
    azimuth: float
    radiance: Spectrum
    angular_radius: float
    limb_darkening: bool
    up: Vector | None
    aim: Box | None

    def __init__(self, elevation: float, azimuth: float, radiance: SpectrumLike | None = None,
                 angular_radius: float = SUN_RADIUS, limb_darkening: bool = True, up: VectorLike | None = None,
                 aim: Box | None = None) -> None:
        object.__setattr__(self, "elevation", as_number(elevation, "elevation"))
        if not -90 <= self.elevation <= 90:
            raise ValueError(f"elevation is {self.elevation:g} degrees; -90 to 90 are allowed")
        object.__setattr__(self, "azimuth", as_number(azimuth, "azimuth"))
        object.__setattr__(self, "angular_radius", as_number(angular_radius, "angular_radius"))
        if not 0 < self.angular_radius < 90:
            raise ValueError(f"angular_radius is {self.angular_radius:g} degrees; above 0, below 90 is allowed")
        if not isinstance(limb_darkening, (bool, np.bool_)):
            raise TypeError(f"limb_darkening is {limb_darkening!r}; True or False is needed")
        object.__setattr__(self, "limb_darkening", bool(limb_darkening))
        emitted = _emission(radiance, "radiance") if radiance is not None else (
            solar_irradiance().scaled(1.0 / self.solid_angle))
        object.__setattr__(self, "radiance", emitted)
        object.__setattr__(self, "up", _as_up(up))
        object.__setattr__(self, "aim", _as_aim(aim))

    @property
    def solid_angle(self) -> float:
        """Of the disc, sr."""
        return float(4 * np.pi * np.sin(np.radians(0.5 * self.angular_radius)) ** 2)


@dataclass(frozen=True, init=False)
class Environment:
    """Light from all directions.

    Parameters
    ----------
    radiance : spectrum or image
        Basic radiance, W·m⁻²·sr⁻¹·nm⁻¹. A spectrum shines evenly. An image is a :class:`cpm.Image`, ``(wavelengths,
        values)`` with values of shape (height, width, bins), or ``{"file": "sky.exr"}`` (a spectral EXR) or ``{"file": "sky.npy",
        "wavelengths": [...]}``, with ``scale`` if wanted: equal steps of angle (lat-long), row 0 up, the middle column
        north, the right half east; linear between the centres of pixels.
    up : array_like, shape (3,), optional
        Of the image. Default: the medium's, else +y.
    aim : Box, optional
        As for :class:`Sun`.
    """

    radiance: Spectrum | SkyImage
    up: Vector | None
    aim: Box | None

    def __init__(self, radiance: SpectrumLike, up: VectorLike | None = None, aim: Box | None = None) -> None:
        image = as_sky_image(radiance)
        object.__setattr__(self, "radiance", _emission(radiance, "radiance") if image is None else image)
        object.__setattr__(self, "up", _as_up(up))
        object.__setattr__(self, "aim", _as_aim(aim))


def _as_up(up: VectorLike | None) -> Vector | None:
    if up is None:
        return None
    vector = as_vector(up, "up")
    if not np.any(vector):
        raise ValueError("up is (0, 0, 0); a direction is needed")
    return vector


def _as_aim(aim: Box | None) -> Box | None:
    if aim is not None and not isinstance(aim, Box):
        raise TypeError(f"aim is {aim!r}; a cpm.Box is needed")
    return aim


Light: TypeAlias = Point | Spot | Area | Sun | Environment


def light_spectrum(light: Light) -> Spectrum | SkyImage:
    """What it emits, W/sr/nm or W·m⁻²·sr⁻¹·nm⁻¹."""
    return light.intensity if isinstance(light, (Point, Spot)) else light.radiance
