"""What a curved ray conserves (DESIGN sections 1 and 13): Bouguer, |p| = n, reversal, Fermat, ∇L = p."""

import numpy as np
import pytest
from oracles.cases import CASES

import cpm

LAYERED = ["layered-linear-squared", "layered-cubic"]
RUNS = [(name, m) for name in CASES for m in (("auto", "dopri5", "euler") if name != "homogeneous" else ("auto",))]
RTOL = {"euler": 1e-3, "dopri5": 1e-8, "auto": 1e-8}


def run(case, method, **options):
    options.setdefault("length", case.length)
    return cpm.trace(
        case.make(cpm), case.origins(), case.directions(), wavelength=550.0, method=method, rtol=RTOL[method], **options
    )


def start_index(case):
    """n at the case's origin."""
    return np.sqrt(case.field(np.array(case.origin))[0])


@pytest.mark.parametrize("name", LAYERED)
@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_bouguer_planar(name, method):
    """n sinθ to the layers' normal is conserved, and the plane of the ray too: p across `up` is constant."""
    case = CASES[name]
    rays = run(case, method)
    d = case.directions() / np.linalg.norm(case.directions(), axis=1, keepdims=True)
    across = start_index(case) * d * (1, 0, 1)
    np.testing.assert_allclose(rays.momentum * (1, 0, 1), across, rtol=0, atol=20 * RTOL[method])


@pytest.mark.parametrize(("name", "method"), RUNS)
def test_momentum_is_index(name, method):
    """|p| = n at the end, `drift` reports it, momentum = n × direction."""
    case = CASES[name]
    rays = run(case, method)
    n = np.array([np.sqrt(case.field(r)[0]) for r in rays.position])
    size = np.linalg.norm(rays.momentum, axis=1)
    limit = 10 * RTOL[method] * np.maximum(rays.steps, 1) + 1e-12
    assert np.all(np.abs(size - n) / n <= limit)
    assert np.all(rays.drift <= limit)
    np.testing.assert_allclose(rays.momentum / size[:, None], rays.direction, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("name", "method"), RUNS)
def test_reversal(name, method):
    """Back along the end's opposite direction for the same length: home, and the same optical path."""
    case = CASES[name]
    there = run(case, method)
    back = cpm.trace(
        case.make(cpm),
        there.position,
        -there.direction,
        wavelength=550.0,
        length=case.length,
        method=method,
        rtol=RTOL[method],
    )
    limit = 20 * RTOL[method] * case.length + 1e-12
    assert np.max(np.linalg.norm(back.position - case.origins(), axis=1)) <= limit
    np.testing.assert_allclose(back.optical_path, there.optical_path, rtol=0, atol=limit)


@pytest.mark.parametrize("name", ["linear-squared", "linear", "layered-cubic", "grid-cubic"])
def test_fermat(name):
    """Optical path of the traced curve is stationary: a bent neighbour with the same ends differs by O(ε²)."""
    case, count = CASES[name], 4001
    paths = run(case, "auto", path=count).paths[:3]
    t = np.linspace(0, 1, count)
    bend = np.sin(np.pi * t)[:, None] * np.array([0.3, -0.5, 0.8])

    def optical(path):
        middle = 0.5 * (path[1:] + path[:-1])
        n = np.sqrt([case.field(r)[0] for r in middle])
        return np.sum(n * np.linalg.norm(np.diff(path, axis=0), axis=1))

    for path in paths:
        e = 1e-3 * case.length
        slope = (optical(path + e * bend) - optical(path - e * bend)) / (2 * e)
        curvature = (optical(path + e * bend) - 2 * optical(path) + optical(path - e * bend)) / e**2
        assert abs(slope) < 5e-6
        assert curvature > 0.1  # these short paths are minima: the test can fail


@pytest.mark.parametrize("name", ["linear-squared", "linear", "layered-linear-squared", "layered-cubic", "grid-cubic"])
def test_momentum_is_gradient_of_optical_path(name):
    """Eikonal: between the ends of neighbouring rays from one point, ΔL = p·Δr."""
    case, angle = CASES[name], 1e-4
    d = np.array(case.towards) / np.linalg.norm(case.towards)
    side = np.cross(d, (0.3, 0.2, 0.9))
    side /= np.linalg.norm(side)
    fan = [d - angle * side, d, d + angle * side]
    rays = cpm.trace(case.make(cpm), [case.origin] * 3, fan, wavelength=550.0, until=case.plane, rtol=1e-11)
    moved = rays.position[2] - rays.position[0]
    assert rays.optical_path[2] - rays.optical_path[0] == pytest.approx(rays.momentum[1] @ moved, abs=2e-8)
    assert np.linalg.norm(moved) > 1e-4


@pytest.mark.parametrize("method", ["auto", "exact"])
def test_homogeneous_runs_no_integrator(method):
    """No gradient evaluations and no drift in a homogeneous medium."""
    rays = (
        run(CASES["homogeneous"], "auto")
        if method == "auto"
        else cpm.trace(
            cpm.media.Homogeneous(1.33), [(0, 0, 0)], [(1, 2, 3)], wavelength=550.0, length=4.0, method=method
        )
    )
    assert np.all(rays.evaluations == 0)
    assert np.all(rays.drift == 0)


def test_origin_shift_changes_nothing():
    """Moving medium and rays by a power of two metres changes results by rounding only."""
    shift = np.array([1024.0, -2048.0, 512.0])
    at = np.array([(0.5, 1.0, 0.0)])
    ends = [
        cpm.trace(
            cpm.media.LinearSquared(1.69, gradient=(0.03, -0.1, 0.02), origin=s),
            at + s,
            [(0.4, -0.6, 0.1)],
            wavelength=550.0,
            length=5.0,
        ).position
        - s
        for s in (np.zeros(3), shift)
    ]
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=4 * np.spacing(2048.0))
