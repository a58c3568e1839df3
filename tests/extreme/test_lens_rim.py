"""Rays that start on the sphere of Luneburg's lens, where grad n jumps: fixed steps keep their order there.

Inside n² = 2 − r² the path is an ellipse: x = x₀ cos σ, z = sin σ + z₀ cos σ from (x₀, 0, z₀) along z, out again at σ = π/2.
"""
import numpy as np
import pytest
from scipy.integrate import quad

import cpm

#: method → order, steps over the whole way.
METHODS = {"leapfrog": (2, (16, 32, 64)), "yoshida6": (6, (8, 16, 32))}


def ellipse(offset, sigma):
    below = np.sqrt(1 - offset**2)
    return np.array([offset * np.cos(sigma), 0.0, np.sin(sigma) - below * np.cos(sigma)])


@pytest.mark.parametrize("part", [1.0, 0.8], ids=["to the other side", "to a place inside"])
@pytest.mark.parametrize("offset", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("method", METHODS)
def test_order_from_the_rim(method, offset, part):
    order, counts = METHODS[method]
    sigma = 0.5 * np.pi * part
    length = quad(lambda s: np.sqrt(2 - ellipse(offset, s) @ ellipse(offset, s)), 0, sigma, epsabs=1e-13)[0]
    errors = []
    for count in counts:
        found = cpm.trace(cpm.media.Luneburg(1.0), [ellipse(offset, 0)], [(0, 0, 1)], wavelength=550.0, length=length,
                          method=method, step=length / count)
        assert found.status[0] == cpm.RayStatus.ARRIVED
        errors.append(np.linalg.norm(found.position[0] - ellipse(offset, sigma)))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(slopes - order) < 0.4), (errors, slopes)
