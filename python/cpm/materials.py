"""Surfaces: what photons and eye rays do at them."""
from __future__ import annotations

from dataclasses import dataclass, field
from numbers import Real
from typing import Any, TypeAlias

import numpy as np

from . import _core
from .dispersion import Dispersion, catalogue_names
from .media import Medium, as_medium
from .spectra import Spectrum, SpectrumLike, as_spectrum

__all__ = ["Black", "Dielectric", "Diffuse", "Material", "Mirror", "as_material"]


def _interior(value: Any) -> Medium:
    if isinstance(value, (str, Real, Dispersion, Medium)) and not isinstance(value, bool):
        try:
            return as_medium(value)
        except ValueError as error:
            if not isinstance(value, str):
                raise ValueError(f"interior: {error}") from None
    names = ", ".join(catalogue_names())
    refused = ValueError if isinstance(value, str) else TypeError
    raise refused(f"interior is {value!r}; a number, a catalogue name ({names}), a dispersion or a medium is allowed")


def _reflectance(value: SpectrumLike) -> Spectrum:
    spectrum = as_spectrum(value, "reflectance")
    bad = np.flatnonzero(~((spectrum.values >= 0) & (spectrum.values <= 1)))
    if bad.size:
        where = "" if spectrum.wavelengths is None else f" at {spectrum.wavelengths[bad[0]]:g} nm"
        raise ValueError(f"reflectance is {spectrum.values[bad[0]]:g}{where}; 0 to 1 is allowed")
    return spectrum


@dataclass(frozen=True, init=False)
class Diffuse:
    """Lambertian reflection, on both sides.

    Parameters
    ----------
    reflectance : spectrum
        In [0, 1]; see :func:`cpm.spectra.as_spectrum` for what stands for a spectrum.
    """

    reflectance: Spectrum

    def __init__(self, reflectance: SpectrumLike) -> None:
        object.__setattr__(self, "reflectance", _reflectance(reflectance))

    def _core(self) -> _core.Material:
        return _core.diffuse(self.reflectance._core())


@dataclass(frozen=True, init=False)
class Mirror:
    """Specular reflection, on both sides.

    Parameters
    ----------
    reflectance : spectrum
        In [0, 1].
    """

    reflectance: Spectrum

    def __init__(self, reflectance: SpectrumLike = 1.0) -> None:
        object.__setattr__(self, "reflectance", _reflectance(reflectance))

    def _core(self) -> _core.Material:
        return _core.mirror(self.reflectance._core())


@dataclass(frozen=True)
class Black:
    """Absorbs everything; photons are stored on it all the same."""

    def _core(self) -> _core.Material:
        return _core.black()


@dataclass(frozen=True, init=False)
class Dielectric:
    """A smooth boundary: Snell and Fresnel with the local n(r, λ) of both sides. The shape must be closed.

    Parameters
    ----------
    interior : float, str, Dispersion or Medium
        What fills the shape: an index, a catalogue name ("BK7"), a dispersion or any medium.
    """

    interior: Medium = field()

    def __init__(self, interior: Any) -> None:
        object.__setattr__(self, "interior", _interior(interior))

    def _core(self) -> _core.Material:
        return _core.dielectric(self.interior._handle)


Material: TypeAlias = Diffuse | Mirror | Black | Dielectric


def as_material(value: Any) -> Material:
    """``value`` if it is a material; TypeError that names them if not."""
    if not isinstance(value, (Diffuse, Mirror, Black, Dielectric)):
        raise TypeError(f"material is {value!r}; one of cpm.materials (Diffuse, Mirror, Black, Dielectric) is needed")
    return value
