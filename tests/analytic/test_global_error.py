"""`error="global"` brackets the true error: within 0.3 to 30 × for 95 % of the rays off by more than 1e-12 of their path."""
import numpy as np
import pytest
from oracles.cases import CASES

import cpm

TOLERANCES = 10.0 ** -np.arange(3.0, 11.0)
SMOOTH = [name for name, case in CASES.items() if case.closed is not None and case.smooth and name != "homogeneous"]


@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("method", ["nystrom", "adams", "dopri5"])
def test_global_error_brackets(name, method):
    """Over all tolerances together, against closed forms; the second run's evaluations are counted apart."""
    case = CASES[name]
    ends, inside = case.ends(), []
    for rtol in TOLERANCES:
        rays = cpm.trace(case.make(cpm), case.origins(), case.directions(), wavelength=550.0, length=case.length,
                         method=method, rtol=rtol, error="global")
        assert np.all(rays.error_evaluations > rays.evaluations)
        truth = np.linalg.norm(rays.position - ends.position, axis=1)
        counts = truth > 1e-12 * case.length
        ratio = rays.error_estimate[counts] / truth[counts]
        inside.extend((ratio >= 0.3) & (ratio <= 30))
    if inside:  # a parabola has no error to bracket
        assert np.mean(inside) >= 0.95, f"{np.mean(inside):.3f} of {len(inside)}"
