"""Berger and Trout's discrete layers become the smooth profile as they are added, at the order that they must have.

Through all layers: order 2 with the index of a layer's middle, 1 with that of its lower face. Turned back: ½, for in
the layer where a ray turns it goes straight, at an angle as the root of what is left of n there, over a distance as the
thickness by that angle. Reference: SciPy's DOP853 at 1e-12 on the profile (`oracles.rays`), flat and spherical.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles import fields, rays, shells

import cpm

SURFACE, DEPTH, TOP = 0.3, 0.06, 1.0
COUNTS = 2 ** np.arange(7, 13)
START = 0.95  # where n changes by 1e-7 only: the layer's n is the profile's, and so is p


def profile(h):
    """n and dn/dh: denser with height, as over a hot road."""
    fall = SURFACE * np.exp(-h / DEPTH)
    return 1.4 - fall, fall / DEPTH


def layers(count, middle, radius):
    heights = TOP / count * np.arange(count)
    n, _ = profile(heights + (0.5 * TOP / count if middle else 0.0))
    return cpm.media.Layered(heights, n, interpolation="step", radius=radius)


def field(radius):
    if radius is None:
        return fields.OfHeight(profile)
    return shells.OfHeight(lambda h: (profile(h)[0] - 1, profile(h)[1]), radius)


def errors(radius, directions, lengths, middle):
    """Median over the rays of the end's error, for each count."""
    origin = (0.0, START, 0.0)
    smooth = rays.trace_many(field(radius), [origin] * len(directions), directions, length=lengths)
    found = []
    for count in COUNTS:
        ends = cpm.trace(layers(int(count), middle, radius), [origin] * len(directions), directions, wavelength=550.0,
                         length=lengths)
        assert np.all(ends.status == cpm.RayStatus.ARRIVED)
        found.append(np.median(np.linalg.norm(ends.position - smooth.position, axis=1)))
    return np.array(found)


def order(found):
    return -np.polyfit(np.log(COUNTS), np.log(found), 1)[0]


@pytest.mark.parametrize("radius", [None, 10.0])
@pytest.mark.parametrize(("middle", "expected"), [(True, 2.0), (False, 1.0)])
def test_through_all_layers(radius, middle, expected):
    """Rays steep enough to go down to h = 0.025, not quite at a face."""
    slopes = np.linspace(0.9, 2.0, 15)
    directions = np.column_stack([np.ones(15), -slopes, 0.1 * slopes])
    lengths = 0.925 * np.linalg.norm(directions, axis=1) / slopes * (0.99 if radius else 1.0)
    found = errors(radius, directions, lengths, middle)
    assert order(found) == pytest.approx(expected, abs=0.2), found
    assert found[-1] < (1e-5 if middle else 1e-3)


@pytest.mark.parametrize("radius", [None, 10.0])
@pytest.mark.parametrize("middle", [True, False])
def test_turned_back(radius, middle):
    """Rays that turn around h = 0.03 to 0.1 and come up again: they converge, slowly."""
    slopes = np.linspace(0.35, 0.6, 41)
    directions = np.column_stack([np.ones(41), -slopes, np.zeros(41)])
    found = errors(radius, directions, np.full(41, 3.5), middle)
    assert 0.3 < order(found) < 0.8, found
    assert found[-1] < 0.45 * found[0]
