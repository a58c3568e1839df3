"""Rays at the edge of what the media of this issue allow (DESIGN section 13), each with an oracle."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import closed_forms, fields, radiometry, rays, splines

import cpm

NUMERIC = ["dopri5", "auto"]


def trace(medium, origin, direction, **options):
    """One ray."""
    options.setdefault("wavelength", 550.0)
    return cpm.trace(medium, [origin], [direction], **options)


@pytest.mark.parametrize("method", ["auto", "dopri5", "euler", "nystrom", "adams"])
def test_zero_length(method):
    rays_ = trace(cpm.media.Linear(1.3, gradient=(0, -0.05, 0)), (0.1, 0.2, 0.3), (1, 2, 2), length=0.0, method=method)
    np.testing.assert_array_equal(rays_.position[0], (0.1, 0.2, 0.3))
    np.testing.assert_allclose(rays_.direction[0], np.array((1, 2, 2)) / 3, rtol=1e-15)
    assert rays_.status[0] == cpm.RayStatus.ARRIVED and rays_.optical_path[0] == 0


@pytest.mark.parametrize("method", ["auto", "dopri5"])
@pytest.mark.parametrize("kind", ["linear-squared", "linear", "layered"])
def test_huge_coordinates(kind, method):
    """An origin 1e9 m away changes nothing beyond rounding of the coordinates themselves (1.2e-7 m)."""
    far = np.array([1e9, -1e9, 1e9])
    heights = np.linspace(-10, 10, 201)

    def make(origin):
        if kind == "linear-squared":
            return cpm.media.LinearSquared(1.69, gradient=(0.02, -0.1, 0), origin=origin)
        if kind == "linear":
            return cpm.media.Linear(1.3, gradient=(0.02, -0.05, 0), origin=origin)
        return cpm.media.Layered(
            heights, 1.3 + 0.1 * np.tanh(heights), up=(0, 1, 0), origin=origin, interpolation="cubic"
        )

    at, d = np.array([0.0, 1.0, 0.0]), (1, -0.3, 0.2)
    options = dict(length=5.0, method=method, rtol=1e-9)
    near, moved = trace(make(np.zeros(3)), at, d, **options), trace(make(far), at + far, d, **options)
    assert moved.status[0] == cpm.RayStatus.ARRIVED
    np.testing.assert_allclose(moved.position[0] - far, near.position[0], rtol=0, atol=6 * np.spacing(1e9))
    np.testing.assert_allclose(moved.direction[0], near.direction[0], rtol=0, atol=1e-7)


@pytest.mark.parametrize("method", ["auto", "dopri5", "adams"])
def test_cutoff_at_normal_incidence(method):
    """n² = 1 − y: straight up, p → 0 at y = 1; the ray ends there with a status of its own."""
    medium = cpm.media.LinearSquared(1.0, gradient=(0, -1, 0))
    rays_ = trace(medium, (0, 0, 0), (0, 1, 0), length=3.0, method=method, rtol=1e-8)
    assert rays_.status[0] == cpm.RayStatus.CUTOFF
    np.testing.assert_allclose(rays_.position[0], (0, 1, 0), rtol=0, atol=1e-6)


@pytest.mark.parametrize("angle", [1.0, 5.0, 45.0])
@pytest.mark.parametrize("method", ["auto", "dopri5", "adams"])
def test_oblique_turns_back(angle, method):
    """Off the normal the same ray turns at n = n₀ sinθ and comes back: the parabola."""
    medium, d = (
        cpm.media.LinearSquared(1.0, gradient=(0, -1, 0)),
        (np.sin(np.radians(angle)), np.cos(np.radians(angle)), 0),
    )
    expected = closed_forms.linear_squared(1.0, (0, -1, 0), (0, 0, 0), (0, 0, 0), d, length=1.8)
    rays_ = trace(medium, (0, 0, 0), d, length=1.8, method=method, rtol=1e-9)
    assert rays_.status[0] == cpm.RayStatus.ARRIVED
    assert expected.direction[1] < 0
    np.testing.assert_allclose(rays_.position[0], expected.position, rtol=0, atol=2e-7 if angle == 1.0 else 3e-8)


@pytest.mark.parametrize("method", ["exact", "dopri5", "nystrom", "adams"])
def test_plane_never_reached(method):
    """A plane behind a turning ray: the ray ends with a status that is not `arrived`, and finite."""
    medium = cpm.media.LinearSquared(1.0, gradient=(0, -1, 0))
    rays_ = trace(medium, (0, 0, 0), (1, 1, 0), until=((0, 0.9, 0), (0, 1, 0)), method=method, max_evaluations=20_000)
    assert rays_.status[0] != cpm.RayStatus.ARRIVED
    assert np.all(np.isfinite(rays_.position))


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_grid_of_one_cell(interpolation):
    """(2, 2, 2) samples of one value are homogeneous; of a linear n they are `Linear`."""
    grid = cpm.media.Grid(np.full((2, 2, 2), 1.3), origin=(0, 0, 0), spacing=(1, 1, 1), interpolation=interpolation)
    rays_ = trace(grid, (0.1, 0.2, 0.3), (1, 1, 0.5), length=0.9)
    np.testing.assert_allclose(
        rays_.position[0], np.array((0.1, 0.2, 0.3)) + 0.9 * np.array((1, 1, 0.5)) / 1.5, rtol=0, atol=1e-12
    )
    if interpolation == "linear":
        x, y, z = np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")
        grid = cpm.media.Grid(
            1.3 + 0.1 * x - 0.2 * y + 0.05 * z, origin=(0, 0, 0), spacing=(1, 1, 1), interpolation="linear"
        )
        expected = closed_forms.linear(1.3, (0.1, -0.2, 0.05), (0, 0, 0), (0.1, 0.2, 0.3), (1, 1, 0.5), length=0.7)
        rays_ = trace(grid, (0.1, 0.2, 0.3), (1, 1, 0.5), length=0.7, rtol=1e-10)
        np.testing.assert_allclose(rays_.position[0], expected.position, rtol=0, atol=1e-9)


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 4, 4), (2, 1, 3)])
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_flat_grids(shape, interpolation):
    """An axis with one sample has no gradient along it, or is refused by name: never a crash."""
    try:
        grid = cpm.media.Grid(np.full(shape, 1.2), origin=(0, 0, 0), spacing=(1, 1, 1), interpolation=interpolation)
    except ValueError as problem:
        assert "values" in str(problem)
        return
    np.testing.assert_allclose(trace(grid, (0, 0, 0), (3, 0, 4), length=5.0).position[0], (3, 0, 4), rtol=0, atol=1e-12)


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
@pytest.mark.parametrize("method", NUMERIC)
def test_noisy_grid(interpolation, method):
    """White noise in [1.2, 1.4], 40³ samples: the oracle's end over a few cells, within the tolerance.

    The rays stay 16 cells from the edge, so the spline's end condition is 0.268¹⁶ ≈ 1e-9 of a sample.
    """
    values = np.random.default_rng(5).uniform(1.2, 1.4, (40, 40, 40))
    origin, spacing = (-1.95, -1.95, -1.95), (0.1, 0.1, 0.1)
    make = splines.grid_linear if interpolation == "linear" else splines.grid_cubic
    grid = cpm.media.Grid(values, origin=origin, spacing=spacing, interpolation=interpolation)
    for start, d in [((0.01, 0.02, 0.03), (1, 0.3, -0.2)), ((-0.1, 0.0, 0.1), (-0.3, 1, 0.4))]:
        expected = rays.trace(make(values, origin, spacing), start, d, length=0.3)
        rays_ = trace(grid, start, d, length=0.3, method=method, rtol=1e-7)
        assert rays_.status[0] == cpm.RayStatus.ARRIVED
        assert np.linalg.norm(rays_.position[0] - expected.position) < 10 * 1e-7 * 0.3 + 1e-8


@pytest.mark.parametrize("width", [1e-1, 1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("method", NUMERIC)
@pytest.mark.parametrize("degrees", [30.0, 60.0])
def test_tanh_step_towards_snell(width, method, degrees):
    """A tanh layer from 1.5 to 1.0: Snell's direction below the critical angle (41.8°), mirror above it.

    Horizontal momentum is conserved exactly by any layered n, so the direction is Snell's whatever the width.
    """
    t = np.linspace(-20, 20, 801)
    heights = np.concatenate([[-4.0, -3.0, -2.5], width * t, [2.5, 3.0, 4.0]]) if width * 20 < 2.5 else width * t
    medium = cpm.media.Layered(heights, 1.25 - 0.25 * np.tanh(heights / width), up=(0, 1, 0), interpolation="cubic")
    a = np.radians(degrees)
    start, d = (0.0, -2.0, 0.0), np.array((np.sin(a), np.cos(a), 0))
    rays_ = trace(medium, start, d, length=2 / np.cos(a) + 1.5, method=method, rtol=1e-8)
    assert rays_.status[0] == cpm.RayStatus.ARRIVED
    expected = radiometry.snell(d, (0, 1, 0), 1.5, 1.0)
    if expected is None:
        expected = d * (1, -1, 1)
    np.testing.assert_allclose(rays_.direction[0], expected, rtol=0, atol=1e-5 if width < 0.1 else 1e-3)
    reach = start + d * 2 / np.cos(a) + 1.5 * expected
    assert np.linalg.norm(rays_.position[0] - reach) < 30 * width


def test_grazing_turning_point():
    """A ray that meets the tanh layer within 1e-3 of its turning index: DOP853's end."""
    heights = np.linspace(-6, 6, 2401)
    medium = cpm.media.Layered(heights, 1.25 - 0.25 * np.tanh(heights), up=(0, 1, 0), interpolation="cubic")
    field = splines.layered_cubic(heights, 1.25 - 0.25 * np.tanh(heights))
    n0 = 1.25 - 0.25 * np.tanh(-1.0)
    for n_turn in (1.001, 1.25):
        sine = n_turn / n0
        d = (sine, np.sqrt(1 - sine**2), 0)
        expected = rays.trace(field, (0, -1, 0), d, length=3.0)
        rays_ = trace(medium, (0, -1, 0), d, length=3.0, rtol=1e-9)
        np.testing.assert_allclose(rays_.position[0], expected.position, rtol=0, atol=3e-8)


@pytest.mark.parametrize("method", ["dopri5", "euler", "nystrom", "adams"])
def test_evaluations_exhausted(method):
    """The bound on evaluations ends the ray, with that status, a finite place, and no more work than allowed."""
    medium = cpm.media.Linear(1.5, gradient=(0, -1e-4, 0))
    rays_ = trace(
        medium, (0, 0, 0), (1, 0.1, 0), length=1e4, method=method, rtol=1e-9, max_step=0.1, max_evaluations=100
    )
    assert rays_.status[0] == cpm.RayStatus.EVALUATIONS_EXHAUSTED
    assert rays_.evaluations[0] <= 120
    assert np.all(np.isfinite(rays_.position)) and rays_.position[0, 0] < 1e4


def test_tightest_tolerance():
    """rtol 1e-14 ends (arrived, or a status that says why not) within a few hundred ulp of the catenary."""
    medium = cpm.media.Linear(1.3, gradient=(0, -0.05, 0))
    rays_ = trace(medium, (0, 1, 0), (1, 0.4, 0.2), length=5.0, rtol=1e-14, method="dopri5")
    expected = closed_forms.linear(1.3, (0, -0.05, 0), (0, 0, 0), (0, 1, 0), (1, 0.4, 0.2), length=5.0)
    assert rays_.status[0] in (cpm.RayStatus.ARRIVED, cpm.RayStatus.STEP_UNDERFLOW)
    if rays_.status[0] == cpm.RayStatus.ARRIVED:
        np.testing.assert_allclose(rays_.position[0], expected.position, rtol=0, atol=1e-12)


def test_thin_layer_is_not_stepped_over():
    """n leaps 1.0 → 1.3 within 1e-3 m, 3 m away at 60°: drift control or breakpoints must see it at rtol 1e-3."""
    heights = np.concatenate([np.linspace(-4, -0.01, 8), np.linspace(-0.005, 0.005, 101), np.linspace(0.01, 4, 8)])
    medium = cpm.media.Layered(heights, 1.15 + 0.15 * np.tanh(heights / 1e-3), up=(0, 1, 0), interpolation="cubic")
    a = np.radians(60)
    rays_ = trace(medium, (0, -3, 0), (np.sin(a), np.cos(a), 0), length=8.0, rtol=1e-3)
    assert rays_.direction[0, 0] == pytest.approx(np.sin(a) / 1.3, abs=0.01)


unit = st.floats(-1, 1, allow_nan=False)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    gradient=st.tuples(unit, unit, unit),
    direction=st.tuples(unit, unit, unit),
    length=st.floats(1e-6, 2.0),
    n=st.floats(1.0, 3.0),
    kind=st.sampled_from(["linear-squared", "linear"]),
)
def test_any_gradient(gradient, direction, length, n, kind):
    """Random linear media: closed forms, unit direction, |p| = n, whether exact or integrated."""
    g = 0.2 * np.array(gradient)
    if np.linalg.norm(direction) < 1e-3 or np.linalg.norm(g) < 1e-12:
        return
    if kind == "linear-squared":
        medium, closed = (
            cpm.media.LinearSquared(n * n, gradient=g),
            closed_forms.linear_squared(n * n, g, np.zeros(3), np.zeros(3), direction, length=length),
        )
        field = fields.LinearSquared(n * n, tuple(g))
    else:
        medium, closed = (
            cpm.media.Linear(n, gradient=g),
            closed_forms.linear(n, g, np.zeros(3), np.zeros(3), direction, length=length),
        )
        field = fields.Linear(n, tuple(g))
    for options, limit in (({"method": "exact"}, 1e-12), ({"method": "dopri5", "rtol": 1e-9}, 1e-8 * length + 1e-14)):
        rays_ = trace(medium, np.zeros(3), direction, length=length, **options)
        assert rays_.status[0] == cpm.RayStatus.ARRIVED
        assert np.linalg.norm(rays_.position[0] - closed.position) <= limit
        assert np.linalg.norm(rays_.direction[0]) == pytest.approx(1, abs=1e-14)
        assert np.linalg.norm(rays_.momentum[0]) == pytest.approx(np.sqrt(field(rays_.position[0])[0]), rel=1e-7)
