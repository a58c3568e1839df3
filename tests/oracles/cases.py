"""One ray case per medium of the first issue: how `cpm` makes it, its field, its rays.

A case holds the medium twice: `make(cpm)` and `field` (for DOP853), and, where there is one, the
closed form.  Reference ends are computed once a session and kept.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import central, closed_forms, fields, layers, rays, splines

DIRECTIONS = np.array([
    (1, 0.2, 0.1), (1, -0.3, 0), (0.4, 0.9, -0.3), (0.2, -0.8, 0.5), (-1, 0.05, 0.6), (0, 1, 0),
])  # fmt: skip


@dataclass(frozen=True, eq=False)
class Case:
    """A medium, rays in it, and what is known about them."""

    name: str
    make: Callable
    field: object
    origin: tuple
    length: float
    plane: tuple  # (point, normal), reached by `towards`
    towards: tuple
    closed: Callable | None = None  # (origin, direction, length=) -> Ray
    exact: bool = False  # "exact" must exist
    smooth: bool = True  # derivatives of n of every order: full order of the methods
    slack: float = 0.0  # metres by which table and oracle may differ

    def directions(self):
        """(N, 3), not unit on purpose."""
        return DIRECTIONS

    def origins(self):
        """(N, 3)."""
        return np.broadcast_to(np.array(self.origin, float), DIRECTIONS.shape).copy()

    @functools.cache  # noqa: B019  cases live as long as the session
    def ends(self):
        """Reference ends after `length`."""
        if self.closed is not None:
            return rays.stack([self.closed(self.origin, d, length=self.length) for d in DIRECTIONS])
        return rays.trace_many(self.field, self.origins(), DIRECTIONS, length=self.length)

    @functools.cache  # noqa: B019
    def plane_end(self):
        """Reference end of the ray along `towards` on `plane`."""
        return rays.trace(self.field, self.origin, self.towards, until=self.plane)


GRADIENT, BASE = (0.03, -0.10, 0.02), (0.1, 0.2, -0.3)


def _profile(h):
    """n(h) of the smooth layered case, flat at both ends of the table."""
    return 1.25 + 0.1 * np.tanh(h)


HEIGHTS = np.linspace(-12, 12, 2401)
COARSE = np.array([-3.0, -1.2, -0.5, 0.1, 0.7, 1.3, 3.0])
COARSE_N = np.array([1.20, 1.25, 1.22, 1.26, 1.30, 1.28, 1.31])
STEP_HEIGHTS = np.array([-2.0, -1.0, -0.2, 0.4, 1.1, 2.0])
STEP_N = np.array([1.35, 1.33, 1.30, 1.26, 1.20, 1.15])

#: Centres, strengths, exponents, directions: two that attract, one that repels, a line.
SOURCES = (
    ((0.1, -1.0, 0.4), (-1.2, 1.5, 0.3), (1.6, 0.2, -0.9), (0.0, 0.0, -1.5)),
    (0.2, 0.15, -0.1, 0.1),
    (2.0, 1.0, 3.0, 1.5),
    ((0, 0, 0), (0, 0, 0), (0, 0, 0), (1.0, 0.3, 0.0)),
)

GRID_SHAPE, GRID_ORIGIN, GRID_SPACING = (41, 49, 41), (-2.0, -2.4, -2.0), (0.1, 0.1, 0.1)
SMALL_SHAPE, SMALL_ORIGIN, SMALL_SPACING = (9, 11, 9), (-2.0, -2.5, -2.0), (0.5, 0.5, 0.5)


def bump(shape, origin, spacing):
    """A Gaussian bump sampled on a grid (nx, ny, nz), flat at the grid's edge."""
    x, y, z = np.meshgrid(
        *(o + s * np.arange(k) for o, s, k in zip(origin, spacing, shape, strict=True)), indexing="ij"
    )
    return 1.2 + 0.15 * np.exp(-(x**2 + 1.5 * y**2 + z**2 + 0.5 * x * y) / 0.4)


def _cases():
    g = bump(GRID_SHAPE, GRID_ORIGIN, GRID_SPACING)
    s = bump(SMALL_SHAPE, SMALL_ORIGIN, SMALL_SPACING)
    floor, up = ((0, -1, 0), (0, 1, 0)), (0, 1, 0)
    yield Case(
        "homogeneous",
        lambda cpm: cpm.media.Homogeneous(1.33),
        fields.Homogeneous(1.33),
        (0.5, 1, 0),
        7.0,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(closed_forms.homogeneous, 1.33),
        exact=True,
    )
    yield Case(
        "linear-squared",
        lambda cpm: cpm.media.LinearSquared(1.69, gradient=GRADIENT, origin=BASE),
        fields.LinearSquared(1.69, GRADIENT, BASE),
        (0.5, 1, 0),
        5.0,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(closed_forms.linear_squared, 1.69, GRADIENT, BASE),
        exact=True,
    )
    yield Case(
        "linear",
        lambda cpm: cpm.media.Linear(1.3, gradient=GRADIENT, origin=BASE),
        fields.Linear(1.3, GRADIENT, BASE),
        (0.5, 1, 0),
        5.0,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(closed_forms.linear, 1.3, GRADIENT, BASE),
        exact=True,
    )
    n2, slopes = COARSE_N**2, np.diff(COARSE_N**2) / np.diff(COARSE)

    def parabolas(h):
        i = int(np.clip(np.searchsorted(COARSE, h) - 1, 0, len(slopes) - 1))
        n = np.sqrt(n2[i] + slopes[i] * (h - COARSE[i]))
        return n, slopes[i] / (2 * n)

    yield Case(
        "layered-linear-squared",
        lambda cpm: cpm.media.Layered(COARSE, COARSE_N, up=up, interpolation="linear-squared"),
        fields.OfHeight(parabolas, max_step=0.005),
        (0.5, 0.3, 0),
        2.0,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(layers.linear_squared, COARSE, COARSE_N, up, (0, 0, 0)),
        exact=True,
        smooth=False,
    )
    yield Case(
        "layered-cubic",
        lambda cpm: cpm.media.Layered(HEIGHTS, _profile(HEIGHTS), up=up, interpolation="cubic"),
        splines.layered_cubic(HEIGHTS, _profile(HEIGHTS)),
        (0.5, 0.3, 0),
        4.0,
        floor,
        (0.4, -0.6, 0.1),
        smooth=False,
    )
    yield Case(
        "grid-linear",
        lambda cpm: cpm.media.Grid(s, origin=SMALL_ORIGIN, spacing=SMALL_SPACING, interpolation="linear"),
        splines.grid_linear(s, SMALL_ORIGIN, SMALL_SPACING),
        (0.1, 0.3, -0.05),
        1.0,
        ((0, -0.5, 0), up),
        (0.4, -0.6, 0.1),
        smooth=False,
    )
    yield Case(
        "grid-cubic",
        lambda cpm: cpm.media.Grid(g, origin=GRID_ORIGIN, spacing=GRID_SPACING, interpolation="cubic"),
        splines.grid_cubic(g, GRID_ORIGIN, GRID_SPACING),
        (0.1, 0.3, -0.05),
        1.2,
        ((0, -0.5, 0), up),
        (0.4, -0.6, 0.1),
        smooth=False,
    )
    fibre = 1.5, 0.15, (0.2, 0.3, 1.0), BASE
    yield Case(
        "parabolic",
        lambda cpm: cpm.media.Parabolic(1.5, 0.15, axis=fibre[2], origin=BASE),
        fields.Parabolic(*fibre),
        (0.5, 1, 0),
        5.0,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(central.parabolic, *fibre),
        exact=True,
    )
    yield Case(
        "luneburg",
        lambda cpm: cpm.media.Luneburg(5.0, center=BASE),
        fields.luneburg(5.0, BASE),
        (0.5, 1, 0),
        3.5,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(central.luneburg, 5.0, BASE),
        exact=True,
    )
    yield Case(
        "fisheye",
        lambda cpm: cpm.media.Fisheye(2.5, 1.6, center=BASE),
        fields.fisheye(2.5, 1.6, BASE),
        (0.5, 1, 0),
        4.0,
        floor,
        (0.4, -0.6, 0.1),
        functools.partial(central.fisheye, 2.5, 1.6, BASE),
        exact=True,
    )
    yield Case(
        "eaton",
        lambda cpm: cpm.media.Eaton(5.0, center=BASE),
        fields.eaton(5.0, BASE),
        (0.5, 1, 0),
        3.5,
        ((0, 0.4, 0), up),
        (0.4, -0.6, 0.1),
        functools.partial(central.eaton, 5.0, BASE),
        exact=True,
    )
    yield Case(
        "sources",
        lambda cpm: cpm.media.Sources(*SOURCES[:3], directions=SOURCES[3]),
        fields.Sources(*SOURCES),
        (0.5, 1, 0),
        2.5,
        floor,
        (0.4, -0.6, 0.1),
    )


CASES = {case.name: case for case in _cases()}
