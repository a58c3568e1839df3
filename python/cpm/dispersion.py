"""Dispersion models: refractive index as a function of wavelength.

A model gives n by itself (a homogeneous glass) or scales a varying medium, whose own numbers then hold at the d line,
587.5618 nm: see :mod:`cpm.media`. Formulas take the wavelength in micrometres, as their sources do; every interface
here takes nanometres.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from . import _core, _data, air
from ._arrays import as_array, as_number

__all__ = ["Air", "Cauchy", "Constant", "Dispersion", "Gas", "Sellmeier", "Tabulated", "as_dispersion", "catalogue"]


class Dispersion:
    """What all models share.

    Attributes
    ----------
    range : tuple of float or None
        Wavelengths (nm) for which the model holds; None where it has no limits.
    reference : str
        "vacuum" or "air": what the index is relative to, as published; "" where nothing was said.
    name, source : str
        Of a catalogue entry; else "".
    """

    _kind: ClassVar[str]

    def __init__(self, coefficients: Sequence[float], range: tuple[float, float] | None = None, *,
                 extrapolate: bool = False, reference: str = "") -> None:
        if range is not None:
            low, high = as_number(range[0], "range[0]"), as_number(range[1], "range[1]")
            if not 0 <= low < high:
                raise ValueError(f"range is {low} to {high} nm; 0 <= low < high is needed")
            range = (low, high)
        self.range = range
        self.extrapolate = bool(extrapolate)
        self.reference = reference
        self.name = self.source = ""
        self._coefficients = tuple(float(c) for c in coefficients)
        if not np.isfinite(self._coefficients).all():
            raise ValueError(f"{type(self).__name__} has coefficients {self._coefficients}; finite numbers are needed")
        self._core()  # the core's own checks, now rather than at the first render

    def _core(self, extrapolate: bool | None = None) -> _core.Dispersion:
        free = self.extrapolate if extrapolate is None else extrapolate
        low, high = (0.0, 0.0) if self.range is None or free else self.range
        return _core.Dispersion(self._kind, list(self._coefficients), low, high)

    def n(self, wavelength: npt.ArrayLike, extrapolate: bool | None = None) -> Any:
        """Refractive index.

        Parameters
        ----------
        wavelength : float or array_like
            In nm.
        extrapolate : bool, optional
            True: use the formula outside its range too. Default: as the model was made.

        Returns
        -------
        float or ndarray
            Of the shape of ``wavelength``; as published, so relative to :attr:`reference`.

        Raises
        ------
        ValueError
            A wavelength out of the model's range, or one that is not positive and finite.
        """
        wavelengths = as_array(wavelength, "wavelength")
        bad = np.flatnonzero(~(np.isfinite(wavelengths) & (wavelengths > 0)))
        if bad.size:
            raise ValueError(f"wavelength[{bad[0]}] is {wavelengths.flat[bad[0]]} nm; finite and > 0 is needed")
        values = self._core(extrapolate).n(np.ascontiguousarray(wavelengths.ravel()))
        return values.reshape(wavelengths.shape) if wavelengths.ndim else float(values[0])

    def __repr__(self) -> str:
        if self.name:
            return f"catalogue({self.name!r})"
        return f"{type(self).__name__}({', '.join(f'{c:g}' for c in self._coefficients)})"


class Constant(Dispersion):
    """The same n at every wavelength."""

    _kind = "constant"

    def __init__(self, n: float, **options: Any) -> None:
        super().__init__([as_number(n, "n")], **options)


class Cauchy(Dispersion):
    """n = A + B/λ² + C/λ⁴ + …, with λ in micrometres.

    Parameters
    ----------
    A : float
        Dimensionless.
    B, C : float, optional
        µm², µm⁴.
    *more : float
        Of λ⁻⁶, λ⁻⁸, …
    """

    _kind = "cauchy"

    def __init__(self, A: float, B: float = 0.0, C: float = 0.0, *more: float, **options: Any) -> None:
        coefficients = (A, B, C, *more)
        super().__init__([as_number(c, f"coefficient {i}") for i, c in enumerate(coefficients)], **options)


class Sellmeier(Dispersion):
    """n² = 1 + Σ Bᵢ λ²/(λ² − Cᵢ), with λ in micrometres.

    Parameters
    ----------
    B : sequence of float
        Strengths, dimensionless.
    C : sequence of float
        Squares of the resonance wavelengths, µm².
    """

    _kind = "sellmeier"

    def __init__(self, B: Sequence[float], C: Sequence[float], **options: Any) -> None:
        strengths, poles = np.atleast_1d(as_array(B, "B")), np.atleast_1d(as_array(C, "C"))
        if strengths.ndim != 1 or strengths.shape != poles.shape or not strengths.size:
            raise ValueError(f"B has shape {strengths.shape} and C {poles.shape}; as many of one as of the other")
        super().__init__(np.stack([strengths, poles], axis=1).ravel().tolist(), **options)


class Tabulated(Dispersion):
    """A table, linear between its entries.

    Parameters
    ----------
    wavelengths : sequence of float
        nm, strictly increasing; at most 32 entries.
    n : sequence of float
        Index at each.
    """

    _kind = "tabulated"

    def __init__(self, wavelengths: Sequence[float], n: Sequence[float], **options: Any) -> None:
        positions, values = as_array(wavelengths, "wavelengths"), as_array(n, "n")
        if positions.ndim != 1 or positions.shape != values.shape or positions.size < 2:
            raise ValueError(f"wavelengths has shape {positions.shape} and n {values.shape}; "
                             "two equally long lists of at least 2 are needed")
        if not (np.diff(positions) > 0).all():
            bad = int(np.flatnonzero(~(np.diff(positions) > 0))[0]) + 1
            raise ValueError(f"wavelengths[{bad}] is {positions[bad]} nm; they must increase strictly")
        options.setdefault("range", (positions[0], positions[-1]))
        super().__init__(np.stack([positions, values], axis=1).ravel().tolist(), **options)


class Gas(Dispersion):
    """n − 1 = Σ Bᵢ/(Cᵢ − σ²) + a + b σ² + c σ⁴ + d σ⁶, with σ = 1/λ in 1/µm: the form of air's formulas.

    Parameters
    ----------
    B, C : sequence of float
        Strengths and squares of the resonances' wavenumbers, both in µm⁻².
    polynomial : sequence of float, optional
        a, b, c, d, at most; dimensionless, µm², µm⁴, µm⁶.
    """

    _kind = "gas"

    def __init__(self, B: Sequence[float] = (), C: Sequence[float] = (), polynomial: Sequence[float] = (),
                 **options: Any) -> None:
        strengths, poles = np.atleast_1d(as_array(B, "B")), np.atleast_1d(as_array(C, "C"))
        powers = np.atleast_1d(as_array(polynomial, "polynomial"))
        if strengths.ndim != 1 or strengths.shape != poles.shape:
            raise ValueError(f"B has shape {strengths.shape} and C {poles.shape}; as many of one as of the other")
        if powers.ndim != 1 or powers.size > 4:
            raise ValueError(f"polynomial has shape {powers.shape}; at most 4 numbers are allowed")
        leading = [*powers.tolist(), *[0.0] * (4 - powers.size)]
        super().__init__(leading + np.stack([strengths, poles], axis=1).ravel().tolist(), **options)


class Air(Gas):
    """Air of one temperature, pressure and humidity.

    Parameters
    ----------
    temperature, pressure : float
        K, Pa.
    humidity : float
        Fraction; 1 is saturated.
    co2 : float
        ppm; only Ciddor's model knows it.
    model : {"ciddor", "edlen", "iag1999"}
        See :func:`cpm.air.refractivity`.
    """

    def __init__(self, temperature: float = 288.15, pressure: float = 101325.0, humidity: float = 0.0,
                 co2: float = 450.0, model: str = "ciddor", extrapolate: bool = False) -> None:
        state = [np.float64(as_number(value, name)) for value, name in
                 ((temperature, "temperature"), (pressure, "pressure"), (humidity, "humidity"))]
        air.check_state(*map(np.asarray, state))
        vapour = float(air.vapour_pressure(*state))
        coefficients = air.gas_coefficients(model, float(state[0]), float(state[1]), vapour, as_number(co2, "co2"))
        super().__init__(*coefficients, range=air.RANGES[model], extrapolate=extrapolate, reference="vacuum")


def catalogue(name: str, extrapolate: bool = False) -> Dispersion:
    """A published dispersion.

    Parameters
    ----------
    name : str
        "BK7" (SCHOTT N-BK7), "F2", "SF11", "fused silica", "water", "sapphire" (ordinary ray), "diamond" or "air";
        case, hyphens and spaces do not matter.
    extrapolate : bool
        Use the formula outside the range that its source gives.

    Returns
    -------
    Dispersion
        With ``.reference``, ``.range`` and ``.source``. ``.n()`` is the published value.

    Notes
    -----
    Numbers and sources are in ``spectral/data/dispersion.toml``.
    """
    entries = _data.table("dispersion.toml")["material"]
    wanted = _folded(name) if isinstance(name, str) else None
    for entry in entries:
        if wanted in [_folded(known) for known in (entry["name"], *entry.get("aliases", []))]:
            return _from_entry(entry, extrapolate)
    raise ValueError(f"material is {name!r}; {', '.join(entry['name'] for entry in entries)} are in the catalogue")


def catalogue_names() -> list[str]:
    """What :func:`catalogue` knows."""
    return [entry["name"] for entry in _data.table("dispersion.toml")["material"]]


def as_dispersion(value: Any) -> Dispersion:
    """A model from itself, a number (constant) or a catalogue name."""
    if isinstance(value, Dispersion):
        return value
    return catalogue(value) if isinstance(value, str) else Constant(value)


def _folded(name: str) -> str:
    return name.lower().replace("-", "").replace("_", "").replace(" ", "")


def _from_entry(entry: dict[str, Any], extrapolate: bool) -> Dispersion:
    options = {"range": tuple(entry["range"]), "extrapolate": extrapolate, "reference": entry["reference"]}
    made: Dispersion
    if entry["formula"] == "sellmeier":
        # Sources give either the squares of the resonances (SCHOTT) or the resonances themselves (Malitson).
        poles = entry["C"] if "C" in entry else np.square(entry["resonance"])
        made = Sellmeier(entry["B"], poles, **options)
    else:
        made = Gas(entry["B"], entry["C"], **options)
    made.name, made.source = entry["name"], entry["source"]
    return made
