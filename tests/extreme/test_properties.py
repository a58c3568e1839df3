"""What must hold of any ray in any medium, whatever the start, direction, tolerance and scale (DESIGN section 13).

Media of every kind, sums and bounds (`support.worlds`), scales of 1e-9 to 1e9 m, rtol 1e-2 to 1e-12. Oracles: n from
formulas of NumPy and SciPy, what symmetry conserves (Bouguer's n r sin φ, n sin θ), reversal, Simpson's rule for the
optical path, scaling and moving of the whole world. A few hundred examples with `make test`, 1e5 with `make test-long`;
`CPM_PROPERTY_SEED` chooses others than the usual ones.
"""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, reject, seed, settings
from hypothesis import strategies as st
from support.worlds import COORDINATES, numbers, units, vectors, worlds

import cpm

SEED = int(os.environ.get("CPM_PROPERTY_SEED", "3"))
ADAPTIVE = ("auto", "nystrom", "dopri5", "adams", "euler")
FIXED = ("rk4", "leapfrog", "yoshida6")
STATUSES = {int(status) for status in cpm.RayStatus}
#: What a ray may be off by in all, in units of what was asked for: errors are estimated, and estimates lag behind.
SLACK = 30.0
ROUNDING = 3e-13  # of a few hundred steps, where coordinates are 1 to 100 of the world's own units
FLAT = {"max_evaluations": 200_000, "wavelength": 550.0, "threads": 1}


def examples(short, long):
    """So many with `make test`, so many with `make test-long`."""
    return pytest.mark.parametrize("count", [short, pytest.param(long, marks=pytest.mark.long)])


def holds(count, *strategies):
    """Decorator: runs the property on `count` examples."""
    def run(check):
        quiet = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large]
        fixed = settings(max_examples=count, deadline=None, database=None, suppress_health_check=quiet,
                         print_blob=False)
        seed(SEED)(fixed(given(*strategies)(check)))()
        return check
    return run


scales = numbers(-9.0, 9.0).map(lambda e: 10.0**e)
tolerances = numbers(-12.0, -2.0).map(lambda e: 10.0**e)
starts = vectors(1.5)
lengths = st.one_of(numbers(0.01, 8.0), st.just(0.0), numbers(8.0, 60.0))
shifts = st.one_of(st.just(np.zeros(3)), vectors(10.0), vectors(100.0))


def starting(world, q):
    """n at q; such starts only as have one, and none so near a centre that it is 10 and more."""
    with np.errstate(all="ignore"):
        n = world.index(q)
    assume(0.3 < n < 10.0 or np.isnan(n))
    return n


def traced(world, q, d, length, scale=1.0, shift=(0, 0, 0), **options):
    """Rays in the world made at a scale and a place; no example where the start has no n."""
    shift = scale * np.asarray(shift, float)
    try:
        return cpm.trace(world.make(scale, shift), np.atleast_2d(q) * scale + shift, np.atleast_2d(d),
                         length=length * scale, **(FLAT | options))
    except ValueError as error:
        assert "n^2 <= 0" in str(error) and not world.bounded, error
        reject()


def chosen(world, method):
    """The method, or auto where it cannot run."""
    return {"method": "auto"} if world.stepped else {"method": method, "exclude": ("exact",)}


def accurate(world, method):
    """The same, with exact for those that have it."""
    return {"method": "auto"} if method == "exact" else chosen(world, method)


def healthy(rays, most):
    """Nothing NaN or infinite, a status that there is, evaluations within what was allowed."""
    for name in ("position", "direction", "momentum", "length", "optical_path", "drift", "error_estimate"):
        assert np.all(np.isfinite(getattr(rays, name))), name
    assert set(rays.status.tolist()) <= STATUSES
    np.testing.assert_allclose(np.linalg.norm(rays.direction, axis=1), 1.0, rtol=0, atol=1e-6)
    assert np.all(rays.evaluations <= most), rays.evaluations
    assert np.all((rays.steps >= 0) & (rays.rejected >= 0) & (rays.drift >= 0) & (rays.error_estimate >= 0))


@examples(80, 25_000)
def test_never_nan_never_endless(count):
    """Any medium, any method, both precisions, any allowance: numbers, a status, and no more evaluations than allowed."""
    @holds(count, worlds(), starts, units(), lengths, scales, tolerances, st.sampled_from(ADAPTIVE + FIXED),
           st.sampled_from(["double", "single"]), st.sampled_from([20, 300, 20_000]), shifts)
    def check(world, q, d, length, scale, rtol, method, precision, most, shift):
        starting(world, q)
        step = {"step": scale * max(length, 1.0) / 64} if method in FIXED else {"rtol": rtol}
        rays = traced(world, q, d, length, scale, shift, precision=precision, max_evaluations=most, path=5,
                      **chosen(world, method), **step)
        healthy(rays, most)
        assert np.all(np.isfinite(rays.paths))


@examples(70, 20_000)
def test_conserved(count):
    """|p| = n at the end, and what the symmetry conserves: n r sin φ about a centre, n sin θ across layers."""
    @holds(count, worlds(("centre", "layers", "axis")), starts, units(), lengths, scales, tolerances,
           st.sampled_from(("auto", "exact", "dopri5", "adams")), shifts)
    def check(world, q, d, length, scale, rtol, method, shift):
        n = starting(world, q)
        options = accurate(world, method)
        rays = traced(world, q, d, length, scale, shift, rtol=rtol, **options)
        healthy(rays, FLAT["max_evaluations"])
        if rays.status[0] != cpm.RayStatus.ARRIVED or np.isnan(n):
            return
        shift = scale * np.asarray(shift, float)
        end, p = (rays.position[0] - shift) / scale, rays.momentum[0]
        rounding = ROUNDING * (10.0 + np.abs(shift).max() / scale) * (1.0 + length)
        with np.errstate(all="ignore"):
            there = world.index(end)
        if np.isnan(there):
            return
        # Near a centre a small error of place is a large one of n.
        steep = abs(world.index(end * (1 + 1e-7)) - there) / 1e-7 + there
        allowed = SLACK * rtol * (1.0 + length) + rounding
        most = max(n, there)  # an error of p that was made where n is large stays where n is small
        assert abs(p @ p - there**2) <= allowed * most * (steep + most), "|p| = n"
        first, _ = world.conserved(q, n * d)
        last, arm = world.conserved(end, p)
        size = most * (arm + length + np.linalg.norm(q - world.centre))
        assert np.abs(last - first).max(initial=0.0) <= allowed * size + rounding * n, "conserved"


@examples(60, 15_000)
def test_path_is_integral(count):
    """∫ n dl over samples of the path is the optical path; samples are ordered, at equal arcs, from start to end."""
    @holds(count, worlds(), starts, units(), numbers(0.01, 5.0), scales, tolerances,
           st.sampled_from(("auto", "exact", "dopri5", "adams")))
    def check(world, q, d, length, scale, rtol, method):
        starting(world, q)
        options = accurate(world, method)
        rays = traced(world, q, d, length, scale, rtol=rtol, path=129, **options)
        if rays.status[0] != cpm.RayStatus.ARRIVED:
            return
        path, length_found = rays.paths[0] / scale, rays.length[0] / scale
        assert length_found == pytest.approx(length, rel=1e-12)
        allowed = SLACK * rtol * length + ROUNDING * (10.0 + length)
        np.testing.assert_allclose(path[[0, -1]], [q, rays.position[0] / scale], rtol=0, atol=allowed)
        with np.errstate(all="ignore"):
            n = np.array([world.index(at) for at in path])
        chords = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert np.all(chords <= length / 128 + 2 * allowed)
        if np.any(np.isnan(n)) or world.singular and n.max() > 5.0:
            return
        fine, coarse = (_simpson(values, length) for values in (n, n[::2]))
        if world.smooth or world.singular:
            doubt = abs(fine - coarse)
        else:  # kinks of n: the trapezoidal rule is as good, h² |n′| at each
            doubt = abs(fine - coarse) + np.abs(np.diff(n)).max() * length / 128 * (4 if world.stepped else 1)
        assert abs(rays.optical_path[0] / scale - fine) <= doubt + allowed * n.max() * (1 + n.max())


def _simpson(values, length):
    return length / (len(values) - 1) / 3 * (values[0] + values[-1] + 4 * values[1::2].sum() + 2 * values[2:-1:2].sum())


def magnified(world, q, d, length, **options):
    """By how much the end moves if the start does: a condition number, by four neighbours (no oracle in itself)."""
    side = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
    side /= np.linalg.norm(side)
    other, tiny = np.cross(d, side), 1e-6
    near = traced(world, [q, q + tiny * side, q + tiny * other, q, q],
                  [d, d, d, d + tiny * side, d + tiny * other], length, **options)
    if np.any(near.status != cpm.RayStatus.ARRIVED):
        return np.inf
    moved = np.linalg.norm(near.position[1:] - near.position[0], axis=1) / tiny
    turned = np.linalg.norm(near.direction[1:] - near.direction[0], axis=1) / tiny
    return max(moved.max(), turned.max() * max(length, 1.0), 1.0)


@examples(50, 10_000)
def test_reversal(count):
    """Back from the end: home again by the same optical path, as near as the way's own magnification allows."""
    @holds(count, worlds(), starts, units(), numbers(0.1, 6.0), scales, tolerances,
           st.sampled_from(("auto", "exact", "dopri5", "adams")))
    def check(world, q, d, length, scale, rtol, method):
        starting(world, q)
        options = accurate(world, method)
        there = traced(world, q, d, length, scale, rtol=rtol, **options)
        if there.status[0] != cpm.RayStatus.ARRIVED:
            return
        end = there.position[0] / scale
        worst = magnified(world, end, -there.direction[0], length, rtol=1e-10, **options)
        assume(worst < 1e-2 / rtol and worst < 1e4)
        back = traced(world, end, -there.direction[0], length, scale, rtol=rtol, **options)
        if back.status[0] != cpm.RayStatus.ARRIVED:
            return
        allowed = (SLACK * rtol * (1.0 + length) + ROUNDING * (10.0 + length)) * worst
        assert np.linalg.norm(back.position[0] / scale - q) <= allowed
        assert abs(back.optical_path[0] - there.optical_path[0]) / scale <= 10.0 * allowed


@examples(40, 15_000)
def test_scaled(count):
    """The world 2^k times as large: the same ray, to the last bit, with as many evaluations.

    Not centres and lines: the length over which their field changes, which chooses the first step, is a root. Nor formulas,
    whose constants are folded.
    """
    @holds(count, worlds(), starts, units(), lengths, scales, tolerances, st.sampled_from(ADAPTIVE),
           st.integers(-12, 12))
    def check(world, q, d, length, scale, rtol, method, k):
        assume(not world.formula and not world.singular)
        starting(world, q)
        options = {"rtol": rtol, "max_evaluations": 20_000} | chosen(world, method)
        scale = 2.0 ** round(np.log2(scale))
        one, two = (traced(world, q, d, length, s, **options) for s in (scale, scale * 2.0**k))
        np.testing.assert_array_equal(one.status, two.status)
        np.testing.assert_array_equal(one.evaluations, two.evaluations)
        np.testing.assert_array_equal(one.position * 2.0**k, two.position)
        np.testing.assert_array_equal(one.momentum, two.momentum)
        np.testing.assert_array_equal(one.optical_path * 2.0**k, two.optical_path)


@examples(40, 10_000)
def test_moved(count):
    """The world somewhere else: the same ray, within tolerance and rounding, as magnified by the way."""
    @holds(count, worlds(), starts, units(), numbers(0.1, 6.0), scales, tolerances,
           st.sampled_from(("auto", "exact", "dopri5", "adams")), vectors(100.0))
    def check(world, q, d, length, scale, rtol, method, shift):
        starting(world, q)
        options = accurate(world, method)
        one = traced(world, q, d, length, scale, rtol=rtol, **options)
        two = traced(world, q, d, length, scale, shift, rtol=rtol, **options)
        if np.any(np.append(one.status, two.status) != cpm.RayStatus.ARRIVED):
            return
        worst = magnified(world, q, d, length, rtol=1e-10, **options)
        assume(worst < 1e-2 / rtol and worst < 1e4)
        allowed = (SLACK * rtol * (1.0 + length) + ROUNDING * (100.0 + length)) * worst
        moved = (two.position[0] - scale * shift - one.position[0]) / scale
        assert np.linalg.norm(moved) <= allowed


@st.composite
def bounded_worlds(draw):
    """A world, and bounds of its own symmetry: a ball about the centre, a slab between two heights."""
    world = draw(worlds(("centre", "layers"), axes=st.sampled_from(COORDINATES)))
    if world.symmetry == "centre":
        return world, (0.0, draw(numbers(0.4, 2.5)))
    low, high = sorted((draw(numbers(-2.0, 2.0)), draw(numbers(-2.0, 2.0))))
    assume(high - low > 0.05)
    return world, (low, high)


@examples(40, 5_000)
def test_bounded(count):
    """Through a ball about its own centre, or a slab across its own axis, in homogeneous surroundings: what the symmetry
    conserves outlasts refraction and total reflection at the bounds (Snell with the local n)."""
    @holds(count, bounded_worlds(), starts, units(), numbers(0.1, 8.0), numbers(-3.0, 3.0).map(lambda e: 10.0**e),
           tolerances, st.sampled_from(("auto", "exact", "dopri5")), numbers(1.0, 1.5))
    def check(bounded, q, d, length, scale, rtol, method, outside):
        world, bound = bounded
        starting(world, q)
        medium = world.make(scale, np.zeros(3))
        if world.symmetry == "centre":
            medium.bounds = cpm.Sphere(scale * world.centre, scale * bound[1])
            height = np.linalg.norm(q - world.centre)
        else:
            k = int(np.argmax(np.abs(world.axis)))
            low, high = np.full(3, -200.0), np.full(3, 200.0)
            low[k], high[k] = sorted(world.centre[k] + np.array(bound) * world.axis[k])
            medium.bounds = cpm.Box(scale * low, scale * high)
            height = (q - world.centre) @ world.axis
        assume(np.abs(np.array(bound) - height).min() > 1e-6)  # else the direction says on which side it is
        within = bound[0] < height < bound[1]
        scene = cpm.Scene(medium=cpm.media.Homogeneous(outside),
                          extent=cpm.Box((-400 * scale,) * 3, (400 * scale,) * 3))
        scene.add_medium(medium)
        options = accurate(world, method)
        rays = cpm.trace(scene, [scale * q], [d], length=scale * length, rtol=rtol, **(FLAT | options))
        healthy(rays, FLAT["max_evaluations"])
        if rays.status[0] != cpm.RayStatus.ARRIVED:
            return
        n = world.index(q) if within else outside
        assume(not np.isnan(n))
        first, _ = world.conserved(q, n * d)
        last, arm = world.conserved(rays.position[0] / scale, rays.momentum[0])
        size = max(n, np.linalg.norm(rays.momentum[0])) * (arm + length + np.linalg.norm(q - world.centre))
        allowed = SLACK * rtol * (1.0 + length) + 1e-11 * (1.0 + length)
        assert np.abs(last - first).max() <= allowed * size


def test_sum_with_a_centre():
    """A ray that falls into the centre of a sum is captured, as it is without the other term."""
    point, fisheye = cpm.media.Sources([(0, 0, 0)], [0.25], 2), cpm.media.Fisheye(1.5, 1.0)
    ray = dict(wavelength=550.0, length=3.0, rtol=1e-6)
    assert cpm.trace(point, [(0, 0, 1)], [(0.3, 0, -1)], **ray).status[0] == cpm.RayStatus.CAPTURED
    rays = cpm.trace(point + fisheye, [(0, 0, 1)], [(0.3, 0, -1)], **ray)
    assert rays.status[0] == cpm.RayStatus.CAPTURED
