"""Random media of every kind, sums of them too, each with its index written a second time in NumPy (Hypothesis).

A world is described in units of its own: a point r is q = (r − shift)/scale. `make(scale, shift)` is the library's
medium, `index(q)` the same n by formulas or SciPy, sharing nothing with it; NaN where the second form does not reach
(a grid's edge). What a ray in it conserves follows from its symmetry: about a centre, across layers, about an axis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from oracles import splines
from scipy.interpolate import CubicSpline

import cpm

media = cpm.media


@dataclass(frozen=True, eq=False)
class World:
    """A medium in units of its own; see above."""

    name: str
    make: Callable
    index: Callable  # q (3,) -> n
    symmetry: str    # "centre", "layers", "axis" or "none"
    centre: np.ndarray
    axis: np.ndarray
    smooth: bool     # derivatives of every order where rays go
    singular: bool   # n without bound somewhere
    bounded: bool    # n bounded from 0 everywhere: nothing can stop a ray
    stepped: bool    # discrete layers: exact only
    kinked: bool     # ∇n jumps somewhere
    formula: bool    # its constants are folded, and do not scale to the last bit

    def __repr__(self):
        return f"World({self.name}, centre={self.centre}, axis={self.axis})"

    def conserved(self, q, p):
        """What the symmetry keeps of momentum p (3,) at q (3,), and the length that errors in it are measured by."""
        if self.symmetry == "centre":
            return np.cross(q - self.centre, p), np.linalg.norm(q - self.centre)
        if self.symmetry == "layers":
            return p - (p @ self.axis) * self.axis, 1.0
        if self.symmetry == "axis":
            return (np.append(p @ self.axis, np.cross(q - self.centre, p) @ self.axis),
                    max(1.0, np.linalg.norm(np.cross(q - self.centre, self.axis))))
        return np.zeros(0), 1.0


@dataclass(frozen=True, eq=False)
class Term:
    """One medium of a world."""

    name: str
    make: Callable
    index: Callable
    smooth: bool = True
    singular: bool = False
    bounded: bool = True
    stepped: bool = False
    kinked: bool = False
    formula: bool = False


def numbers(low, high):
    """Floats of a range; none so small that its square has no digits."""
    return st.floats(low, high).map(lambda x: 0.0 if abs(x) < 1e-60 else x)


def vectors(size=1.0):
    return st.tuples(*[numbers(-size, size)] * 3).map(np.array)


#: Unit vectors along the axes, both ways.
COORDINATES = [np.eye(3)[k] * s for k in range(3) for s in (1, -1)]


def units():
    """Unit vectors, some along the axes."""
    free = vectors().filter(lambda v: np.linalg.norm(v) > 0.1).map(lambda v: v / np.linalg.norm(v))
    return st.one_of(st.sampled_from(COORDINATES), free)


# --- terms: a frame (centre, axis) is given, so that terms of a sum can share it ------------------------------------------


@st.composite
def linear_squared(draw, centre, axis):
    square, slope = draw(numbers(1.2, 3.0)), draw(numbers(-0.3, 0.3))
    return Term(f"n² = {square:.3g} + {slope:.3g} u",
                lambda s, t: media.LinearSquared(square, gradient=slope / s * axis, origin=t + s * centre),
                lambda q: np.sqrt(max(square + slope * (axis @ (q - centre)), 0.0)), bounded=False)


@st.composite
def linear(draw, centre, axis):
    n, slope = draw(numbers(1.2, 2.0)), draw(numbers(-0.2, 0.2))
    return Term(f"n = {n:.3g} + {slope:.3g} u",
                lambda s, t: media.Linear(n, gradient=slope / s * axis, origin=t + s * centre),
                lambda q: n + slope * (axis @ (q - centre)), bounded=False)


@st.composite
def table(draw, low, high):
    """Heights from low to high and an index at each."""
    n = np.array(draw(st.lists(numbers(1.05, 1.6), min_size=3, max_size=9)))
    gaps = np.array(draw(st.lists(numbers(0.3, 1.0), min_size=len(n) - 1, max_size=len(n) - 1)))
    heights = low + (high - low) * np.concatenate([[0.0], np.cumsum(gaps)]) / gaps.sum()
    return heights, n


def _of_table(heights, n, interpolation):
    """n(h) of a flat table, end values held."""
    if interpolation == "cubic":
        spline = CubicSpline(heights, n, bc_type="natural")
        return lambda h: float(spline(np.clip(h, heights[0], heights[-1])))
    return lambda h: float(np.sqrt(np.interp(h, heights, n**2)))


@st.composite
def layered(draw, centre, axis, interpolations=("cubic", "linear-squared")):
    heights, n = draw(table(-2.0, 2.0))
    interpolation = draw(st.sampled_from(interpolations))
    profile = _of_table(heights, n, interpolation)
    return Term(f"{interpolation} layers {heights.round(2)} {n.round(3)}",
                lambda s, t: media.Layered(s * heights, n, up=axis, origin=t + s * centre, interpolation=interpolation),
                lambda q: profile(axis @ (q - centre)), smooth=False, kinked=interpolation != "cubic")


@st.composite
def steps(draw, centre, axis):
    heights, n = draw(table(-2.0, 2.0))

    def index(q):
        h = axis @ (q - centre)
        return np.nan if np.min(np.abs(heights - h)) < 1e-6 else float(n[max(np.searchsorted(heights, h) - 1, 0)])

    return Term(f"discrete layers {heights.round(2)} {n.round(3)}",
                lambda s, t: media.Layered(s * heights, n, up=axis, origin=t + s * centre, interpolation="step"), index,
                smooth=False, stepped=True)


@st.composite
def shells(draw, centre, axis, interpolations=("cubic", "linear-squared")):
    heights, n = draw(table(-0.7, 1.5))
    interpolation = draw(st.sampled_from(interpolations))
    if interpolation == "cubic":
        profile = _of_table(heights, n, "cubic")
    else:
        profile = lambda h: float(np.sqrt(np.interp((1 + h) ** 2, (1 + heights) ** 2, n**2)))  # noqa: E731
    return Term(f"{interpolation} shells {heights.round(2)} {n.round(3)}",
                lambda s, t: media.Layered(s * heights, n, up=axis, origin=t + s * (centre + axis), radius=s,
                                           interpolation=interpolation),
                lambda q: profile(np.linalg.norm(q - centre) - 1), smooth=False, kinked=interpolation != "cubic")


def _rho(q, centre, axis):
    return np.linalg.norm(np.cross(q - centre, axis))


@st.composite
def parabolic(draw, centre, axis):
    n, alpha = draw(numbers(1.2, 1.8)), draw(numbers(0.02, 0.25))
    return Term(f"fibre n = {n:.3g}, alpha = {alpha:.3g}",
                lambda s, t: media.Parabolic(n, alpha / s, axis=axis, origin=t + s * centre),
                lambda q: n * np.sqrt(max(1 - (alpha * _rho(q, centre, axis)) ** 2, 0.0)), bounded=False)


@st.composite
def luneburg(draw, centre, _axis):
    radius = draw(numbers(0.5, 3.0))
    return Term(f"Luneburg R = {radius:.3g}", lambda s, t: media.Luneburg(s * radius, t + s * centre),
                lambda q: np.sqrt(2 - min(np.linalg.norm(q - centre) / radius, 1.0) ** 2), smooth=False, kinked=True)


@st.composite
def eaton(draw, centre, _axis):
    radius = draw(numbers(0.5, 3.0))
    return Term(f"Eaton R = {radius:.3g}", lambda s, t: media.Eaton(s * radius, t + s * centre),
                lambda q: np.sqrt(2 / min(np.linalg.norm(q - centre) / radius, 1.0) - 1), smooth=False, singular=True,
                kinked=True)


@st.composite
def fisheye(draw, centre, _axis):
    n, radius = draw(numbers(1.2, 2.5)), draw(numbers(1.0, 4.0))
    return Term(f"fish-eye n = {n:.3g}, a = {radius:.3g}", lambda s, t: media.Fisheye(n, s * radius, t + s * centre),
                lambda q: n / (1 + (np.linalg.norm(q - centre) / radius) ** 2), bounded=False)  # falls to 0 with r


@st.composite
def point(draw, centre, _axis):
    strength, power = draw(numbers(0.01, 0.4)), draw(st.sampled_from([1, 2, 3]))
    return Term(f"point {strength:.3g}/r^{power}",
                lambda s, t: media.Sources([t + s * centre], [strength * s**power], power),
                lambda q: 1 + strength / np.linalg.norm(q - centre) ** power, singular=True)


@st.composite
def line(draw, centre, axis):
    strength, power = draw(numbers(0.01, 0.4)), draw(st.sampled_from([1, 2, 3]))
    return Term(f"line {strength:.3g}/rho^{power}",
                lambda s, t: media.Sources([t + s * centre], [strength * s**power], power, directions=[axis]),
                lambda q: 1 + strength / _rho(q, centre, axis) ** power, singular=True)


def _blob(n, height, width, s, centre):
    return media.Expression("n + a*exp(-((x-cx)**2 + (y-cy)**2 + (z-cz)**2)/w**2)", n=n, a=height, w=width * s,
                            cx=centre[0], cy=centre[1], cz=centre[2])


@st.composite
def blob(draw, centre, _axis):
    n, height, width = draw(numbers(1.1, 1.5)), draw(numbers(-0.09, 0.4)), draw(numbers(0.3, 2.0))
    return Term(f"blob {n:.3g} + {height:.3g} exp(−(r/{width:.3g})²)",
                lambda s, t: _blob(n, height, width, s, t + s * centre),
                lambda q: n + height * np.exp(-np.sum((q - centre) ** 2) / width**2), formula=True)


def _wall(n, rise, width, s, centre, axis):
    return media.Expression("n + a*tanh((ux*(x-cx) + uy*(y-cy) + uz*(z-cz))/w)", n=n, a=rise, w=width * s, ux=axis[0],
                            uy=axis[1], uz=axis[2], cx=centre[0], cy=centre[1], cz=centre[2])


@st.composite
def wall(draw, centre, axis):
    n, rise, width = draw(numbers(1.3, 1.5)), draw(numbers(-0.25, 0.25)), draw(numbers(0.2, 2.0))
    return Term(f"wall {n:.3g} + {rise:.3g} tanh(u/{width:.3g})",
                lambda s, t: _wall(n, rise, width, s, t + s * centre, axis),
                lambda q: n + rise * np.tanh(axis @ (q - centre) / width), formula=True)


@st.composite
def grid(draw, centre, _axis):
    shape = tuple(draw(st.lists(st.integers(4, 7), min_size=3, max_size=3)))
    values = 1.3 + 0.3 * np.random.default_rng(draw(st.integers(0, 2**32 - 1))).uniform(-1, 1, shape)
    interpolation, spacing = draw(st.sampled_from(["cubic", "linear"])), draw(numbers(0.4, 1.0))
    low = centre - 0.5 * spacing * (np.array(shape) - 1)
    field = (splines.grid_cubic if interpolation == "cubic" else splines.grid_linear)(values, low, (spacing,) * 3)
    margin = 2.0 if interpolation == "cubic" else 0.0

    def index(q):
        cell = (q - low) / spacing
        inside = np.all(cell > margin) and np.all(cell < np.array(shape) - 1 - margin)
        # Mirrored ends of one library are not another's: nearer the edge than this grid reaches they show.
        return float(np.sqrt(field(q)[0])) if inside and interpolation == "linear" else np.nan

    return Term(f"{interpolation} grid {shape}",
                lambda s, t: media.Grid(values, origin=t + s * low, spacing=(s * spacing,) * 3,
                                        interpolation=interpolation), index, smooth=False, kinked=True)


_OF = {"centre": (fisheye, point, blob, shells, luneburg, eaton),
       "layers": (linear_squared, linear, layered, wall, steps),
       "axis": (parabolic, line)}
_SUMMABLE = {"centre": (fisheye, point, blob, shells), "layers": (linear_squared, linear, layered, wall),
             "axis": (parabolic, line)}
_ANY = (*_OF["centre"], *_OF["layers"], *_OF["axis"], grid)
_ANY_SUMMABLE = (*_SUMMABLE["centre"], *_SUMMABLE["layers"], *_SUMMABLE["axis"], grid)


def _placed(draw, kind):
    """A term with a centre and an axis of its own, which its name tells."""
    centre, axis = draw(vectors()), draw(units())
    term = draw(kind(centre, axis))
    return replace(term, name=f"{term.name} at {tuple(centre.tolist())} along {tuple(axis.tolist())}")


@st.composite
def worlds(draw, symmetries=("centre", "layers", "axis", "none"), axes=None):
    """A medium alone, or the sum of two or three."""
    symmetry = draw(st.sampled_from(symmetries))
    centre, axis = draw(vectors()), draw(units() if axes is None else axes)
    count = draw(st.sampled_from([1, 1, 2, 3]))
    if symmetry == "none":
        kinds = _ANY if count == 1 else _ANY_SUMMABLE
        terms = [_placed(draw, draw(st.sampled_from(kinds))) for _ in range(count)]
    else:
        kinds = (_OF if count == 1 else _SUMMABLE)[symmetry]
        terms = [draw(draw(st.sampled_from(kinds))(centre, axis)) for _ in range(count)]

    def make(scale, shift):
        made = [term.make(scale, shift) for term in terms]
        return made[0] if count == 1 else sum(made[1:], made[0])

    return World(" + ".join(term.name for term in terms), make,
                 lambda q: 1.0 + sum(term.index(q) - 1.0 for term in terms), symmetry, centre, axis,
                 all(term.smooth for term in terms), any(term.singular for term in terms),
                 all(term.bounded for term in terms), any(term.stepped for term in terms), any(term.kinked for term in terms),
                 any(term.formula for term in terms))
