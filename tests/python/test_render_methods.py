"""Every integrator of DESIGN section 3 in a picture, not only alone: the same photons and eye rays as by closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes

import cpm

OPTIONS = dict(size=(32, 24), photons=20_000, nearest=40, wavelengths=[620.0], seed=4, progress=False)
INTEGRATORS = {
    "auto": {"exclude": ("exact",), "rtol": 1e-8},
    "nystrom": {"rtol": 1e-8},
    "adams": {"rtol": 1e-8},
    "dopri5": {"rtol": 1e-8},
    "euler": {"rtol": 1e-3},
    "rk4": {"step": 0.2},
    "leapfrog": {"step": 0.02},
    "yoshida6": {"step": 0.2},
}


def picture(**integrator):
    """The curved room in catenaries: on these every method has an error; and what it counted."""
    medium = cpm.media.Linear(1.30, gradient=(0.0, -0.041, 0.0))
    image = cpm.render(scenes.room(medium, scenes.PAINTED).copy(**integrator), **OPTIONS)
    return image.data[..., 0].astype(float), image.stats


@pytest.fixture(scope="module")
def exact():
    data, stats = picture(method="exact")
    assert stats["photon_evaluations"] == 0 and stats["eye_evaluations"] == 0
    return data


@pytest.mark.parametrize("method", INTEGRATORS)
def test_same_picture(method, exact):
    """Within 1 % of the picture's root mean square of the exact one: the photon noise is the same, and 10 times as much."""
    named = {} if method == "auto" else {"method": method}
    data, stats = picture(**named, **INTEGRATORS[method])
    assert stats["photon_evaluations"] > 0 and stats["eye_evaluations"] > 0 and stats["photons_lost"] == 0
    assert np.sqrt(np.mean((data - exact) ** 2)) <= 0.01 * np.sqrt(np.mean(exact**2))


def test_it_can_fail(exact):
    """Steps of leapfrog 200 times as long miss that."""
    data, _ = picture(method="leapfrog", step=4.0)
    assert np.sqrt(np.mean((data - exact) ** 2)) > 0.01 * np.sqrt(np.mean(exact**2))
