"""One thing that can be built in or left out, its cost, and how that is printed."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ._arrays import FloatArray

__all__ = ["Feature"]


@dataclass(frozen=True)
class Feature:
    """One thing that the core can build in or leave out.

    Attributes
    ----------
    name : str
    needed : bool
        Whether it is in.
    meaning : str
    counters : str
        What it did in the trial; where it is left out, the zeros that prove it.
    cost : float or None
        Seconds of the trial with it over seconds without, the median of several; None where that was not tried.
    spread : float or None
        Of those several: their median distance from the median.
    """

    name: str
    needed: bool
    meaning: str
    counters: str
    cost: float | None
    spread: float | None = None


def lines_of(features: Sequence[Feature], measured: bool) -> list[str]:
    """A table in two parts, what is in and what is left out."""
    named = max(len(feature.name) for feature in features)
    meant = max(len(feature.meaning) for feature in features)
    lines = []
    for title, needed in (("in", True), ("left out", False)):
        lines.append(f"\n{title}")
        chosen = [feature for feature in features if feature.needed is needed]
        for feature in chosen:
            cost = f"{_shown_cost(feature):<17}" if measured else ""
            lines.append(f"  {feature.name:<{named}}  {cost}{feature.meaning:<{meant}}  {feature.counters}".rstrip())
        if not chosen:
            lines.append("  nothing")
    return lines


def _shown_cost(feature: Feature) -> str:
    if feature.cost is None or feature.spread is None:
        return "-"
    return "~ 1" if abs(feature.cost - 1.0) <= feature.spread else f"× {feature.cost:.2f} ± {feature.spread:.2f}"


def middle(values: FloatArray) -> tuple[float, float]:
    """Median, and median distance from it."""
    median = float(np.median(values))
    return median, float(np.median(np.abs(values - median)))
