"""What a render is asked for: arguments, then the scene's own defaults, then the package's."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from . import _core
from ._arrays import FloatArray, as_array, as_integer, as_number, bin_centers
from .wavelengths import Bins

#: The core's bounds.
MAX_NEAREST, MAX_SAMPLES, MAX_BATCH, MAX_BUNDLE_TOLERANCE = 1_000_000, 1 << 20, 1 << 20, 100.0

__all__ = ["RenderSettings", "as_wavelengths", "resolve"]


@dataclass
class RenderSettings:
    """Defaults that a scene carries (a scene file's [render] table); None: the package's.

    Attributes
    ----------
    size : (width, height), default (400, 300)
    photons : int, default 3 000 000
        Paths emitted.
    nearest : int, default 150
    wavelengths : bin centres in nm, or Bins of :mod:`cpm.wavelengths`; default 16 bins of 400–700 nm
    samples : int, default 1
        Eye rays a pixel.
    seed : int, default 0
    max_radius : float, metres
    bundle_tolerance : float, default 0.1
        Pixels, and radii of an estimate: where a medium disperses, wavelengths nearer than that share one path.
    """

    size: Any = None
    photons: Any = None
    nearest: Any = None
    wavelengths: Any = None
    samples: Any = None
    seed: Any = None
    max_radius: Any = None
    bundle_tolerance: Any = None


@dataclass(frozen=True)
class Resolved:
    """Every setting, checked."""

    width: int
    height: int
    photons: int
    nearest: int
    wavelengths: FloatArray
    bins: Bins | None  # where they were given as such
    samples: int
    seed: int
    max_radius: float
    bundle_tolerance: float


_DEFAULTS = RenderSettings(size=(400, 300), photons=3_000_000, nearest=150, samples=1, seed=0, max_radius=0.0,
                           bundle_tolerance=0.1)


def as_wavelengths(value: Any) -> FloatArray:
    """Bin centres (nm) from an array, a number, Bins, or a mapping of ``from``, ``to`` and ``bins``."""
    if isinstance(value, Bins):
        return value.centers
    if value is None:
        return bin_centers(400.0, 700.0, 16)
    if isinstance(value, Mapping):
        unknown = set(value) ^ {"from", "to", "bins"}
        if unknown:
            raise ValueError(f"wavelengths has keys {sorted(value)}; from, to, bins are needed")
        return bin_centers(value["from"], value["to"], value["bins"])
    centers = np.atleast_1d(as_array(value, "wavelengths"))
    if centers.ndim != 1 or not 1 <= centers.size <= _core.MAX_BINS:
        raise ValueError(f"wavelengths has shape {centers.shape}; 1 to {_core.MAX_BINS} bin centres are needed")
    bad = np.flatnonzero(~(np.isfinite(centers) & (centers > 0)))
    if bad.size:
        raise ValueError(f"wavelengths[{bad[0]}] is {centers[bad[0]]} nm; finite and > 0 is needed")
    falls = np.flatnonzero(np.diff(centers) <= 0)
    if falls.size:
        i = int(falls[0]) + 1
        raise ValueError(f"wavelengths[{i}] is {centers[i]:g} nm after {centers[i - 1]:g}; they must increase strictly")
    return np.ascontiguousarray(centers)


def bins_of(value: Any) -> Bins | None:
    """Bins that were given as such; None: centres, with edges half-way between them."""
    return value if isinstance(value, Bins) else None


def _tolerance(value: Any) -> float:
    tolerance = as_number(value, "bundle_tolerance")
    if not 0 <= tolerance <= MAX_BUNDLE_TOLERANCE:
        raise ValueError(f"bundle_tolerance is {tolerance:g}; 0 to {MAX_BUNDLE_TOLERANCE:g} are allowed")
    return tolerance


def resolve(defaults: RenderSettings, **asked: Any) -> Resolved:
    """What to run: each argument that is not None, else the scene's default, else the package's."""
    unknown = set(asked) - {field.name for field in fields(RenderSettings)}
    assert not unknown, unknown
    values = {}
    for field in fields(RenderSettings):
        choices = (asked.get(field.name), getattr(defaults, field.name), getattr(_DEFAULTS, field.name))
        values[field.name] = next((choice for choice in choices if choice is not None), None)
    size: Any = values["size"]
    try:
        width, height = size
    except (TypeError, ValueError):
        raise ValueError(f"size is {size!r}; (width, height) is needed") from None
    return Resolved(
        width=as_integer(width, "size[0]", 1, 65536),
        height=as_integer(height, "size[1]", 1, 65536),
        photons=as_integer(values["photons"], "photons", 0, 2**32 - 1),
        nearest=as_integer(values["nearest"], "nearest", 2, MAX_NEAREST),
        wavelengths=as_wavelengths(values["wavelengths"]),
        bins=bins_of(values["wavelengths"]),
        samples=as_integer(values["samples"], "samples", 1, MAX_SAMPLES),
        seed=as_integer(values["seed"], "seed", 0, 2**64 - 1),
        max_radius=as_number(values["max_radius"], "max_radius"),
        bundle_tolerance=_tolerance(values["bundle_tolerance"]),
    )
