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
