"""Which wavelengths to render: bins of equal width, of equal refraction, or of equal contribution.

    bins = cpm.wavelengths.by_refraction(profile, 400, 700, step=2 / 3600)   # neighbours 2″ apart at the horizon
    image = cpm.render(scene, wavelengths=bins)                               # image.edges are the bins' own

What a medium does with wavelengths is uneven: from 400 to 450 nm air's refraction at the horizon changes by 17″, from
650 to 700 nm by 4″. Bins of equal width waste on the red what the violet lacks. A. T. Young (Green Flashes at Sunset,
aty.sdsu.edu) spaces simulations of green flashes so that refraction differs by 1 to 2″ between neighbours, at a
resolution of 10″.
"""
from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import colorimetry
from ._arrays import FloatArray, as_array, as_integer, as_number, one_of
from .atmosphere._profile import Profile
from .atmosphere._refraction import refraction
from .dispersion import Dispersion
from .lights import light_spectrum
from .media import Medium
from .spectra import SpectrumLike, as_spectrum

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["SAMPLINGS", "Bins", "by_contribution", "by_refraction", "equal"]

#: Of a scene file's ``wavelengths``.
SAMPLINGS = ("equal", "refraction", "contribution")

_GRID = 4097     # wavelengths at which weights are looked at
_COARSE = 129    # and functions that may be slow
_DEGREE = 8
_MOST_BINS = 256


class Bins:
    """Bins of wavelength that touch each other.

    Takes the place of an array of centres wherever wavelengths are asked for.

    Parameters
    ----------
    edges : array_like, shape (bins + 1,)
        nm, strictly increasing.
    centers : array_like, shape (bins,), optional
        Where each bin is rendered, nm, within it. Default: its middle.
    shape : callable, optional
        What spectra are like within a bin, up to a factor of each bin: a function of wavelengths (nm, an array), > 0 at
        the centres. An integral over a bin then takes the value at its centre times this shape over its own value there
        (importance sampling); a wide bin in which light falls by orders of magnitude is right all the same.

    Attributes
    ----------
    edges : ndarray, shape (bins + 1,)
    centers : ndarray, shape (bins,)
    shape : callable or None
    """

    def __init__(self, edges: npt.ArrayLike, centers: npt.ArrayLike | None = None,
                 shape: Callable[[FloatArray], FloatArray] | None = None) -> None:
        self.shape = shape
        self.edges = as_array(edges, "edges").copy()
        if self.edges.ndim != 1 or not 2 <= self.edges.size <= _MOST_BINS + 1:
            raise ValueError(f"edges has shape {self.edges.shape}; 2 to {_MOST_BINS + 1} edges are needed")
        if not (np.isfinite(self.edges).all() and self.edges[0] > 0 and np.all(np.diff(self.edges) > 0)):
            bad = int(np.argmax(~(np.diff(self.edges) > 0))) + 1
            raise ValueError(f"edges[{bad}] is {self.edges[bad]:g} nm after {self.edges[bad - 1]:g}; finite numbers "
                             "above 0 that increase strictly are needed")
        middles = 0.5 * (self.edges[1:] + self.edges[:-1])
        self.centers = middles if centers is None else as_array(centers, "centers").copy()
        if self.centers.shape != middles.shape:
            raise ValueError(f"centers has shape {self.centers.shape}; ({middles.size},) is needed")
        outside = np.flatnonzero(~((self.centers > self.edges[:-1]) & (self.centers < self.edges[1:])))
        if outside.size:
            i = int(outside[0])
            raise ValueError(f"centers[{i}] is {self.centers[i]:g} nm; it must be within its bin, {self.edges[i]:g} to "
                             f"{self.edges[i + 1]:g}")
        if shape is not None and not np.all(_values(shape, "shape", self.centers) > 0):
            raise ValueError("shape is not above 0 at every centre")
        self.edges.flags.writeable = self.centers.flags.writeable = False

    @property
    def widths(self) -> FloatArray:
        """(bins,), nm: what a bin's value per nm counts for in an integral."""
        return np.diff(self.edges)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self.centers, dtype=dtype)

    def __len__(self) -> int:
        return self.centers.size

    def __repr__(self) -> str:
        widths = self.widths
        return (f"Bins({len(self)} of {self.edges[0]:g}-{self.edges[-1]:g} nm, {widths.min():.3g} to "
                f"{widths.max():.3g} nm wide)")


def equal(low: float = 400.0, high: float = 700.0, bins: int = 16) -> Bins:
    """Bins of equal width.

    Parameters
    ----------
    low, high : float
        Ends of the range, nm.
    bins : int

    Returns
    -------
    Bins
    """
    low, high = _range(low, high)
    return Bins(np.linspace(low, high, as_integer(bins, "bins", 1, _MOST_BINS) + 1))


def by_refraction(what: Any, low: float = 400.0, high: float = 700.0, bins: int | None = None, *,
                  step: float | None = None, zenith: float = 90.0, height: float = 0.0,
                  point: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Bins:
    """Bins over each of which refraction changes by the same.

    Parameters
    ----------
    what : Profile, Medium, Dispersion or callable
        A profile of :mod:`cpm.atmosphere`: its refraction at ``zenith`` and ``height``, degrees. A dispersion: its n. A
        medium: n at ``point``. A callable of wavelengths (nm, an array): whatever it gives.
    low, high : float
        nm.
    bins : int, optional
        How many; default 16 unless ``step`` is given.
    step : float, optional
        Instead: no bin changes by more than this, in what ``what`` gives.
    zenith : float
        Apparent zenith distance, degrees.
    height : float
        Of the observer, metres.
    point : array_like, shape (3,)
        Metres.

    Returns
    -------
    Bins
        Rendered at their middles.
    """
    low, high = _range(low, high)
    value = _refraction_of(what, low, high, zenith, height, point)
    grid = np.linspace(low, high, _COARSE)
    total = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(value(grid))))])
    if not total[-1] > 0:
        raise ValueError(f"{what!r} does not disperse from {low:g} to {high:g} nm; bins of equal refraction need what "
                         "does")
    if step is not None:
        if bins is not None:
            raise ValueError(f"bins is {bins!r} and step is given too; one of them is allowed")
        if not as_number(step, "step") > 0:
            raise ValueError(f"step is {step:g}; it must be > 0")
        count = int(np.ceil(total[-1] / step * (1 - 1e-9)))
        if count > _MOST_BINS:
            raise ValueError(f"step is {step:g}, which takes {count} bins; {_MOST_BINS} are allowed")
    else:
        count = as_integer(16 if bins is None else bins, "bins", 1, _MOST_BINS)
    edges = _divided(grid, total, count)
    for _ in range(2):  # between the grid's wavelengths: total at the edges themselves
        finer = np.union1d(grid, edges)
        edges = _divided(finer, np.concatenate([[0.0], np.cumsum(np.abs(np.diff(value(finer))))]), count)
    return Bins(edges)


def by_contribution(low: float = 400.0, high: float = 700.0, bins: int = 16, *, illuminant: SpectrumLike = 1.0,
                    observer: Any = "xyz", transmission: Any = 1.0, spread: float = 0.1) -> Bins:
    """Bins each of which adds the same to what an observer sees: illuminant × observer × transmission.

    Parameters
    ----------
    low, high : float
        nm.
    bins : int
    illuminant : spectrum
        Of the light: anything that stands for a spectrum.
    observer : {"xyz", "y"} or spectrum
        The sum of the CIE 1931 colour matching functions, luminance alone, or a sensor's own.
    transmission : spectrum or callable
        Of what is between, as a fraction; a callable takes wavelengths (nm, an array).
    spread : float
        Part of the bins that is shared out evenly whatever they contribute, 0 to 1, so that none is too wide.

    Returns
    -------
    Bins
        Rendered where half of each bin's contribution lies on either side; their shape is illuminant × transmission.
    """
    low, high = _range(low, high)
    count = as_integer(bins, "bins", 1, _MOST_BINS)
    even = as_number(spread, "spread")
    if not 0 <= even <= 1:
        raise ValueError(f"spread is {even:g}; 0 to 1 is needed")
    grid = np.linspace(low, high, _GRID)
    lamp = as_spectrum(illuminant, "illuminant")

    def light(w: FloatArray) -> FloatArray:
        return lamp.at(w) * _values(transmission, "transmission", w)

    seen = light(grid) * _observer(observer, grid)
    bad = np.flatnonzero(~(np.isfinite(seen) & (seen >= 0)))
    if bad.size:
        raise ValueError(f"the contribution at {grid[bad[0]]:g} nm is {seen[bad[0]]:g}; it must be finite and >= 0")
    if not seen.sum() > 0:
        raise ValueError(f"nothing is seen from {low:g} to {high:g} nm: illuminant x observer x transmission is 0")
    weight = (1.0 - even) * seen / seen.mean() + even
    total = np.concatenate([[0.0], np.cumsum(0.5 * (weight[1:] + weight[:-1]))])
    halves = _divided(grid, total, 2 * count)
    return Bins(halves[::2], halves[1::2], light if np.all(light(halves[1::2]) > 0) else None)


def for_scene(scene: Scene, low: float, high: float, bins: int, sampling: str) -> Bins:
    """What a scene file's ``wavelengths`` asks for.

    "refraction": of the medium that fills the scene, else of the first in it that disperses. "contribution": of the
    scene's lights together.
    """
    one_of(sampling, "sampling", SAMPLINGS)
    if sampling == "equal":
        return equal(low, high, bins)
    if sampling == "refraction":
        return by_refraction(_dispersing(scene, low, high), low, high, bins)
    grid = np.linspace(*_range(low, high), _GRID)
    light = sum((light_spectrum(one).at(grid) for one in scene.lights), np.zeros(_GRID))
    return by_contribution(low, high, bins, illuminant=(grid, light) if light.any() else 1.0)


def _range(low: Any, high: Any) -> tuple[float, float]:
    low, high = as_number(low, "low"), as_number(high, "high")
    if not 0 < low < high:
        raise ValueError(f"wavelengths from {low:g} to {high:g} nm; 0 < low < high is needed")
    return low, high


def _divided(grid: FloatArray, total: FloatArray, count: int) -> FloatArray:
    """Where ``total`` has gone ``count`` equal parts of its way; strictly increasing."""
    places = np.interp(np.linspace(0.0, total[-1], count + 1), total, grid)
    places[0], places[-1] = grid[0], grid[-1]
    return places


def _refraction_of(what: Any, low: float, high: float, zenith: float, height: float,
                   point: npt.ArrayLike) -> Callable[[FloatArray], FloatArray]:
    if isinstance(what, Profile):
        # Air's refraction is a smooth function of 1/λ²: a polynomial through a few values is within 1e-6 of it.
        series = np.polynomial.Chebyshev.interpolate(
            lambda k: np.asarray(refraction(what, zenith, k**-0.5, height)), _DEGREE, domain=(high**-2, low**-2))
        return lambda w: np.asarray(series(w**-2.0))
    if isinstance(what, Dispersion):
        return lambda w: np.asarray(what.n(w))
    if isinstance(what, Medium):
        return lambda w: np.array([float(what.evaluate(point, one)[0][0]) for one in w])
    if callable(what):
        return lambda w: _values(what, "refraction", w)
    raise TypeError(f"refraction of {what!r}; a profile, a medium, a dispersion or a callable is needed")


def _values(given: Any, name: str, wavelengths: FloatArray) -> FloatArray:
    if not callable(given):
        return as_spectrum(given, name).at(wavelengths)
    found = as_array(given(wavelengths), name)
    if found.shape != wavelengths.shape:
        raise ValueError(f"{name} gave shape {found.shape} for {wavelengths.shape}; one number for each wavelength is "
                         "needed")
    bad = np.flatnonzero(~np.isfinite(found))
    if bad.size:
        raise ValueError(f"{name} is {found[bad[0]]} at {wavelengths[bad[0]]:g} nm; a finite number is needed")
    return found


def _observer(observer: Any, grid: FloatArray) -> FloatArray:
    if not isinstance(observer, str) or observer not in ("xyz", "y"):
        return as_spectrum(observer, "observer").at(grid)
    functions = colorimetry.matching_functions(grid)
    return functions[:, 1] if observer == "y" else functions.sum(axis=1)


def _dispersing(scene: Scene, low: float, high: float) -> Medium:
    origin = scene.camera.origin if scene.camera is not None else (0.0, 0.0, 0.0)
    for medium in (scene.medium, *scene.media, *(filling for _, filling in scene._fillings)):
        ends = [float(medium.evaluate(origin, w)[0][0]) for w in (low, high)]
        if ends[0] != ends[1]:
            return medium
    raise ValueError("sampling is 'refraction', but nothing in the scene disperses")
