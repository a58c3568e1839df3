"""The oracles against each other: closed forms, DOP853 in σ, DOP853 in arc length, differences.

Runs without the library, so a failure here is the oracle's own.
"""

import dataclasses

import numpy as np
import pytest
from oracles import closed_forms as forms
from oracles import fields, hits, layers, rays, splines
from oracles.cases import CASES

ORIGIN = np.array([0.3, 1.0, -0.4])
DIRECTIONS = [(1, 0, 0), (0.6, 0.8, 0.2), (0.3, -0.9, 0.1), (0, 1, 0), (-0.2, -0.5, 0.7)]
PLANE = ((0, 0, 0), (0.2, 1.0, 0.1))


def close(a, b, tolerance):
    """Position, momentum, arc and optical path of two rays within `tolerance`."""
    for name in ("position", "momentum", "arc_length", "optical_path"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=tolerance, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("gradient", [(0, -0.10, 0), (0.05, 0.2, -0.1), (0, 1e-9, 0)])
def test_parabola(gradient, direction):
    medium = fields.LinearSquared(1.69, gradient, (0.1, 0.2, 0.3))
    closed = forms.linear_squared(1.69, gradient, (0.1, 0.2, 0.3), ORIGIN, direction, length=5.0)
    close(closed, rays.trace(medium, ORIGIN, direction, length=5.0), 3e-12)


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("gradient", [(0, -0.05, 0), (0.05, 0.1, -0.1), (0, 1e-9, 0)])
def test_catenary(gradient, direction):
    medium = fields.Linear(1.3, gradient, (0.1, 0.2, 0.3))
    closed = forms.linear(1.3, gradient, (0.1, 0.2, 0.3), ORIGIN, direction, length=5.0)
    close(closed, rays.trace(medium, ORIGIN, direction, length=5.0), 3e-12)


@pytest.mark.parametrize("direction", [(0.3, -0.9, 0.1), (0.6, 0.1, 0.2)])
def test_planes(direction):
    square = fields.LinearSquared(1.69, (0, -0.1, 0))
    closed = forms.linear_squared(1.69, (0, -0.1, 0), (0, 0, 0), ORIGIN, direction, until=PLANE)
    close(closed, rays.trace(square, ORIGIN, direction, until=PLANE), 1e-11)
    linear = fields.Linear(1.3, (0, -0.05, 0))
    closed = forms.linear(1.3, (0, -0.05, 0), (0, 0, 0), ORIGIN, direction, until=PLANE, reach=100.0)
    close(closed, rays.trace(linear, ORIGIN, direction, until=PLANE), 1e-11)


def test_stable_arc_length():
    """A tiny gradient: the textbook closed form loses nine digits, ours none (Taylor series as the judge)."""
    p0, sigma = np.array([1.2, 0.3, 0.1]), 1.0
    for size in (1e-3, 1e-6, 1e-9, 1e-14):
        g = size * np.array([0.0, 1.0, 0.0])
        n, s = np.linalg.norm(p0), 0.5 * size
        u = (p0 @ g) / size / n**2 * s  # |p|²/n² = 1 + 2uσ + (s/n)²σ²
        w = (s / n) ** 2
        series = n * (sigma + u * sigma**2 / 2 + (w - u * u) * sigma**3 / 6 - (u * w - u**3) * sigma**4 / 8)
        assert forms.parabola_arc_length(p0, g, sigma) == pytest.approx(series, rel=1e-13 if size < 1e-3 else 1e-12)


def test_two_formulations():
    """DOP853 over σ with events, and over arc length, agree on a field with curvature."""
    medium = fields.OfHeight(lambda h: (1.3 + 0.2 * np.tanh(h), 0.2 / np.cosh(h) ** 2))
    lengths = np.linspace(0, 4, 5)
    samples = rays.sample_by_arc(medium, (0, -0.5, 0), (1, 0.3, 0.2), lengths)
    for length, position in zip(lengths, samples, strict=True):
        np.testing.assert_allclose(
            rays.trace(medium, (0, -0.5, 0), (1, 0.3, 0.2), length=length).position, position, rtol=0, atol=2e-12
        )


@pytest.mark.parametrize("direction", [(1, 0.2, 0), (1, -0.4, 0.3), (0.1, 1, 0), (1, 0.0, 0)])
def test_layers_of_parabolas(direction):
    heights, n = np.array([0, 0.5, 0.8, 1.6, 3.0]), np.array([1.30, 1.27, 1.29, 1.2, 1.22])

    def profile(h):
        i = int(np.clip(np.searchsorted(heights, h) - 1, 0, len(heights) - 2))
        slope = (n[i + 1] ** 2 - n[i] ** 2) / (heights[i + 1] - heights[i])
        index = np.sqrt(n[i] ** 2 + slope * (h - heights[i]))
        return index, slope / (2 * index)

    closed = layers.linear_squared(heights, n, (0, 1, 0), (0, 0, 0), (0, 1.1, 0), direction, length=1.5)
    kinked = fields.OfHeight(profile, max_step=0.002)
    close(closed, rays.trace(kinked, (0, 1.1, 0), direction, length=1.5), 1e-6)


def test_steps():
    """Snell through discrete layers, and total reflection at the last."""
    edges, n = [0.0, 1.0], [1.5, 1.3, 1.0]
    ray = layers.step(edges, n, (0, 1, 0), (0, 0, 0), (0, -1, 0), (np.sin(0.3), np.cos(0.3), 0), length=10.0)
    assert ray.direction[0] == pytest.approx(1.5 * np.sin(0.3), rel=1e-14)
    ray = layers.step(edges, n, (0, 1, 0), (0, 0, 0), (0, -1, 0), (np.sin(1.0), np.cos(1.0), 0), length=15.0)
    np.testing.assert_allclose(ray.direction, (np.sin(1.0), -np.cos(1.0), 0), rtol=1e-14)


def _bump(shape, origin, spacing):
    axes = [o + s * np.arange(k) for o, s, k in zip(origin, spacing, shape, strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    return 1.2 + 0.2 * np.exp(-(x**2 + 1.5 * y**2 + z**2 + 0.5 * x * y) / 0.5)


@pytest.mark.parametrize("make", [splines.grid_linear, splines.grid_cubic])
def test_grid_gradients(make):
    """Interpolates the samples, and the gradient is the difference quotient of n²."""
    origin, spacing = (-2, -2, -2), (0.2, 0.25, 0.2)
    values = _bump((21, 17, 21), origin, spacing)
    field = make(values, origin, spacing)
    node = np.array(origin) + np.array(spacing) * (9, 8, 7)
    assert np.sqrt(field(node + 1e-13)[0]) == pytest.approx(values[9, 8, 7], rel=1e-11)
    for point in np.random.default_rng(1).uniform(-1, 1, (8, 3)):
        np.testing.assert_allclose(
            field(point)[1], fields.numerical_half_gradient(field, point, 1e-6), rtol=0, atol=2e-9
        )


def test_spline_of_height():
    heights = np.linspace(-2, 2, 401)
    field = splines.layered_cubic(heights, 1.2 + 0.1 * np.tanh(heights))
    n_squared, half_gradient = field(np.array([0.4, 0.3333, 9.0]))
    n = 1.2 + 0.1 * np.tanh(0.3333)
    assert n_squared == pytest.approx(n * n, abs=1e-10)
    assert half_gradient[1] == pytest.approx(n * 0.1 / np.cosh(0.3333) ** 2, abs=1e-7)


@pytest.mark.parametrize("name", ["homogeneous", "linear-squared", "linear", "layered-linear-squared"])
def test_cases_closed_forms(name):
    """Each case's closed form is the field's DOP853 ray (layers: to the kinks' own error)."""
    case = CASES[name]
    tolerance = 5e-6 if name.startswith("layered") else 5e-12
    ends, numeric = case.ends(), rays.trace_many(case.field, case.origins(), case.directions(), length=case.length)
    np.testing.assert_allclose(ends.position, numeric.position, rtol=0, atol=tolerance)
    np.testing.assert_allclose(ends.optical_path, numeric.optical_path, rtol=0, atol=tolerance)


@pytest.mark.parametrize("name", CASES)
def test_cases_reach_their_plane(name):
    case = CASES[name]
    end = case.plane_end()
    assert (end.position - np.array(case.plane[0])) @ np.array(case.plane[1]) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("name", ["layered-cubic", "grid-linear", "grid-cubic"])
def test_cases_converged(name):
    """Half the oracle's step bound changes nothing beyond 1e-10: what the tests may ask."""
    case = CASES[name]
    finer = dataclasses.replace(case.field, max_step=case.field.max_step / 2)
    numeric = rays.trace_many(finer, case.origins(), case.directions(), length=case.length)
    np.testing.assert_allclose(case.ends().position, numeric.position, rtol=0, atol=2e-10)


@pytest.mark.parametrize("seed", range(6))
def test_hits_on_parabolas(seed):
    """Polynomial roots against the DOP853 ray: distances to a triangle's plane and to a sphere vanish there."""
    rng = np.random.default_rng(seed)
    origin, direction, g = rng.uniform(-0.3, 0.3, 3), rng.normal(size=3), np.array((0.3, -0.8, 0.2))
    medium = fields.LinearSquared(2.2, tuple(g))
    p0 = np.sqrt(medium(origin)[0]) * direction / np.linalg.norm(direction)
    sigma = hits.sphere(origin, p0, g, np.zeros(3), 1.0)
    arc = forms.parabola_arc_length(p0, g, sigma)
    ray = rays.trace(medium, origin, direction, length=arc)
    assert np.linalg.norm(ray.position) == pytest.approx(1.0, abs=1e-11)
    early = rays.sample_by_arc(medium, origin, direction, np.linspace(0, 0.999 * arc, 50))
    assert np.all(np.linalg.norm(early, axis=1) < 1)
    a, b, c = 3 * np.array((1, 0, 0)), 3 * np.array((0, 1, 0)), 3 * np.array((0, 0, 1.0))
    plane = rays.trace(medium, origin, (1, 1, 1), until=(a, (1, 1, 1)))
    p0 = np.sqrt(medium(origin)[0]) * np.ones(3) / np.sqrt(3)
    sigma = hits.triangle(origin, p0, g, a, b, c)
    np.testing.assert_allclose(forms.parabola(origin, p0, g, sigma)[0], plane.position, rtol=0, atol=1e-11)
