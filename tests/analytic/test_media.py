"""`Medium.evaluate`: n and ∇n at points against the oracle's fields, and how dispersion scales a varying medium."""

import numpy as np
import pytest
from oracles import radiometry
from oracles.cases import CASES, STEP_HEIGHTS, STEP_N

import cpm

D_LINE = 587.5618
TOLERANCE = {"grid-cubic": 1e-9, "layered-cubic": 1e-9}


@pytest.mark.parametrize("name", CASES)
def test_index_and_gradient(name):
    case = CASES[name]
    points = np.array(case.origin) + np.random.default_rng(3).uniform(-0.8, 0.8, (200, 3))
    n, gradient = case.make(cpm).evaluate(points, 550.0)
    expected = [case.field(r) for r in points]
    index = np.sqrt([e[0] for e in expected])
    np.testing.assert_allclose(n, index, rtol=TOLERANCE.get(name, 1e-13))
    slopes = np.array([e[1] for e in expected]) / index[:, None]
    np.testing.assert_allclose(gradient, slopes, rtol=0, atol=100 * TOLERANCE.get(name, 1e-14))


def test_step():
    """n[i] from heights[i] up to heights[i+1], the ends held."""
    medium = cpm.media.Layered(STEP_HEIGHTS, STEP_N, up=(0, 2, 0), interpolation="step")
    heights = np.array([-9.0, -1.5, -0.5, 0.1, 0.8, 1.9, 2.5])
    n, _ = medium.evaluate(np.column_stack([heights, heights, 0 * heights]))
    np.testing.assert_array_equal(n, STEP_N[np.clip(np.searchsorted(STEP_HEIGHTS, heights) - 1, 0, 5)])


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_grid_interpolates_its_samples(interpolation):
    """At the samples, the samples, edges included; outside, the edge value."""
    values = np.random.default_rng(0).uniform(1.1, 1.5, (4, 5, 6))
    grid = cpm.media.Grid(values, origin=(1, 2, 3), spacing=(0.5, 0.25, 1.0), interpolation=interpolation)
    at = np.stack(
        np.meshgrid(1 + 0.5 * np.arange(4), 2 + 0.25 * np.arange(5), 3.0 + np.arange(6), indexing="ij"), axis=-1
    ).reshape(-1, 3)
    np.testing.assert_allclose(grid.evaluate(at)[0], values.ravel(), rtol=1e-12)
    n, gradient = grid.evaluate([(-100.0, 2, 3), (-100.0, -100, -100), (100.0, 100, 100)])
    np.testing.assert_allclose(n, [values[0, 0, 0], values[0, 0, 0], values[-1, -1, -1]], rtol=1e-12)
    np.testing.assert_allclose(gradient[1:], 0.0, rtol=0, atol=1e-12)


def test_grid_strides():
    """A transposed, non-contiguous array gives the same field as its copy."""
    base = np.random.default_rng(1).uniform(1.1, 1.5, (7, 5, 6))
    points = np.random.default_rng(2).uniform(0.5, 3.5, (50, 3))
    view, copy = base.transpose(2, 1, 0)[::2], np.ascontiguousarray(base.transpose(2, 1, 0)[::2])
    for interpolation in ("linear", "cubic"):
        a, b = (cpm.media.Grid(v, spacing=1.0, interpolation=interpolation).evaluate(points) for v in (view, copy))
        np.testing.assert_array_equal(a[0], b[0])
        np.testing.assert_array_equal(a[1], b[1])


def test_density():
    """n = 1 + K ρ (Gladstone and Dale)."""
    rho = np.random.default_rng(1).uniform(0.5, 1.5, (4, 4, 4))
    grid = cpm.media.Grid(rho, spacing=1.0, interpolation="linear", quantity="density", gladstone_dale=2.26e-4)
    n, _ = grid.evaluate((1.0, 2.0, 3.0))
    assert n[0] - 1 == pytest.approx(2.26e-4 * rho[1, 2, 3], rel=1e-11)


@pytest.mark.parametrize("kind", ["Linear", "LinearSquared"])
def test_dispersion_of_a_varying_medium(kind):
    """Its own numbers hold at the d line; elsewhere n − 1 (or n² − 1) scales with the model's."""
    model = cpm.dispersion.Cauchy(1.5, 0.02)
    at, blue, red = np.array([(0.3, 1.0, 0.2)]), 450.0, 680.0
    gradient = (0.02, -0.1, 0.05)
    make = getattr(cpm.media, kind)
    plain, coloured = make(1.69, gradient=gradient), make(1.69, gradient=gradient, dispersion=model)
    n, slope = plain.evaluate(at)
    np.testing.assert_allclose(coloured.evaluate(at, D_LINE)[0], n, rtol=1e-14)
    d = radiometry.cauchy(D_LINE, 1.5, 0.02)
    for wavelength in (blue, red):
        dispersed = radiometry.cauchy(wavelength, 1.5, 0.02)
        found, found_slope = coloured.evaluate(at, wavelength)
        if kind == "Linear":
            factor = (dispersed - 1) / (d - 1)
            expected, expected_slope = 1 + (n - 1) * factor, slope * factor
        else:
            factor = (dispersed**2 - 1) / (d**2 - 1)
            expected = np.sqrt(1 + (n**2 - 1) * factor)
            expected_slope = slope * n / expected * factor
        np.testing.assert_allclose(found, expected, rtol=1e-13)
        np.testing.assert_allclose(found_slope, expected_slope, rtol=1e-12)


def test_layered_kinks():
    """Splines that meet at kinks: natural ones of SciPy on either side."""
    from scipy.interpolate import CubicSpline

    heights = np.array([0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 5.0])
    n = np.array([1.30, 1.25, 1.23, 1.21, 1.15, 1.11, 1.10])
    medium = cpm.media.Layered(heights, n, kinks=[4.0, 2.5])
    at = np.linspace(0.01, 4.99, 200)
    found, gradient = medium.evaluate(np.column_stack([0 * at, at, 0 * at]), D_LINE)
    for low, high in ((0, 3), (3, 5), (5, 6)):
        spline = CubicSpline(heights[low : high + 1], n[low : high + 1], bc_type="natural")
        here = (at > heights[low]) & (at < heights[high])
        np.testing.assert_allclose(found[here], spline(at[here]), rtol=1e-14)
        np.testing.assert_allclose(gradient[here, 1], spline(at[here], 1), rtol=0, atol=1e-13)


@pytest.mark.parametrize("kinks", [[0.7], [0.0], [2.0], [np.nan]])
def test_bad_kinks(kinks):
    with pytest.raises(ValueError, match=r"kinks\[0\] is .* m; one of heights"):
        cpm.media.Layered([0.0, 1.0, 2.0], [1.3, 1.2, 1.1], kinks=kinks)
    with pytest.raises(ValueError, match="only CUBIC takes kinks"):
        cpm.media.Layered([0.0, 1.0, 2.0], [1.3, 1.2, 1.1], kinks=[1.0], interpolation="step")
