"""Media that cannot be: refused when made, with the index of the first bad sample (DESIGN section 2)."""

import numpy as np
import pytest

import cpm

H = np.linspace(0, 4, 5)
N = np.array([1.3, 1.28, 1.25, 1.21, 1.2])


def changed(array, index, value):
    out = np.array(array, float)
    out[index] = value
    return out


@pytest.mark.parametrize("n", [np.nan, np.inf, 0.0, -1.0])
def test_homogeneous(n):
    with pytest.raises(ValueError, match="n"):
        cpm.media.Homogeneous(n)


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, -0.5])
@pytest.mark.parametrize("interpolation", ["linear-squared", "cubic", "step"])
def test_layered_index(value, interpolation):
    with pytest.raises(ValueError, match=r"\b3\b"):
        cpm.media.Layered(H, changed(N, 3, value), interpolation=interpolation)


@pytest.mark.parametrize(("index", "value"), [(2, np.nan), (2, 0.5), (2, 1.0)])
def test_layered_heights_increase(index, value):
    """Heights are finite and increase strictly; the first that does not is named."""
    with pytest.raises(ValueError, match=r"\b2\b"):
        cpm.media.Layered(changed(H, index, value), N, interpolation="cubic")


@pytest.mark.parametrize("value", [np.nan, -np.inf, 0.0, -2.0])
@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_grid_sample(value, interpolation):
    values = changed(np.full((4, 5, 6), 1.3), (1, 2, 3), value)
    with pytest.raises(ValueError, match=r"1, ?2, ?3"):
        cpm.media.Grid(values, origin=(0, 0, 0), spacing=(1, 1, 1), interpolation=interpolation)


@pytest.mark.parametrize("spacing", [(0, 1, 1), (1, -1, 1), (1, 1, np.nan)])
def test_grid_spacing(spacing):
    with pytest.raises(ValueError, match="spacing"):
        cpm.media.Grid(np.full((4, 5, 6), 1.3), origin=(0, 0, 0), spacing=spacing)


@pytest.mark.parametrize(
    "make",
    [
        lambda m: m.LinearSquared(np.nan, gradient=(0, 1, 0)),
        lambda m: m.LinearSquared(1.0, gradient=(0, np.inf, 0)),
        lambda m: m.LinearSquared(1.0, gradient=(0, 1)),
        lambda m: m.LinearSquared(-1.0, gradient=(0, 0, 0)),
        lambda m: m.Linear(np.nan, gradient=(0, 1, 0)),
        lambda m: m.Linear(1.0, gradient=(np.nan, 1, 0)),
        lambda m: m.Layered(H, N[:-1], interpolation="cubic"),
        lambda m: m.Layered(H, N, up=(0, 0, 0), interpolation="cubic"),
        lambda m: m.Layered([], [], interpolation="cubic"),
        lambda m: m.Layered(H, N, interpolation="no-such"),
        lambda m: m.Grid(np.full((4, 5), 1.3), origin=(0, 0, 0), spacing=(1, 1, 1)),
        lambda m: m.Grid(np.zeros((0, 4, 4)), origin=(0, 0, 0), spacing=(1, 1, 1)),
        lambda m: m.Grid(np.full((4, 4, 4), 1.3), origin=(0, 0, 0), spacing=(1, 1, 1), interpolation="no-such"),
    ],
)
def test_other_nonsense(make):
    with pytest.raises((ValueError, TypeError)):
        make(cpm.media)


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, -1.0, 1e200])
@pytest.mark.parametrize("kind", ["Luneburg", "Eaton", "Fisheye"])
def test_radius(kind, value):
    with pytest.raises(ValueError, match="radius is"):
        getattr(cpm.media, kind)(*((1.5, value) if kind == "Fisheye" else (value,)))


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda m: m.Parabolic(0.0, 0.1), "n is 0"),
        (lambda m: m.Parabolic(np.nan, 0.1), "n is nan"),
        (lambda m: m.Parabolic(1.5, -0.1), "alpha is -0.1"),
        (lambda m: m.Parabolic(1.5, 0.1, axis=(0, 0, 0)), "axis"),
        (lambda m: m.Parabolic(1.5, 0.1, axis=(0, np.inf, 0)), "axis"),
        (lambda m: m.Parabolic(1.5, 0.1, origin=(0, 0)), "origin"),
        (lambda m: m.Fisheye(-1.0, 1.0), "n is -1"),
        (lambda m: m.Luneburg(1.0, center=(0, np.nan, 0)), "center"),
        (lambda m: m.Sources([], 1.0, 2), "centers"),
        (lambda m: m.Sources([(0, 0)], 1.0, 2), "centers"),
        (lambda m: m.Sources([(0, 0, 0), (1, 0, np.nan)], 1.0, 2), r"centers\[1, 2\] is nan"),
        (lambda m: m.Sources([(0, 0, 0)] * 3, [1.0, 2.0, np.inf], 2), r"strengths\[2\] is inf"),
        (lambda m: m.Sources([(0, 0, 0)] * 2, [1.0, 2.0, 3.0], 2), "strengths has shape"),
        (lambda m: m.Sources([(0, 0, 0)], 1.0, 0), r"exponent\[0\] is 0"),
        (lambda m: m.Sources([(0, 0, 0)] * 2, 1.0, [2, -1]), r"exponent\[1\] is -1"),
        (lambda m: m.Sources([(0, 0, 0)], 1.0, 2, directions=[(0, 0, np.nan)]), "directions"),
        (lambda m: m.Sources([(0, 0, 0)] * 3, 1.0, 2, directions=[(0, 0, 1)] * 2), "directions has shape"),
    ],
)
def test_lenses_and_sources(make, names):
    """The message names the argument and its value."""
    with pytest.raises(ValueError, match=names):
        make(cpm.media)


def test_weak_fibre_is_straight():
    """α = 0 is a homogeneous medium; sources of no strength are none."""
    for medium, n in ((cpm.media.Parabolic(1.5, 0.0), 1.5), (cpm.media.Sources([(0, 0, 0)] * 2, 0.0), 1.0)):
        rays = cpm.trace(medium, [(0, 0, 0)], [(3, 0, 4)], wavelength=550.0, length=5.0, method="dopri5")
        np.testing.assert_allclose(rays.position[0], (3, 0, 4), rtol=1e-15)
        assert rays.optical_path[0] == pytest.approx(5 * n, rel=1e-15) and rays.evaluations[0] == 0
