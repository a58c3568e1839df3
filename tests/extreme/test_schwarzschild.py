"""Light about a black hole in isotropic coordinates (DESIGN section 13): a formula whose index has a pole at r = M/2.

n = (1 + M/2r)³/(1 − M/2r): circular orbit at r = (1 + √3/2) M, unstable (errors grow by e^2π a turn); critical
impact 3√3 M.
"""

import numpy as np
import pytest
from oracles import fields
from oracles import rays as oracle

import cpm

HOLE = "(1 + M/(2*r))**3/(1 - M/(2*r))"
FAR, CRITICAL = 200.0, 3 * np.sqrt(3)
ENDS = (cpm.RayStatus.STEP_UNDERFLOW, cpm.RayStatus.EVALUATIONS_EXHAUSTED, cpm.RayStatus.CUTOFF, cpm.RayStatus.CAPTURED)


def index(r):
    u = 0.5 / r
    n = (1 + u) ** 3 / (1 - u)
    return n * n, -2 * n * n * (3 / (1 + u) + 1 / (1 - u)) * u / r


def trace(origin, direction, length, rtol=1e-10, **options):
    return cpm.trace(
        cpm.media.Expression(HOLE, M=1.0), origin, direction, wavelength=550.0, length=length, rtol=rtol, **options
    )


def aimed(excess):
    """From FAR, with n r sin φ = 3√3 (1 + excess)."""
    sine = CRITICAL * (1 + excess) / (np.sqrt(index(FAR)[0]) * FAR)
    return (-FAR, 0, 0), (np.sqrt(1 - sine**2), sine, 0)


@pytest.mark.parametrize(("precision", "rtol"), [("double", 1e-10), ("single", 1e-6)])
def test_unstable_orbit(precision, rtol):
    """One turn: back to within rtol × e^2π of its length; a start 1 % off goes where DOP853 says."""
    radius = 1 + np.sqrt(3) / 2
    turn = 2 * np.pi * radius
    found = trace((radius, 0, 0), (0, 1, 0), turn, rtol, precision=precision)
    assert found.status[0] == cpm.RayStatus.ARRIVED
    assert np.linalg.norm(found.position[0] - (radius, 0, 0)) < rtol * np.exp(2 * np.pi) * turn
    expected = oracle.trace(fields.OfRadius(index), (1.01 * radius, 0, 0), (0, 1, 0), length=turn)
    found = trace((1.01 * radius, 0, 0), (0, 1, 0), turn, rtol, precision=precision)
    assert np.linalg.norm(expected.position - (radius, 0, 0)) > 1.0
    assert np.linalg.norm(found.position[0] - expected.position) < rtol * np.exp(2 * np.pi) * turn


@pytest.mark.parametrize("excess", [1e-6, 1e-3, 1e-1])
def test_escapes(excess):
    """Above the critical impact it comes out again, with n r sin φ kept."""
    found = trace(*aimed(excess), 400.0)
    assert found.status[0] == cpm.RayStatus.ARRIVED and np.linalg.norm(found.position[0]) > 100
    bouguer = np.linalg.norm(np.cross(found.position[0], found.momentum[0]))
    assert bouguer == pytest.approx(CRITICAL * (1 + excess), rel=1e-9)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("excess", [-1e-6, -1e-3, -0.1, -1.0])
def test_falls_in(excess, precision):
    """Below it the ray winds to the horizon, where n is infinite: a status that says so, finite, within the bound."""
    found = trace(
        *aimed(excess), 400.0, 1e-9 if precision == "double" else 1e-6, precision=precision, max_evaluations=50_000
    )
    assert found.status[0] in ENDS and found.evaluations[0] <= 50_100
    assert np.linalg.norm(found.position[0]) == pytest.approx(0.5, abs=1e-3)
    for name in ("position", "direction", "momentum", "optical_path", "drift", "error_estimate"):
        assert np.all(np.isfinite(getattr(found, name))), name
