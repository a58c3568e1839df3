"""Sums of media: refractivities and gradients add up, each term at its own dispersion; rays; kinks of every term."""

import numpy as np
import pytest
from oracles import rays, shells
from oracles.fields import OfIndex
from scipy.interpolate import CubicSpline

import cpm

HEIGHTS = np.linspace(-2, 2, 9)
N = 1.3 + 0.1 * np.tanh(HEIGHTS)
POINTS = np.random.default_rng(1).uniform(-1.5, 1.5, (100, 3))


def terms():
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, 7)] * 3, indexing="ij")
    return [cpm.media.Layered(HEIGHTS, N), cpm.media.Expression("1 + 0.05*exp(-x*x - z*z)"),
            cpm.media.Grid(1.1 + 0.05 * np.exp(-x * x - y * y - z * z), origin=(-1, -1, -1), spacing=1 / 3),
            cpm.media.LinearSquared(1.69, gradient=(0.02, -0.1, 0.03)), cpm.media.Linear(1.2, gradient=(0.01, 0.02, 0)),
            cpm.media.Homogeneous(1.05), cpm.media.Layered(HEIGHTS, N, radius=4.0),
            cpm.media.Layered(HEIGHTS, N, radius=4.0, interpolation="linear-squared")]


def test_refractivities_add():
    parts = terms()
    n, gradient = sum(parts).evaluate(POINTS)
    each = [part.evaluate(POINTS) for part in parts]
    np.testing.assert_allclose(n, 1 + sum(e[0] - 1 for e in each), rtol=1e-14)
    np.testing.assert_allclose(gradient, sum(e[1] for e in each), rtol=0, atol=1e-14)


def test_flat():
    """(a + b) + (c + d): four terms, the same bits in any grouping."""
    a, b, c, d = terms()[:4]
    grouped, listed = (a + b) + (c + d), cpm.media.Sum(a, b, c, d)
    assert len(grouped.terms) == 4
    for p, q in zip(grouped.evaluate(POINTS), listed.evaluate(POINTS), strict=True):
        np.testing.assert_array_equal(p, q)


def test_dispersion_of_each_term():
    """Cauchy on a gas, Sellmeier on n², a table, a formula's own wavelength, and none at all, side by side."""
    tabulated = cpm.dispersion.Tabulated([300, 500, 900], [1.6, 1.55, 1.5])
    parts = [cpm.media.Linear(1.2, gradient=(0.01, 0.02, 0), dispersion=cpm.dispersion.Cauchy(1.5, 0.02)),
             cpm.media.LinearSquared(1.69, gradient=(0.02, -0.1, 0.03), dispersion="BK7"),
             cpm.media.Layered(HEIGHTS, N, dispersion=tabulated), cpm.media.Expression("1 + 0.1*x*x*500/wavelength"),
             cpm.media.Homogeneous("F2"), cpm.media.Layered(HEIGHTS, N)]
    total = sum(parts)
    for wavelength in (420.0, 587.5618, 690.0):
        each = [part.evaluate(POINTS, wavelength) for part in parts]
        n, gradient = total.evaluate(POINTS, wavelength)
        np.testing.assert_allclose(n, 1 + sum(e[0] - 1 for e in each), rtol=1e-14)
        np.testing.assert_allclose(gradient, sum(e[1] for e in each), rtol=0, atol=1e-14)
    nested = cpm.media.Sum(total, parts[5])
    np.testing.assert_allclose(nested.evaluate(POINTS, 450)[0], 1 + sum(p.evaluate(POINTS, 450)[0] - 1 for p in [*parts, parts[5]]), rtol=1e-14)
    with pytest.raises(ValueError, match="valid in"):
        total.evaluate(POINTS, 100.0)


@pytest.mark.parametrize(("method", "options", "within"), [("dopri5", {"rtol": 1e-9}, 1e-8), ("rk4", {"step": 0.005}, 1e-8),
                                                           ("euler", {"rtol": 1e-5}, 1e-3)])
def test_rays(method, options, within):
    medium = cpm.media.Linear(1.2, gradient=(0.01, 0.05, 0)) + cpm.media.Expression("1 + 0.05*exp(-x*x - z*z)")

    def field(r):
        bump = 0.05 * np.exp(-r[0] ** 2 - r[2] ** 2)
        return 1.2 + 0.01 * r[0] + 0.05 * r[1] + bump, (0.01 - 2 * r[0] * bump, 0.05, -2 * r[2] * bump)

    origins, directions = np.random.default_rng(3).uniform(-1, 1, (2, 10, 3))
    found = cpm.trace(medium, origins, directions, wavelength=550, length=3.0, method=method, **options)
    expected = [rays.trace(OfIndex(field), o, d, length=3.0).position for o, d in zip(origins, directions, strict=True)]
    assert np.max(np.linalg.norm(found.position - expected, axis=1)) < within


def test_kinks_of_every_term():
    """Steps end at the faces of a trilinear grid and at heights of piecewise n², in the sum as in each alone."""
    values = np.random.default_rng(5).uniform(1.0, 1.1, (9, 9, 9))
    grid = cpm.media.Grid(values, origin=(-2, -2, -2), spacing=0.5, interpolation="linear")
    layers = cpm.media.Layered(HEIGHTS, N, interpolation="linear-squared")
    origins, directions = np.random.default_rng(6).uniform(-1, 1, (2, 20, 3))
    loose, tight = (cpm.trace(grid + layers, origins, directions, wavelength=550, length=2.0, rtol=rtol, max_step=step)
                    for rtol, step in ((1e-7, None), (1e-11, 2e-3)))
    assert np.max(np.linalg.norm(loose.position - tight.position, axis=1)) < 2e-6
    assert loose.evaluations.mean() < 2000


def test_atmosphere_and_hot_road():
    """The Earth's air in shells and a formula for the road, together: against an ODE at 1e-12."""
    heights, radius = np.linspace(-50, 2000, 400), 6.4e6
    air = 2.77e-4 * np.exp(-heights / 8000)
    medium = cpm.media.Layered(heights, 1 + air, radius=radius) + cpm.media.Expression("1 + e*exp(-y/d)", e=-1.4e-5, d=0.05)
    spline = CubicSpline(heights, air, bc_type="natural")

    def field(r):
        h, out = shells.height(r, radius)
        road = -1.4e-5 * np.exp(-r[1] / 0.05)
        n = 1 + float(spline(h)) + road
        return n * n, n * (float(spline(h, 1)) * out + np.array([0, -road / 0.05, 0]))

    field.max_step = 2.0
    for angle in (-0.003, -0.001, 0.001):
        d = (np.cos(angle), np.sin(angle), 0)
        found = cpm.trace(medium, (0, 0.5, 0), d, wavelength=550, length=300.0, rtol=1e-10, max_step=5.0)
        assert np.linalg.norm(found.position[0] - rays.trace(field, (0, 0.5, 0), d, length=300.0).position) < 1e-6


def test_uniform_sums_are_straight():
    found = cpm.trace(cpm.media.Homogeneous(1.2) + cpm.media.Homogeneous(1.3), (0, 0, 0), (1, 0, 0), wavelength=550, length=2.0)
    assert found.method[0] == "exact" and found.evaluations[0] == 0 and found.optical_path[0] == pytest.approx(3.0)


def test_refused():
    a = cpm.media.Linear(1.2, gradient=(0, 0.1, 0))
    with pytest.raises(cpm.Error, match="step"):
        _ = a + cpm.media.Layered(HEIGHTS, N, interpolation="step")
    with pytest.raises(ValueError, match=r"terms\[1\] has bounds"):
        _ = a + cpm.media.Linear(1.2, gradient=(0, 0.1, 0), bounds=cpm.Sphere((0, 0, 0), 1))
    with pytest.raises(TypeError):
        _ = a + 1.5
    with pytest.raises(ValueError, match="65 terms"):
        cpm.media.Sum(*[a] * 32, cpm.media.Sum(*[a] * 33))
    with pytest.raises(ValueError, match="no terms"):
        cpm.media.Sum()
    with pytest.raises(cpm.Error, match="no closed form"):
        cpm.trace(a + a, (0, 0, 0), (1, 0, 0), wavelength=550, length=1.0, method="exact")


def test_in_a_scene():
    """A bounded sum; with terms that disperse, bundles split."""
    ball = cpm.media.Sum(cpm.media.Homogeneous("BK7"), cpm.media.Expression("1 - 0.05*r"), bounds=cpm.Sphere((0, 0, 0), 1))
    scene = cpm.Scene()
    scene.add_medium(ball)
    scene.add_mesh([(-5, -5, 3), (5, -5, 3), (0, 5, 3)], [(0, 1, 2)], material=cpm.materials.Black())
    blue, red = (cpm.trace(scene, (0, 0.5, -3), (0, 0, 1), wavelength=w).position[0] for w in (420.0, 680.0))
    assert blue[1] < red[1] - 1e-3


@pytest.mark.parametrize("other", [cpm.media.Homogeneous(1.0), cpm.media.Linear(1.0, gradient=(0, 1e-12, 0))])
def test_a_centre_within_a_sum_is_a_centre(other):
    """1 + m/r² captures what comes below the impact 2√m and lets go what comes above it, in a sum as alone."""
    centre = cpm.media.Sources([(0, 0, 0)], 1.0, 2)
    far = 50.0
    for impact, status in ((1.9, cpm.RayStatus.CAPTURED), (2.1, cpm.RayStatus.ARRIVED)):
        sine = impact / ((1 + 1 / far**2) * far)
        for medium in (centre, centre + other):
            found = cpm.trace(medium, (-far, 0, 0), (np.sqrt(1 - sine**2), sine, 0), wavelength=550.0, length=100.0, rtol=1e-8)
            assert found.status[0] == status
            assert found.evaluations[0] < 5000
