"""Curved rays by SciPy's DOP853 at rtol 1e-12: the independent integrator.

State (8,): r, p, arc length l, optical path L, over σ (DESIGN section 1):

    dr/dσ = p,   dp/dσ = ½∇(n²),   dl/dσ = n,   dL/dσ = n².

The end (an arc length, or a plane) is bracketed by an event of `solve_ivp` and then polished
by Newton steps that are themselves integrated, since dense output is of lower order than the steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .fields import vector

RTOL, ATOL = 1e-12, 1e-14


@dataclass(frozen=True)
class Ray:
    """Where a ray ends: position, momentum, unit direction (3,), metres of arc, optical path, σ."""

    position: np.ndarray
    momentum: np.ndarray
    arc_length: float
    optical_path: float
    sigma: float = np.nan

    @property
    def direction(self):
        return self.momentum / np.linalg.norm(self.momentum)


def start_state(medium, origin, direction):
    """(8,) state with |p| = n at the start; `direction` need not be unit."""
    origin, direction = vector(origin), vector(direction)
    n = np.sqrt(medium(origin)[0])
    return np.concatenate([origin, n * direction / np.linalg.norm(direction), [0.0, 0.0]])


def _slope(medium):
    def slope(_sigma, y):
        n_squared, half_gradient = medium(y[:3])
        return np.concatenate([y[3:6], half_gradient, [np.sqrt(max(n_squared, 0.0)), n_squared]])

    return slope


def _advance(medium, y, sigma, max_step=np.inf):
    """State after a further `sigma` (either sign)."""
    if sigma == 0.0:
        return y
    s = solve_ivp(_slope(medium), (0.0, sigma), y, "DOP853", rtol=RTOL, atol=ATOL, max_step=max_step)
    assert s.success, s.message
    return s.y[:, -1]


def trace(medium, origin, direction, *, length=None, until=None, sigma_max=None) -> Ray:
    """Follow one ray until `length` metres of arc, or the plane `until` = (point, normal).

    Parameters
    ----------
    medium : callable
        A field of `fields` or `splines`.
    origin, direction : (3,)
    length : float, optional
        Metres of arc.
    until : ((3,), (3,)), optional
        Point and normal of a plane; crossed in either sense, the start excluded.
    sigma_max : float, optional
        Where to give up; default 50 (length + 1).

    Raises
    ------
    LookupError
        The plane is not reached.
    """
    if (length is None) == (until is None):
        raise TypeError("exactly one of length and until")
    y = start_state(medium, origin, direction)
    if until is None:

        def gap(y):
            return y[6] - length

        def gap_slope(y):
            return np.sqrt(medium(y[:3])[0])
    else:
        point, normal = vector(until[0]), vector(until[1])

        def gap(y):
            return normal @ (y[:3] - point)

        def gap_slope(y):
            return normal @ y[3:6]

    if length == 0.0:
        return Ray(y[:3], y[3:6], 0.0, 0.0, 0.0)

    def event(_sigma, y):
        return gap(y)

    event.terminal = True
    step = medium.max_step / np.sqrt(medium(y[:3])[0]) if np.isfinite(medium.max_step) else np.inf
    sigma_max = sigma_max or 50.0 * ((length or 0.0) + 1.0)
    s = solve_ivp(_slope(medium), (0.0, sigma_max), y, "DOP853", rtol=RTOL, atol=ATOL, max_step=step, events=event)
    if not len(s.t_events[0]):
        raise LookupError("the end was not reached")
    # Restart from the last accepted step before the event: no dense output in the answer.
    last = np.searchsorted(s.t, s.t_events[0][0]) - 1
    last = max(last, 0)
    sigma = s.t_events[0][0]
    y = _advance(medium, s.y[:, last], sigma - s.t[last], step)
    for _ in range(3):
        correction = -gap(y) / gap_slope(y)
        y = _advance(medium, y, correction)
        sigma += correction
    return Ray(y[:3], y[3:6], y[6], y[7], sigma)


def trace_many(medium, origins, directions, **end):
    """`trace` for each row; arrays position, momentum, direction (N, 3), arc_length, optical_path (N,)."""
    length, until = end.get("length"), end.get("until")
    lengths = np.broadcast_to(length, len(origins)) if until is None else [None] * len(origins)
    rays = [
        trace(medium, o, d, length=None if ln is None else float(ln), until=until)
        for o, d, ln in zip(origins, directions, lengths, strict=True)
    ]
    return stack(rays)


@dataclass(frozen=True)
class Rays:
    """Arrays over rays, named as `cpm.trace` names them."""

    position: np.ndarray
    momentum: np.ndarray
    direction: np.ndarray
    arc_length: np.ndarray
    optical_path: np.ndarray


def stack(rays) -> Rays:
    """Rays from a list of `Ray`."""
    return Rays(
        *(
            np.array([getattr(r, k) for r in rays])
            for k in ("position", "momentum", "direction", "arc_length", "optical_path")
        )
    )


def sample_by_arc(medium, origin, direction, lengths):
    """Positions (K, 3) at the arc lengths `lengths` (K,), by the ray equation in arc length.

    d/dl (n dr/dl) = ∇n (Gutierrez et al., eq. 2.4): a second formulation, which checks `trace`.
    """
    y = start_state(medium, origin, direction)[:6]

    def slope(_l, y):
        n_squared, half_gradient = medium(y[:3])
        n = np.sqrt(n_squared)
        return np.concatenate([y[3:6] / n, half_gradient / n])

    out, at = np.empty((len(lengths), 3)), 0.0
    for i, goal in enumerate(lengths):
        if goal > at:
            s = solve_ivp(slope, (at, goal), y, "DOP853", rtol=RTOL, atol=ATOL, max_step=medium.max_step)
            y, at = s.y[:, -1], goal
        out[i] = y[:3]
    return out
