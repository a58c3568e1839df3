"""Names of what the core reports in numbers: how rays end, which method ran, what a scene needs."""
from __future__ import annotations

from enum import IntEnum

from . import _core

__all__ = ["RayStatus"]


class RayStatus(IntEnum):
    """How a ray ended.

    Values 0–9 are ordinary ends, from 10 on the ray stopped before what was asked for. Its position is where it ended
    in every case.
    """

    ARRIVED = 0  #: at the length or the plane asked for
    HIT = 1  #: on a surface of the scene
    LEFT = 2  #: crossed the scene's extent outward
    EVALUATIONS_EXHAUSTED = 10  #: ``max_evaluations`` reached first
    STEP_UNDERFLOW = 11  #: no step meets the tolerance
    CUTOFF = 12  #: n fell below 1e-6 of its start
    CAPTURED = 13  #: fell into a singular centre


def method_code(name: object, argument: str = "method") -> int:
    """The core's number of an integrator."""
    if not isinstance(name, str) or name not in _core.METHODS:
        raise ValueError(f"{argument} is {name!r}; {', '.join(_core.METHODS)} are allowed")
    return _core.METHODS[name]


def exclusion_bits(exclude: object) -> int:
    """Methods that ``auto`` may not choose, as the core's bit mask."""
    names = (exclude,) if isinstance(exclude, str) else tuple(exclude)  # type: ignore[arg-type]
    return sum({1 << method_code(name, "exclude") for name in names})


def feature_names(bits: int) -> tuple[list[str], list[str]]:
    """Names of the features that a scene needs, and of those left out."""
    needed = [name for name, bit in _core.FEATURES.items() if bits & bit]
    return needed, [name for name in _core.FEATURES if name not in needed]


def require_double(precision: str) -> None:
    """Refuse what the photon and eye passes cannot do yet, on either backend."""
    if precision not in ("double", "single"):
        raise ValueError(f"precision is {precision!r}; double, single are allowed")
    if precision == "single":
        raise _core.Error("precision 'single' is for cpm.trace; photons and pictures are traced in double here")
