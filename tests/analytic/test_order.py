"""Observed order of the fixed-step methods (`step=`), on smooth media that are not `LinearSquared`.

On n² linear every order ≥ 2 is exact, so `Linear` serves (analytic), and a cubic table of tanh,
whose derivatives jump only at 1e-2 m intervals and by little.  Order is the slope of log(error)
over log(step) between steps where the error is far above rounding.
"""

import numpy as np
import pytest
from oracles import central, closed_forms, rays

import cpm

MEDIA = {}
GRADIENT, ORIGIN, DIRECTION, LENGTH = (0.1, -0.4, 0.2), (0.0, 0.2, 0.0), (0.6, 0.7, -0.3), 4.0
MEDIA["linear"] = (
    lambda: cpm.media.Linear(1.5, gradient=GRADIENT),
    lambda: closed_forms.linear(1.5, GRADIENT, (0, 0, 0), ORIGIN, DIRECTION, length=LENGTH),
)


def _tanh(h):
    return 1.3 + 0.2 * np.tanh(h)


def _smooth_reference():
    from oracles.fields import OfHeight

    field = OfHeight(lambda h: (_tanh(h), 0.2 / np.cosh(h) ** 2), max_step=0.1)
    return rays.trace(field, ORIGIN, DIRECTION, length=LENGTH)


_HEIGHTS = np.linspace(-14, 14, 5601)
MEDIA["layered-cubic"] = (
    lambda: cpm.media.Layered(_HEIGHTS, _tanh(_HEIGHTS), up=(0, 1, 0), interpolation="cubic"),
    _smooth_reference,
)
_LENS = (2.0, 6.0, (0.1, -0.2, 0.3))
MEDIA["parabolic"] = (
    lambda: cpm.media.Parabolic(1.5, 0.3, axis=(1, 0.2, 0)),
    lambda: central.parabolic(1.5, 0.3, (1, 0.2, 0), (0, 0, 0), ORIGIN, DIRECTION, length=LENGTH),
)
MEDIA["fisheye"] = (
    lambda: cpm.media.Fisheye(*_LENS),
    lambda: central.fisheye(*_LENS, ORIGIN, DIRECTION, length=LENGTH),
)

#: method → (order, steps in metres).
METHODS = {
    "euler": (2, [0.08, 0.04, 0.02, 0.01]),
    "rk4": (4, [0.5, 0.25, 0.125]),
    "dopri5": (5, [1.0, 0.5, 0.25]),
    "leapfrog": (2, [0.1, 0.05, 0.025]),
    "yoshida6": (6, [1.0, 0.5, 0.25]),
    "nystrom6": (6, [1.0, 0.5, 0.25]),
    "nystrom8": (8, [4.0, 2.0, 1.0]),
}
#: What stands behind a variant: the pair of `nystrom` is chosen by the tolerance.
OPTIONS = {"nystrom6": {"method": "nystrom", "rtol": 1e-2}, "nystrom8": {"method": "nystrom", "rtol": 1e-9}}


def observed(make, reference, method, steps):
    """Errors (K,) at the end for each step, and the slopes between them."""
    errors = []
    for step in steps:
        rays_ = cpm.trace(make(), [ORIGIN], [DIRECTION], wavelength=550.0, length=LENGTH, step=step,
                          **OPTIONS.get(method, {"method": method}))
        assert rays_.status[0] == cpm.RayStatus.ARRIVED
        errors.append(np.linalg.norm(rays_.position[0] - reference.position))
    errors = np.array(errors)
    return errors, np.diff(np.log(errors)) / np.diff(np.log(steps))


#: Eighth order needs an analytic field: the table's third derivative jumps by 1e-10.
CASES = [(medium, method) for medium in MEDIA for method in METHODS if (medium, method) != ("layered-cubic", "nystrom8")]


@pytest.mark.parametrize(("medium", "method"), CASES)
def test_order(medium, method):
    """The mean slope is the method's order, less what the coarsest step still owes."""
    order, steps = METHODS[method]
    make, reference = MEDIA[medium]
    errors, slopes = observed(make, reference(), method, steps)
    assert errors[-1] > 1e-12, f"at rounding: {errors}"
    more = 2.0 if (medium, method) == ("parabolic", "nystrom8") else 1.0  # a linear system: few conditions of order 9
    assert order - 0.4 < np.mean(slopes) < order + more, f"errors {errors}, slopes {slopes}"


@pytest.mark.parametrize("method", ["euler", "dopri5", "nystrom", "adams", "leapfrog", "yoshida6"])
def test_linear_squared_is_exact(method):
    """Order ≥ 2 in σ has no error on n² linear, at any step (a Richardson-extrapolated Euler included)."""
    rays_ = cpm.trace(
        cpm.media.LinearSquared(1.69, gradient=(0, -0.1, 0)), [ORIGIN], [DIRECTION], wavelength=550.0,
        until=((2.0, 0, 0), (1, 0, 0)), method=method, step=0.5,
    )  # fmt: skip
    expected = closed_forms.linear_squared(
        1.69, (0, -0.1, 0), (0, 0, 0), ORIGIN, DIRECTION, until=((2.0, 0, 0), (1, 0, 0))
    )
    np.testing.assert_allclose(rays_.position[0], expected.position, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", ["euler", "dopri5", "nystrom", "adams"])
def test_adaptive_error_follows_tolerance(method):
    """Over the tolerances the error falls with rtol: as itself, or as its square where Euler's step is ∝ rtol."""
    make, reference = MEDIA["linear"]
    tolerances = [1e-2, 1e-3, 1e-4] if method == "euler" else [1e-4, 1e-6, 1e-8, 1e-10]
    errors = []
    for rtol in tolerances:
        r = cpm.trace(make(), [ORIGIN], [DIRECTION], wavelength=550.0, length=LENGTH, method=method, rtol=rtol)
        errors.append(np.linalg.norm(r.position[0] - reference().position) / LENGTH)
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    assert 0.6 < slope < (2.3 if method == "euler" else 1.6), f"errors {errors}"
