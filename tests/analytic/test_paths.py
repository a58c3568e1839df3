"""Every medium × method × tolerance against its oracle (DESIGN sections 2, 3 and 8).

Asked: position error ≤ atol + rtol × path length, direction error ≤ rtol.  `exact` is held to
rounding.  Adaptive methods control local errors, which add up over a path, so they get `SLACK` ×
the tolerance: SciPy's DOP853 needs about as much on these cases.
"""

import functools

import numpy as np
import pytest
from oracles import central, layers
from oracles import rays as oracle
from oracles.cases import CASES, COARSE, STEP_HEIGHTS, STEP_N

import cpm

SLACK = 10.0
WAVELENGTH = 550.0
TOLERANCES = {
    "euler": [1e-2, 1e-3],
    "dopri5": [1e-3, 1e-6, 1e-9, 1e-12],
    "adams": [1e-2, 1e-3, 1e-6, 1e-9, 1e-12],
    "nystrom": [1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12],
    "auto": [1e-3, 1e-6, 1e-9, 1e-12],
}
NUMERIC = [(m, t) for m, ts in TOLERANCES.items() for t in ts]
EXACT = [name for name, case in CASES.items() if case.exact]
INEXACT = [name for name, case in CASES.items() if not case.exact]

#: What oracle and rounding leave, metres over a few metres of path.
FLOOR = {"layered-linear-squared": 2e-12, "grid-linear": 3e-10, "grid-cubic": 3e-10, "layered-cubic": 3e-10,
         "sources": 3e-11}


def run(case, **options):
    """The case's rays through the library."""
    if "until" not in options:
        options.setdefault("length", case.length)
    directions = [options.pop("towards")] if "towards" in options else case.directions()
    return cpm.trace(case.make(cpm), [case.origin] * len(directions), directions, wavelength=WAVELENGTH, **options)


def check(rays, ends, tolerance, floor, length):
    """Position, direction, momentum and optical path within the contract's tolerance."""
    limit = tolerance * length + floor
    position = np.linalg.norm(rays.position - ends.position, axis=1)
    assert np.all(rays.status == cpm.RayStatus.ARRIVED)
    assert np.max(position) <= limit, f"position error {position} above {limit:.3g}"
    direction = np.linalg.norm(rays.direction - ends.direction, axis=1)
    assert np.max(direction) <= tolerance + floor, f"direction error {direction}"
    np.testing.assert_allclose(np.linalg.norm(rays.direction, axis=1), 1.0, rtol=1e-14)
    n = np.linalg.norm(ends.momentum, axis=1)
    assert np.max(np.linalg.norm(rays.momentum - ends.momentum, axis=1) / n) <= 2 * tolerance + floor
    assert np.max(np.abs(rays.optical_path - ends.optical_path)) <= 2 * limit
    assert np.max(np.abs(rays.length - ends.arc_length)) <= limit


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize(("method", "rtol"), NUMERIC)
def test_end(name, method, rtol, backend):
    """Numerical methods end where the oracle does; `auto` is kept from `exact`."""
    case = CASES[name]
    exclude = ("exact",) if method == "auto" else ()
    rays = run(case, method=method, rtol=rtol, exclude=exclude, backend=backend)
    check(rays, case.ends(), SLACK * rtol, FLOOR.get(name, 1e-12), case.length)
    # A homogeneous medium runs no integrator, whatever is asked (DESIGN section 2).
    assert np.all((rays.method == "exact") == (name == "homogeneous"))


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("method", ["exact", "auto"])
def test_exact(name, method, backend):
    """Closed forms to rounding, whatever the tolerance asked; `auto` picks them."""
    case = CASES[name]
    rays = run(case, method=method, rtol=1e-2, backend=backend)
    check(rays, case.ends(), 1e-13, 1e-13, case.length)
    assert np.all(rays.method == "exact")


@pytest.mark.parametrize("name", INEXACT)
def test_no_closed_form(name):
    """`exact` is an error where there is none; `auto` is not."""
    with pytest.raises((ValueError, cpm.Error), match="exact"):
        run(CASES[name], method="exact")
    assert not np.any(run(CASES[name]).method == "exact")


@pytest.mark.parametrize("name", INEXACT)
def test_default_tolerance(name):
    """rtol 1e-6 and atol 0 when nothing is said."""
    case = CASES[name]
    check(run(case), case.ends(), SLACK * 1e-6, FLOOR[name], case.length)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_until_plane(name, method, backend):
    """`until=` ends on the plane, where the oracle crosses it, from a direction that is not unit."""
    case, end = CASES[name], CASES[name].plane_end()
    point, normal = case.plane
    rays = run(case, method=method, rtol=1e-9, until=(point, normal), towards=case.towards, backend=backend)
    check(rays, oracle.stack([end]), SLACK * 1e-9, FLOOR.get(name, 1e-12), end.arc_length)
    assert abs((rays.position[0] - point) @ np.array(normal)) <= 1e-10


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_path_samples(name, method):
    """`path=K`: samples at equal arc length, first and last the ends, each on the oracle's curve."""
    case, count = CASES[name], 9
    rays = run(case, method=method, rtol=1e-8, path=count)
    assert rays.paths.shape == (len(case.directions()), count, 3)
    lengths = np.linspace(0, case.length, count)
    np.testing.assert_allclose(rays.paths[:, 0], case.origins(), rtol=0, atol=1e-14)
    np.testing.assert_allclose(rays.paths[:, -1], rays.position, rtol=0, atol=1e-12)
    for path, direction in zip(rays.paths[:3], case.directions()[:3], strict=True):
        expected = oracle.sample_by_arc(case.field, case.origin, direction, lengths)
        floor = 1e-6 if name == "layered-linear-squared" else 0.0  # the oracle's steps across kinks
        assert np.max(np.linalg.norm(path - expected, axis=1)) <= SLACK * 1e-8 * case.length + floor


STEP_RAYS = [(0, 1, 0), (0.5, 1, 0.1), (1, 0.6, -0.2), (1, 0.35, 0), (1, -0.4, 0.5), (1, 0, 0)]


@pytest.mark.parametrize("direction", STEP_RAYS)
def test_step_layers(direction):
    """Discrete layers, n[i] from heights[i] to heights[i+1]: straight lines, Snell, total reflection, to rounding."""
    medium = cpm.media.Layered(STEP_HEIGHTS, STEP_N, up=(0, 1, 0), interpolation="step")
    origin, length = (0.1, -0.7, 0.2), 6.0
    expected = layers.step(STEP_HEIGHTS[1:], STEP_N, (0, 1, 0), (0, 0, 0), origin, direction, length=length)
    rays = cpm.trace(medium, [origin], [direction], wavelength=WAVELENGTH, length=length)
    check(rays, oracle.stack([expected]), 1e-13, 1e-13, length)


def test_step_layers_reflect():
    """The flattest of those rays is turned back by the thinner layers above, the steepest is not."""
    medium = cpm.media.Layered(STEP_HEIGHTS, STEP_N, up=(0, 1, 0), interpolation="step")
    rays = cpm.trace(medium, [(0.1, -0.7, 0.2)] * 2, [(1, 0.35, 0), (0.5, 1, 0.1)], wavelength=WAVELENGTH, length=25.0)
    assert rays.direction[0, 1] < 0 < rays.direction[1, 1]


@pytest.mark.parametrize("name", [n for n in CASES if n != "homogeneous"])
def test_single_precision(name):
    """float32 state: float64 arrays that agree to float32's rounding over a few metres."""
    case = CASES[name]
    rays = run(case, precision="single", rtol=1e-4)
    assert rays.position.dtype == np.float64
    assert np.max(np.linalg.norm(rays.position - case.ends().position, axis=1)) < SLACK * 1e-4 * case.length


def test_shapes_and_types():
    """One ray as a bare vector or (1, 3); length and wavelength scalar or (N,)."""
    case = CASES["linear-squared"]
    medium, length = case.make(cpm), np.array([1.0, 2.0, 3.0, 0.5, 0.25, 4.0])
    together = cpm.trace(medium, case.origins(), case.directions(), wavelength=np.full(6, WAVELENGTH), length=length)
    assert together.position.shape == together.direction.shape == together.momentum.shape == (6, 3)
    for name in ("optical_path", "evaluations", "steps", "status", "drift", "error_estimate"):
        assert getattr(together, name).shape == (6,), name
    assert together.status.dtype == np.int32
    assert together.position.dtype == np.float64
    for i, d in enumerate(case.directions()):
        one = cpm.trace(medium, [case.origin], [d], wavelength=WAVELENGTH, length=length[i])
        np.testing.assert_array_equal(one.position[0], together.position[i])


@pytest.mark.parametrize("name", INEXACT)
def test_error_estimates(name):
    """`error_estimate` is there and finite; the global one brackets the truth within a factor of ten."""
    case = CASES[name]
    for error in ("local", "global"):
        rays = run(case, method="dopri5", rtol=1e-5, error=error)
        truth = np.linalg.norm(rays.position - case.ends().position, axis=1)
        assert np.all(np.isfinite(rays.error_estimate)) and np.all(rays.error_estimate > 0)
        if error == "global":
            assert np.mean(truth <= 10 * rays.error_estimate + FLOOR[name]) == 1.0


@pytest.mark.parametrize("name", INEXACT)
def test_counters(name):
    """Work is counted, and grows when the tolerance shrinks."""
    loose, tight = (run(CASES[name], method="dopri5", rtol=r) for r in (1e-3, 1e-9))
    assert np.all(loose.evaluations >= loose.steps) and np.all(loose.steps >= 1)
    assert tight.evaluations.sum() > loose.evaluations.sum()
    assert np.all(tight.drift <= 10 * 1e-9 * np.maximum(tight.steps, 1))


@pytest.mark.parametrize("method", ["nystrom", "adams", "dopri5"])
@pytest.mark.parametrize("name", ["layers", "lens"])
def test_ends_just_beyond_a_kink(name, method):
    """Rays that end a little beyond a face of layers, or the rim of a lens: what leads there says nothing of what follows.

    The last step ends at the face, or just before it, and the ray 0 to 5 % of a step later.
    """
    case = CASES["layered-linear-squared"]
    medium, origin, closed = case.make(cpm), case.origin, case.closed
    if name == "lens":
        medium, origin = cpm.media.Luneburg(1.0), (0.2, -0.1, 0.3)
        closed = functools.partial(central.luneburg, 1.0, (0, 0, 0))
    way = np.linspace(0.0, 2.5, 2501)
    for aim in np.random.default_rng(1).normal(size=(20, 3)):
        path = cpm.trace(medium, [origin], [aim], length=2.5, wavelength=WAVELENGTH, path=len(way)).paths[0]  # where it is met
        side = np.linalg.norm(path, axis=1) < 1.0 if name == "lens" else np.searchsorted(COARSE, path[:, 1])
        met = np.flatnonzero(np.diff(side.astype(int)))
        if not len(met):
            continue
        beyond = way[met[0] + 1] * (1 + np.array([1e-4, 1e-3, 3e-3, 1e-2, 3e-2]))
        rays = cpm.trace(medium, [origin] * len(beyond), aim, length=beyond, method=method, rtol=1e-9, wavelength=WAVELENGTH)
        ends = [closed(origin, aim, length=length).position for length in beyond]
        np.testing.assert_allclose(rays.position, ends, rtol=0, atol=3e-8)
