"""Air: its refractive index, how it scatters, and the water vapour in it.

Two components, each a density times a dispersion (Ciddor 1996, eq. 5):

    n − 1 = (ρ_a/ρ_axs) (n_axs − 1) + (ρ_w/ρ_ws) (n_ws − 1)

with n_axs of dry air at 15 °C and 101325 Pa, n_ws of water vapour at 20 °C and 1333 Pa. What returns a refractivity
n − 1 keeps all its digits; 1 + it loses four.

Wavelengths are vacuum wavelengths in nm, temperatures K, pressures Pa, humidity a fraction (1 is saturated over liquid
water), CO₂ parts per million of dry air. All arguments broadcast.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import FloatArray, as_array, one_of

__all__ = [
    "MODELS",
    "ciddor",
    "edlen",
    "iag1999",
    "king_factor",
    "rayleigh_cross_section",
    "rayleigh_extinction",
    "refractivity",
    "saturation_pressure",
    "vapour_pressure",
]

#: Names that ``refractivity=`` takes everywhere.
MODELS = ("ciddor", "edlen", "iag1999")

#: Where a model's dispersion holds, nm. Ciddor's rests on measurements from 230 to 1690 nm; his tables go to 1700.
RANGES = {"ciddor": (230.0, 1700.0), "edlen": (230.0, 1700.0), "iag1999": (300.0, 2000.0)}

# Ciddor (1996), appendix A. Dry air: n_axs − 1 = Σ k/(k' − σ²), σ in 1/µm. Water vapour: a polynomial in σ².
_DRY_STRENGTHS, _DRY_POLES = np.array([0.05792105, 0.00167917]), np.array([238.0185, 57.362])
_VAPOUR = 1.022e-8 * np.array([295.235, 2.6422, -0.032380, 0.004028])
# Water vapour in the other two: Birch and Downs (1993) by σ², and Hohenkerk and Sinclair, K/Pa.
_EDLEN_VAPOUR = (3.7345, -0.0401)
_IAG_VAPOUR = 11.2684e-8
_GAS_CONSTANT = 8.314510  # the paper's, J/(mol K)
_MOLAR_VAPOUR = 0.018015  # kg/mol

_BOLTZMANN = 1.380649e-23


def saturation_pressure(temperature: npt.ArrayLike) -> FloatArray:
    """Saturation pressure over liquid water, also below 0 °C as radiosondes report it (Giacomo 1982).

    Parameters
    ----------
    temperature : array_like
        K.

    Returns
    -------
    ndarray
        Pa.
    """
    t = as_array(temperature, "temperature")
    return np.exp((1.2378847e-5 * t - 1.9121316e-2) * t + 33.93711047 - 6.3431645e3 / t)


def vapour_pressure(temperature: npt.ArrayLike, pressure: npt.ArrayLike, humidity: npt.ArrayLike) -> FloatArray:
    """Partial pressure of water vapour, Pa: f h p_sv with the enhancement factor f(p, t) (Ciddor, appendix A)."""
    t, p = as_array(temperature, "temperature"), as_array(pressure, "pressure")
    enhancement = 1.00062 + 3.14e-8 * p + 5.6e-7 * (t - 273.15) ** 2
    return enhancement * as_array(humidity, "humidity") * saturation_pressure(t)


def refractivity(
    wavelength: npt.ArrayLike,
    temperature: npt.ArrayLike,
    pressure: npt.ArrayLike,
    vapour: npt.ArrayLike = 0.0,
    model: str = "ciddor",
    co2: float = 450.0,
) -> FloatArray:
    """n − 1 of air of given temperature, total pressure and vapour pressure.

    Parameters
    ----------
    wavelength : array_like
        nm, in vacuum.
    temperature, pressure, vapour : array_like
        K, Pa, Pa.
    model : {"ciddor", "edlen", "iag1999"}
        Ciddor 1996; Edlén's equation as Birch and Downs (1993, 1994) give it; what Hohenkerk and Sinclair's refraction
        code uses (IAG 1999).
    co2 : float
        ppm; only Ciddor's model knows it.

    Returns
    -------
    ndarray
        Dimensionless.
    """
    one_of(model, "model", MODELS)
    wavelengths = as_array(wavelength, "wavelength")
    _check_wavelengths(wavelengths, model)
    t, p, e = as_array(temperature, "temperature"), as_array(pressure, "pressure"), as_array(vapour, "vapour")
    if model == "ciddor":
        dry, wet = _ciddor_densities(t, p, e, co2)
        return dry * _dry(wavelengths) * _co2_factor(co2) + wet * _wet(wavelengths)
    if model == "edlen":
        return _edlen(wavelengths, t, p, e)
    return _iag1999(wavelengths, t, p, e)


def vapour_part(
    wavelength: npt.ArrayLike,
    temperature: npt.ArrayLike,
    pressure: npt.ArrayLike,
    vapour: npt.ArrayLike,
    model: str = "ciddor",
) -> FloatArray:
    """What of :func:`refractivity` has water vapour's dispersion; the rest has dry air's. Negative in "edlen" and
    "iag1999", which take a mixture for dry air first and then subtract. "iag1999" gives it no dispersion."""
    one_of(model, "model", MODELS)
    wavelengths = as_array(wavelength, "wavelength")
    t, p, e = as_array(temperature, "temperature"), as_array(pressure, "pressure"), as_array(vapour, "vapour")
    if model == "ciddor":
        return _ciddor_densities(t, p, e, 450.0)[1] * _wet(wavelengths)
    if model == "edlen":
        return _edlen_vapour(wavelengths, t, e)
    return np.asarray(-_IAG_VAPOUR * e / t)


def vapour_coefficients(model: str) -> list[float] | None:
    """Water vapour's dispersion as a polynomial in σ² (1/µm²), up to a factor; None: it has none."""
    return {"ciddor": list(_VAPOUR), "edlen": [1e-6 * c for c in _EDLEN_VAPOUR], "iag1999": None}[model]


def ciddor(
    wavelength: npt.ArrayLike,
    temperature: npt.ArrayLike = 288.15,
    pressure: npt.ArrayLike = 101325.0,
    humidity: npt.ArrayLike = 0.0,
    co2: float = 450.0,
) -> FloatArray:
    """n by P. E. Ciddor, Appl. Opt. 35, 1566 (1996): good to a few 1e-8 from 300 to 1690 nm, −40 to 100 °C.

    Parameters
    ----------
    wavelength : array_like
        nm, in vacuum.
    temperature, pressure : array_like
        K, Pa.
    humidity : array_like
        Fraction: 0.2 is 20 %.
    co2 : float
        ppm.

    Returns
    -------
    ndarray
    """
    return 1.0 + _of_humidity(wavelength, temperature, pressure, humidity, "ciddor", co2)


def edlen(
    wavelength: npt.ArrayLike,
    temperature: npt.ArrayLike = 288.15,
    pressure: npt.ArrayLike = 101325.0,
    humidity: npt.ArrayLike = 0.0,
) -> FloatArray:
    """n by Edlén's equation as K. P. Birch and M. J. Downs modified it, Metrologia 30, 155 (1993), 31, 315 (1994)."""
    return 1.0 + _of_humidity(wavelength, temperature, pressure, humidity, "edlen", 450.0)


def iag1999(
    wavelength: npt.ArrayLike,
    temperature: npt.ArrayLike = 288.15,
    pressure: npt.ArrayLike = 101325.0,
    humidity: npt.ArrayLike = 0.0,
) -> FloatArray:
    """n of Hohenkerk and Sinclair's code with the dispersion of IAG 1999: 287.6155 + 1.62887/λ² + 0.01360/λ⁴."""
    return 1.0 + _of_humidity(wavelength, temperature, pressure, humidity, "iag1999", 450.0)


def king_factor(wavelength: npt.ArrayLike, co2: float = 450.0) -> FloatArray:
    """King factor (6 + 3ρ)/(6 − 7ρ) of dry air: what depolarisation ρ adds to Rayleigh scattering.

    By volume over N₂, O₂, Ar and CO₂: D. R. Bates, Planet. Space Sci. 32, 785 (1984), in the form of B. A. Bodhaine et
    al., J. Atmos. Oceanic Technol. 16, 1854 (1999), eqs. 5, 6 and 23.
    """
    k = 1e6 / as_array(wavelength, "wavelength") ** 2
    nitrogen = 1.034 + 3.17e-4 * k
    oxygen = 1.096 + 1.385e-3 * k + 1.448e-4 * k * k
    percent = 1e-4 * co2
    return (78.084 * nitrogen + 20.946 * oxygen + 0.934 + 1.15 * percent) / (78.084 + 20.946 + 0.934 + percent)


def rayleigh_cross_section(wavelength: npt.ArrayLike, co2: float = 450.0) -> FloatArray:
    """Scattering cross-section of an average molecule of dry air.

    σ = 24π³/(λ⁴ N²) ((n² − 1)/(n² + 2))² F, with n and the number density N both of standard air, 15 °C and 101325 Pa
    (the result depends on neither), n by Ciddor and F by :func:`king_factor`.

    Parameters
    ----------
    wavelength : array_like
        nm.
    co2 : float
        ppm.

    Returns
    -------
    ndarray
        m².
    """
    metres = 1e-9 * as_array(wavelength, "wavelength")
    square = (1.0 + refractivity(wavelength, 288.15, 101325.0, 0.0, "ciddor", co2)) ** 2
    density = 101325.0 / (_BOLTZMANN * 288.15)
    lorenz = (square - 1.0) / (square + 2.0)
    return 24.0 * np.pi**3 / (metres**4 * density**2) * lorenz**2 * king_factor(wavelength, co2)


def rayleigh_extinction(wavelength: npt.ArrayLike, co2: float = 450.0) -> FloatArray:
    """Extinction by Rayleigh scattering over refractivity n − 1, both at the wavelength and of any density of dry air.

    Both are proportional to the number of molecules, so that the optical depth of a path is this times ∫ (n − 1) ds along
    it.

    Parameters
    ----------
    wavelength : array_like
        nm.
    co2 : float
        ppm.

    Returns
    -------
    ndarray
        1/m.
    """
    density = 101325.0 / (_BOLTZMANN * 288.15)
    standard = refractivity(wavelength, 288.15, 101325.0, 0.0, "ciddor", co2)
    return np.asarray(rayleigh_cross_section(wavelength, co2) * density / standard)


def gas_coefficients(
    model: str, temperature: float, pressure: float, vapour: float, co2: float = 450.0
) -> tuple[list[float], list[float], list[float]]:
    """The refractivity of one state of air as Σ B/(C − σ²) + polynomial in σ²: (B, C, polynomial), σ in 1/µm.

    The form of :class:`cpm.dispersion.Gas`.
    """
    t, p, e = temperature, pressure, vapour
    state = (np.asarray(t), np.asarray(p), np.asarray(e))
    if model == "ciddor":
        dry, wet = map(float, _ciddor_densities(*state, co2))
        return list(dry * _co2_factor(co2) * _DRY_STRENGTHS), list(_DRY_POLES), list(wet * _VAPOUR)
    if model == "edlen":
        density, vapour_term = float(_edlen_density(*state[:2])), 292.75 / t * 1e-10 * e
        return (
            [density * 2406147e-8, density * 15998e-8],
            [130.0, 38.9],
            [density * 8342.54e-8 - _EDLEN_VAPOUR[0] * vapour_term, -_EDLEN_VAPOUR[1] * vapour_term],
        )
    one_of(model, "model", MODELS)
    density = 273.15 / 101325.0 * p / t
    return [], [], [287.6155e-6 * density - _IAG_VAPOUR * e / t, 1.62887e-6 * density, 0.01360e-6 * density]


def _of_humidity(wavelength: Any, temperature: Any, pressure: Any, humidity: Any, model: str, co2: float) -> FloatArray:
    t, p, h = as_array(temperature, "temperature"), as_array(pressure, "pressure"), as_array(humidity, "humidity")
    check_state(t, p, h)
    return refractivity(wavelength, t, p, vapour_pressure(t, p, h), model, co2)


def check_state(temperature: FloatArray, pressure: FloatArray, humidity: FloatArray) -> None:
    """Refuses °C, percent, and what is not a number, by the first bad index."""
    for values, name, low, high, unit, hint in (
        (temperature, "temperature", 100.0, 500.0, " K", "; is it in °C?"),
        (pressure, "pressure", 0.0, 2e6, " Pa", ""),
        (humidity, "humidity", 0.0, 1.5, "", "; a fraction, 1 is saturated: is it in percent?"),
    ):
        flat = np.atleast_1d(values).ravel()
        bad = np.flatnonzero(~((flat >= low) & (flat <= high)))
        if bad.size:
            where = f"[{bad[0]}]" if np.ndim(values) else ""
            raise ValueError(f"{name}{where} is {flat[bad[0]]:g}{unit}; {low:g} to {high:g} are allowed{hint}")


def _check_wavelengths(wavelengths: FloatArray, model: str) -> None:
    low, high = RANGES[model]
    flat = np.atleast_1d(wavelengths).ravel()
    bad = np.flatnonzero(~((flat >= low) & (flat <= high)))
    if bad.size:
        where = f"[{bad[0]}]" if np.ndim(wavelengths) else ""
        raise ValueError(
            f"wavelength{where} is {flat[bad[0]]:g} nm; {low:g} to {high:g} nm are allowed for air by {model}"
        )


def _wavenumber_squared(wavelengths: FloatArray) -> FloatArray:
    return np.asarray(1e6 / wavelengths**2)


def _dry(wavelengths: FloatArray) -> FloatArray:
    return np.asarray(np.sum(_DRY_STRENGTHS / (_DRY_POLES - _wavenumber_squared(wavelengths)[..., None]), axis=-1))


def _wet(wavelengths: FloatArray) -> FloatArray:
    k = _wavenumber_squared(wavelengths)
    return np.asarray(_VAPOUR[0] + k * (_VAPOUR[1] + k * (_VAPOUR[2] + k * _VAPOUR[3])))


def _co2_factor(co2: float) -> float:
    return 1.0 + 0.534e-6 * (co2 - 450.0)


def _ciddor_densities(t: FloatArray, p: FloatArray, e: FloatArray, co2: float) -> tuple[FloatArray, FloatArray]:
    """(ρ_a/ρ_axs, ρ_w/ρ_ws): density over that at which each component's dispersion was measured."""
    molar = 1e-3 * (28.9635 + 12.011e-6 * (co2 - 400.0))
    x = np.divide(
        e, p, out=np.zeros(np.broadcast(e, p, t).shape), where=np.broadcast_to(p > 0, np.broadcast(e, p, t).shape)
    )
    moles = p / (_compressibility(t, p, x) * _GAS_CONSTANT * t)
    standard_dry = 101325.0 * molar / (_compressibility(288.15, 101325.0, 0.0) * _GAS_CONSTANT * 288.15)
    standard_wet = 1333.0 * _MOLAR_VAPOUR / (_compressibility(293.15, 1333.0, 1.0) * _GAS_CONSTANT * 293.15)
    return moles * (1.0 - x) * molar / standard_dry, moles * x * _MOLAR_VAPOUR / standard_wet


def _compressibility(temperature: Any, pressure: Any, x: Any) -> Any:
    """Z of moist air with molar fraction x of vapour (BIPM 1981/91; Ciddor, eq. 12)."""
    t, ratio = temperature - 273.15, pressure / temperature
    first = (
        1.58123e-6
        + t * (-2.9331e-8 + 1.1043e-10 * t)
        + x * (5.707e-6 - 2.051e-8 * t)
        + x * x * (1.9898e-4 - 2.376e-6 * t)
    )
    return 1.0 + ratio * (-first + ratio * (1.83e-11 - 0.765e-8 * x * x))


def _edlen_density(t: FloatArray, p: FloatArray) -> FloatArray:
    celsius = t - 273.15
    return p * (1.0 + 1e-8 * (0.601 - 0.00972 * celsius) * p) / (96095.43 * (1.0 + 0.0036610 * celsius))


def _edlen(wavelengths: FloatArray, t: FloatArray, p: FloatArray, e: FloatArray) -> FloatArray:
    k = _wavenumber_squared(wavelengths)
    standard = 1e-8 * (8342.54 + 2406147.0 / (130.0 - k) + 15998.0 / (38.9 - k))
    return np.asarray(standard * _edlen_density(t, p) + _edlen_vapour(wavelengths, t, e))


def _edlen_vapour(wavelengths: FloatArray, t: FloatArray, e: FloatArray) -> FloatArray:
    k = _wavenumber_squared(wavelengths)
    return np.asarray(-292.75 / t * 1e-10 * e * (_EDLEN_VAPOUR[0] + _EDLEN_VAPOUR[1] * k))


def _iag1999(wavelengths: FloatArray, t: FloatArray, p: FloatArray, e: FloatArray) -> FloatArray:
    k = _wavenumber_squared(wavelengths)
    dry = 1e-6 * (287.6155 + k * (1.62887 + k * 0.01360)) * (273.15 / 101325.0)
    return np.asarray((dry * p - _IAG_VAPOUR * e) / t)
