"""Heights between which a profile's refractivity is as smooth as a polynomial."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._arrays import FloatArray
from ._profile import Profile

_MOST = 200_000


def breaks(profile: Profile, low: float, high: float) -> FloatArray:
    """The ends, the kinks and the features of a profile between two heights, ascending."""
    inside = [h for h in profile._kinks() + profile._features() if low < h < high]
    heights = np.unique(np.array([low, *inside, high]))
    apart = np.concatenate([[True], np.diff(heights) > 1e-6])  # kinks computed twice, off by rounding
    apart[-1] = True
    return heights[apart]


def sample(
    function: Callable[[FloatArray], FloatArray],
    starts: FloatArray,
    tolerance: Callable[[FloatArray], FloatArray],
    widest: float = 2000.0,
) -> FloatArray:
    """Splits the intervals between ``starts`` until a cubic would do.

    The error of a cubic spline is d⁴ f''''/384 (Hall and Meyer 1976), so ⅔ of the fourth difference of five points.

    Parameters
    ----------
    function : callable
        Smooth between the starts; vectorised.
    starts : ndarray
        Ascending; all are kept.
    tolerance : callable
        Of the function's values.
    widest : float
        No interval is wider, metres.
    """
    done: list[FloatArray] = [starts]
    count = np.maximum(1, np.ceil(np.diff(starts) / widest)).astype(int)
    edges = np.concatenate(
        [a + (b - a) * np.arange(n) / n for a, b, n in zip(starts[:-1], starts[1:], count, strict=True)]
    )
    low, high = edges, np.concatenate([edges[1:], starts[-1:]])
    done.append(low)
    total = low.size
    while low.size and total < _MOST:
        points = low[:, None] + (high - low)[:, None] * np.array([0.0, 0.25, 0.5, 0.75, 1.0])
        # A kink at an end belongs to the neighbour: look a hair inside.
        values = function(points)
        rough = np.abs(values @ np.array([1.0, -4.0, 6.0, -4.0, 1.0])) * (2.0 / 3.0)
        # Rounding of 1e-16 in the fourth difference of n - 1, and of the heights, is no roughness.
        split = (rough > tolerance(values[:, 2])) & (high - low > 1e-7 * (1.0 + np.abs(high)))
        middle = points[split, 2]
        done.append(middle)
        total += middle.size
        low, high = np.concatenate([low[split], middle]), np.concatenate([middle, high[split]])
    return np.unique(np.concatenate(done))
