"""Spectra: functions of wavelength for reflectances and emissions.

Linear between samples, held beyond them, taken at the bin centres of a render.
"""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _core, _data
from ._arrays import FloatArray, as_array, as_number
from ._colour import colour_science

__all__ = ["Spectrum", "SpectrumLike", "as_spectrum", "names"]

#: A number, a name, ``(wavelengths, values)``, a mapping, a colour-science SpectralDistribution or a Spectrum.
SpectrumLike: TypeAlias = Any

#: Named illuminants are 1 here, nm.
NORMAL_WAVELENGTH = 560.0


class Spectrum:
    """A sampled or flat spectrum.

    Parameters
    ----------
    wavelengths : array_like, shape (K,), or None
        nm, strictly increasing; None for a flat spectrum.
    values : array_like, shape (K,), or float
        What the spectrum is at each.
    name : str
        For messages and ``repr``.
    """

    def __init__(self, wavelengths: npt.ArrayLike | None, values: npt.ArrayLike, name: str = "") -> None:
        self.name = name
        self.wavelengths: FloatArray | None
        if wavelengths is None:
            self.wavelengths = None
            self.values = np.array([as_number(values, "spectrum")])
            return
        self.wavelengths, self.values = as_array(wavelengths, "wavelengths"), as_array(values, "values")
        if self.wavelengths.ndim != 1 or self.wavelengths.shape != self.values.shape or not self.wavelengths.size:
            raise ValueError(f"a spectrum has wavelengths of shape {self.wavelengths.shape} and values of shape "
                             f"{self.values.shape}; two equally long lists are needed: ([400, 700], [0.2, 0.6])")
        for array, what in ((self.wavelengths, "wavelengths"), (self.values, "values")):
            bad = np.flatnonzero(~np.isfinite(array))
            if bad.size:
                raise ValueError(f"a spectrum's {what}[{bad[0]}] is {array[bad[0]]}; finite numbers are needed")
        falls = np.flatnonzero(np.diff(self.wavelengths) <= 0)
        if falls.size:
            i = int(falls[0]) + 1
            raise ValueError(f"a spectrum's wavelengths[{i}] is {self.wavelengths[i]:g} nm after "
                             f"{self.wavelengths[i - 1]:g}; they must increase strictly")

    def at(self, wavelength: npt.ArrayLike) -> FloatArray:
        """Values at wavelengths (nm): linear between samples, held beyond."""
        wanted = as_array(wavelength, "wavelength")
        if self.wavelengths is None:
            return np.full(wanted.shape, self.values[0])
        return np.interp(wanted, self.wavelengths, self.values)

    def scaled(self, scale: float) -> Spectrum:
        """The same spectrum times a number."""
        factor = as_number(scale, "scale")
        if self.wavelengths is None:
            return Spectrum(None, self.values[0] * factor, self.name)
        return Spectrum(self.wavelengths, self.values * factor, self.name)

    def _core(self) -> _core.Spectrum:
        wavelengths = [] if self.wavelengths is None else self.wavelengths.tolist()
        return _core.Spectrum(wavelengths, self.values.tolist())

    def __repr__(self) -> str:
        if self.name:
            return f"Spectrum({self.name!r})"
        if self.wavelengths is None:
            return f"Spectrum({self.values[0]:g})"
        return f"Spectrum({len(self.values)} samples, {self.wavelengths[0]:g}-{self.wavelengths[-1]:g} nm)"


def as_spectrum(value: SpectrumLike, argument: str = "spectrum") -> Spectrum:
    """A spectrum from anything that stands for one.

    Parameters
    ----------
    value : number, str, pair, mapping, SpectralDistribution or Spectrum
        A number is flat. A name is a shipped paint ("cornell-white", "cornell-red", "cornell-green") or an illuminant
        of colour-science ("D65", "A", …), which is 1 at 560 nm. A pair is ``(wavelengths, values)``, nm. A mapping has
        ``name``, or ``wavelengths`` and ``values``, and may have ``scale``.
    argument : str
        What to call it in messages.
    """
    if isinstance(value, Spectrum):
        return value
    if isinstance(value, str):
        return named(value, argument)
    if isinstance(value, Mapping):
        return _from_mapping(value, argument)
    if hasattr(value, "wavelengths") and hasattr(value, "values"):  # colour.SpectralDistribution
        return Spectrum(value.wavelengths, value.values, str(getattr(value, "name", "")))
    if isinstance(value, (tuple, list)):
        if len(value) != 2:
            raise ValueError(f"{argument} has {len(value)} parts; a pair (wavelengths, values) is needed")
        return Spectrum(value[0], value[1])
    return Spectrum(None, as_number(value, argument))


def names() -> list[str]:
    """Names that ship with the package (illuminants of colour-science are known beside them)."""
    return [entry["name"] for entry in _data.table("paints.toml")["paint"]]


def named(name: str, argument: str = "spectrum") -> Spectrum:
    """A shipped paint, or an illuminant of colour-science scaled to 1 at 560 nm."""
    for entry in _data.table("paints.toml")["paint"]:
        if entry["name"] == name:
            grid = entry["wavelengths"]
            return Spectrum(np.arange(grid["first"], grid["last"] + grid["step"], grid["step"], dtype=float),
                            entry["values"], name)
    illuminants = colour_science().SDS_ILLUMINANTS
    if name not in illuminants:
        raise ValueError(f"{argument} is {name!r}; {', '.join(names())} or an illuminant such as D65, A, E, FL2 is "
                         "allowed")
    table = illuminants[name]
    values = np.asarray(table.values, dtype=float)
    return Spectrum(table.wavelengths, values / np.interp(NORMAL_WAVELENGTH, table.wavelengths, values), name)


def _from_mapping(value: Mapping[str, Any], argument: str) -> Spectrum:
    unknown = set(value) - {"name", "wavelengths", "values", "scale"}
    if unknown:
        raise ValueError(f"{argument} has {sorted(unknown)[0]!r}; name, wavelengths, values, scale are allowed")
    if "name" in value:
        made = named(value["name"], argument)
    elif "values" in value and "wavelengths" in value:
        made = Spectrum(value["wavelengths"], value["values"])
    else:
        raise ValueError(f"{argument} has {sorted(value)}; name, or wavelengths and values are needed")
    return made.scaled(value.get("scale", 1.0))
