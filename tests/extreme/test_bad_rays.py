"""Ray arguments that cannot be traced: ValueError (or TypeError) naming the first bad index, never a crash."""

import numpy as np
import pytest

import cpm


def trace(origins=((0, 0, 0),), directions=((1, 0, 0),), **options):
    medium = options.pop("medium", None) or cpm.media.LinearSquared(1.69, gradient=(0, -0.1, 0))
    options.setdefault("wavelength", 550.0)
    if "until" not in options:
        options.setdefault("length", 1.0)
    return cpm.trace(medium, origins, directions, **options)


def rows(bad, index, good, count=5):
    """(count, 3) of `good` with row `index` replaced."""
    out = np.tile(np.array(good, float), (count, 1))
    out[index] = bad
    return out


GOOD_O, GOOD_D = (0.0, 1.0, 0.0), (1.0, 0.2, 0.0)


@pytest.mark.parametrize("bad", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, -np.inf)])
def test_origins_not_finite(bad):
    with pytest.raises(ValueError, match=r"\b3\b"):
        trace(rows(bad, 3, GOOD_O), rows(GOOD_D, 0, GOOD_D))


@pytest.mark.parametrize("bad", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, 0)])
def test_directions_not_finite_or_zero(bad):
    with pytest.raises(ValueError, match=r"\b2\b"):
        trace(rows(GOOD_O, 0, GOOD_O), rows(bad, 2, GOOD_D))


def test_first_bad_index_is_named():
    """Of several bad rays, the first."""
    origins = rows(GOOD_O, 0, GOOD_O)
    origins[[2, 4]] = np.nan
    with pytest.raises(ValueError, match=r"\b2\b"):
        trace(origins, rows(GOOD_D, 0, GOOD_D))


@pytest.mark.parametrize(
    ("origins", "directions"),
    [
        (np.zeros((2, 2)), np.ones((2, 3))),
        (np.zeros((2, 3)), np.ones((3, 3))),
        (np.zeros((2, 3, 3)), np.ones((2, 3))),
        (np.zeros(4), np.ones(4)),
    ],
)
def test_wrong_shape(origins, directions):
    with pytest.raises(ValueError, match=r"shape|\(N, ?3\)"):
        trace(origins, directions)


def test_start_where_n_squared_is_not_positive():
    """n² = 1.69 − 0.1 y is negative above y = 16.9."""
    with pytest.raises(ValueError, match=r"\b1\b"):
        trace(rows((0, 17.0, 0), 1, GOOD_O), rows(GOOD_D, 0, GOOD_D))


@pytest.mark.parametrize(
    "options",
    [
        {"length": np.nan},
        {"length": -1.0},
        {"length": np.inf},
        {"length": np.ones(3)},
        {"wavelength": np.nan},
        {"wavelength": -550.0},
        {"wavelength": 0.0},
        {"rtol": 0.0},
        {"rtol": 1e-15},
        {"rtol": 2.0},
        {"rtol": np.nan},
        {"atol": -1.0},
        {"step": 0.0, "method": "dopri5"},
        {"step": np.nan, "method": "dopri5"},
        {"max_step": -1.0},
        {"max_evaluations": 0},
        {"method": "no-such-method"},
        {"error": "no-such-error"},
        {"backend": "no-such-backend"},
        {"precision": "no-such-precision"},
        {"until": ((0, 0, 0), (0, 0, 0))},
        {"until": ((0, np.nan, 0), (0, 1, 0))},
        {"path": -1},
    ],
    ids=str,
)
def test_options_out_of_range(options):
    """Every scalar out of its range is a ValueError that names the argument."""
    name = next(iter(options))
    with pytest.raises((ValueError, TypeError), match=name):
        trace([GOOD_O], [GOOD_D], **options)


def test_exactly_one_end():
    medium = cpm.media.Homogeneous(1.0)
    with pytest.raises((ValueError, TypeError), match=r"length|until"):
        cpm.trace(medium, [GOOD_O], [GOOD_D], wavelength=550.0)
    with pytest.raises((ValueError, TypeError), match=r"length|until"):
        cpm.trace(medium, [GOOD_O], [GOOD_D], wavelength=550.0, length=1.0, until=((0, 0, 0), (1, 0, 0)))


def test_no_rays():
    """Zero rays in, zero rays out."""
    rays = trace(np.zeros((0, 3)), np.zeros((0, 3)))
    assert rays.position.shape == (0, 3) and rays.status.shape == (0,)


@pytest.mark.parametrize("rtol", [1e-14, 1.0])
def test_tolerance_limits_are_accepted(rtol):
    rays = trace([GOOD_O], [GOOD_D], rtol=rtol, exclude=("exact",))
    assert np.all(np.isfinite(rays.position))
    assert rays.status[0] == cpm.RayStatus.ARRIVED
