"""cpm.atmosphere.refraction: PAL's table, the Hohenkerk–Sinclair integral by SciPy, ODEs, and a closed form."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from oracles import atmosphere as oracle
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from cpm.atmosphere import HotSurface, Inversion, Polytropic, Profile, USStandard1976, read_sounding, refraction

STANDARD = Polytropic(288.15, 101325.0)


def seconds(*arguments, **options):
    return 3600 * refraction(*arguments, **options)


def allowed(zenith):
    """The figures to reach, arc seconds; a hundredth of them is what is asserted."""
    return 0.01 if zenith <= 80 else 0.1 if zenith <= 89 else 0.5


@pytest.mark.parametrize("zenith", oracle.PAL)
def test_oracle_is_pal(zenith):
    assert oracle.HohenkerkSinclair().refraction(zenith) == pytest.approx(oracle.PAL[zenith], abs=0.0051)


@pytest.mark.parametrize("zenith", [0.0, 10.0, 45.0, 60.0, 75.0, 80.0, 85.0, 88.0, 89.0, 89.5, 89.9, 89.99, 90.0])
def test_hohenkerk_sinclair(zenith):
    expected = oracle.HohenkerkSinclair().refraction(zenith)
    found = seconds(STANDARD, zenith, 574.0, 0.0, refractivity="iag1999")
    assert found == pytest.approx(expected, abs=0.01 * allowed(zenith))


@pytest.mark.parametrize("um", oracle.PAL_HORIZON)
def test_horizon_by_wavelength(um):
    found = 60 * refraction(STANDARD, 90.0, 1e3 * um, 0.0, refractivity="iag1999")
    assert found == pytest.approx(oracle.PAL_HORIZON[um], abs=6e-4)


def test_horizon_dispersion():
    """From 0.5 to 0.7 µm, to 0.1″ (the figure to reach) and better."""
    blue, red = (oracle.HohenkerkSinclair(um=um).refraction(90.0) for um in (0.5, 0.7))
    found = seconds(STANDARD, 90.0, [500.0, 700.0], 0.0, refractivity="iag1999")
    assert found[0] - found[1] == pytest.approx(blue - red, abs=1e-3)


def test_humid_air():
    humid = Polytropic(288.15, 101325.0, humidity=0.8)
    assert seconds(humid, 90.0, 574.0, 0.0, refractivity="iag1999") == pytest.approx(oracle.PAL_HUMID, abs=0.0051)
    expected = oracle.HohenkerkSinclair(humidity=0.8).refraction(85.0)
    assert seconds(humid, 85.0, 574.0, 0.0, refractivity="iag1999") == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("height", [500.0, 4200.0, 10000.0])
def test_observers_up_to_ten_kilometres(height):
    t, p = 288.15 - 0.0065 * height, 1013.25 * np.exp(-height / 7900)
    model = oracle.HohenkerkSinclair(height, t, p)
    profile = Polytropic(t, 100 * p, reference_height=height)
    for zenith in (30.0, 80.0, 89.0, 90.0):
        found = seconds(profile, zenith, 574.0, height, refractivity="iag1999")
        assert found == pytest.approx(model.refraction(zenith), abs=0.01 * allowed(zenith))


@pytest.mark.parametrize(
    ("height", "zenith"), [(100.0, 90.2), (2000.0, 91.0), (10000.0, 90.5), (10000.0, 92.0), (3500.0, 91.6)]
)
def test_below_the_horizon(height, zenith):
    """Down to the turning point and out again, by an ODE."""
    model = oracle.HohenkerkSinclair()

    def index(r):
        return model.index(r - model.radius)

    expected = oracle.bend(index, model.radius + height, zenith, model.radius + model.top)
    found = seconds(STANDARD, zenith, 574.0, height, refractivity="iag1999")
    assert found == pytest.approx(expected * oracle.ARC_SECOND, abs=0.01)


class Power(Profile):
    """n = (r_top/r)^a, so that n' / n = −a/r and R = a/(1 − a) (z − ψ_top): a closed form, turning points included.

    With a > 1 every ray of a level start spirals down: a duct over all heights.
    """

    ground, top, radius = -3e4, 8e4, 6371e3

    def __init__(self, a):
        self.a = a

    def refractivity(self, h, wavelength, model="ciddor"):
        ratio = (self.radius + self.top) / (self.radius + np.asarray(h, float))
        return np.where(np.asarray(h) > self.top, 0.0, np.expm1(self.a * np.log(ratio)))

    def closed_form(self, zenith, height):
        r, top = self.radius + height, self.radius + self.top
        k = (top / r) ** self.a * r * np.sin(np.radians(zenith))
        return np.degrees(self.a / (1 - self.a) * (np.radians(zenith) - np.arcsin(k / top)))


@pytest.mark.parametrize("a", [1e-3, 0.02, 0.15, 0.6, -0.3])
def test_power_law(a):
    """Zenith distances from 0 to 5° below the horizon; a < 0 bends upwards."""
    profile = Power(a)
    zenith = np.array([0.0, 1e-3, 20.0, 70.0, 85.0, 89.0, 89.9, 89.999, 90.0, 90.001, 90.1, 91.0, 92.0])
    found = refraction(profile, zenith, height=0.0)
    np.testing.assert_allclose(found, profile.closed_form(zenith, 0.0), rtol=0, atol=1e-7 * (1 + 10 * abs(a)))


def test_everything_is_trapped_where_air_bends_more_than_the_earth():
    profile = Power(1.2)
    with pytest.raises(ValueError, match=r"zenith\[2\] is 90 degrees: the ray (is trapped|meets the ground)"):
        refraction(profile, [0.0, 10.0, 90.0])


def test_hot_road_turns_rays_up():
    """Rays that go down towards a hot road and come back, against an ODE with the same n(h)."""
    profile = HotSurface(USStandard1976(), 30.0, 0.3)
    height, samples = 1.5, np.linspace(0.0, 41.0, 41001)
    spline = CubicSpline(samples, profile.refractivity(samples, 550.0))

    def index(r):
        h = r - profile.radius
        return float(spline(h)), float(spline(h, 1))

    # Both stop at 40 m, over which the base alone is left, and which keeps the ODE short.
    top = profile.radius + 40.0
    base = USStandard1976()

    class Low(HotSurface):
        top = 40.0

    low = Low.__new__(Low)
    low.__dict__.update(profile.__dict__, top=40.0)
    for zenith in (90.1, 90.2):
        expected = oracle.bend(index, profile.radius + height, zenith, top)
        assert expected is not None and expected < -1e-4  # bent up
        assert np.radians(refraction(low, zenith, 550.0, height)) == pytest.approx(expected, abs=2e-8)
    with pytest.raises(ValueError, match="meets the ground"):
        refraction(base, 90.2, 550.0, height)


@pytest.mark.parametrize(
    ("height", "zenith", "expected"), [(345.1, 90.0, 1975.0), (1800.0, 90.0, 2021.0), (1800.0, 90.2, 2559.0)]
)
def test_through_a_sounding(height, zenith, expected):
    """The shipped radiosonde's inversion, from the ground, and from within it downwards: by an ODE, each pair of levels
    with a spline of its own. The figures are docs/gallery/mirages.md's."""
    profile = read_sounding(Path(__file__).resolve().parents[2] / "examples" / "soundings" / "inversion.txt")
    top = 60e3
    edges = np.concatenate([[profile.ground], profile.h[1:], np.linspace(profile.h[-1], top, 12)[1:]])
    splines = []
    for low, high in pairwise(edges):
        at = np.linspace(low, high, 40)
        splines.append(CubicSpline(at, profile.refractivity(at, 574.0)))

    def index(r):
        h = r - profile.radius
        spline = splines[int(np.clip(np.searchsorted(edges, h) - 1, 0, len(splines) - 1))]
        return float(spline(h)), float(spline(h, 1))

    turned = oracle.bend(index, profile.radius + height, zenith, profile.radius + top, rtol=1e-8) * oracle.ARC_SECOND
    assert turned == pytest.approx(expected, abs=0.6)
    # the ODE is good for about 0.1 across 73 kinks; above 60 km there are 0.02 left
    assert seconds(profile, zenith, 574.0, height) == pytest.approx(turned, abs=0.15)


def test_duct():
    """Under a strong inversion rays within a few minutes of the horizontal stay in; which ones, by n r alone."""
    profile = Inversion(USStandard1976(), 50.0, 8.0, 10.0)
    height = 20.0

    def surplus(h):  # n r − n₀ r₀, from small terms
        n, n0 = profile.refractivity(h, 550.0), profile.refractivity(height, 550.0)
        return (h - height) + (profile.radius + h) * n - (profile.radius + height) * n0

    lowest = minimize_scalar(surplus, bounds=(50.0, 60.0), method="bounded", options={"xatol": 1e-9}).fun
    momentum = (1 + profile.refractivity(height, 550.0)) * (profile.radius + height)
    critical = 90 - np.degrees(2 * np.arcsin(np.sqrt(-lowest / momentum / 2)))
    assert 89.5 < critical < 89.99
    inside = refraction(profile, critical + np.array([1e-8, 1e-4, 0.01, 0.1]), 550.0, height, unreachable="nan")
    outside = refraction(profile, critical - np.array([1e-8, 1e-4, 0.01, 0.1]), 550.0, height, unreachable="nan")
    assert np.isnan(inside).all()
    assert np.isfinite(outside).all() and (np.diff(outside) < 0).all() and (outside < 3.0).all()
    with pytest.raises(ValueError, match="trapped in a duct"):
        refraction(profile, critical + 0.01, 550.0, height)


def test_outside_the_air():
    """No refraction and no error; but a ray that comes down through the air is bent twice."""
    profile = USStandard1976()
    assert refraction(profile, 45.0, 550.0, 4e5) == 0.0
    np.testing.assert_array_equal(refraction(profile, [0.0, 45.0, 90.0], 550.0, [[86e3], [4e5]]), 0.0)
    station, lowest = 4e5, 10e3  # from a space station, past the Earth at 10 km
    momentum = (1 + profile.refractivity(lowest, 550.0)) * (profile.radius + lowest)
    grazing = np.degrees(np.pi - np.arcsin(momentum / (profile.radius + station)))
    twice = 2 * seconds(profile, 90.0, 550.0, lowest)
    assert seconds(profile, grazing, 550.0, station) == pytest.approx(twice, abs=1e-3)
    with pytest.raises(ValueError, match="meets the ground"):
        refraction(profile, 179.0, 550.0, station)


def test_shapes():
    zenith = np.linspace(0, 89, 12).reshape(3, 4)
    assert refraction(STANDARD, zenith, 550.0).shape == (3, 4)
    grid = refraction(STANDARD, zenith[..., None], [450.0, 550.0], 100.0)
    assert grid.shape == (3, 4, 2) and (grid[..., 0] >= grid[..., 1]).all()
    assert isinstance(refraction(STANDARD, 45.0), float)
    each = [refraction(STANDARD, 80.0, 550.0, h) for h in (0.0, 1000.0)]
    np.testing.assert_array_equal(refraction(STANDARD, 80.0, 550.0, [0.0, 1000.0]), each)
    assert refraction(STANDARD, [], 550.0).shape == (0,)


def test_radius():
    """A smaller Earth, a stronger curvature: less refraction at the horizon, the same overhead."""
    small, large = (refraction(STANDARD, [30.0, 90.0], radius=r) for r in (3e6, 6.4e6))
    assert small[1] < 0.8 * large[1] and small[0] == pytest.approx(large[0], rel=3e-3)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((STANDARD, -1.0), {}, r"zenith\[0\] is -1 degrees; 0 to 180"),
        ((STANDARD, [0, np.nan]), {}, r"zenith\[1\] is nan"),
        ((STANDARD, 45.0, 50.0), {}, "wavelength is 50 nm"),
        ((STANDARD, 45.0, 550.0, np.inf), {}, r"height\[0\] is inf"),
        ((STANDARD, 45.0), {"refractivity": "cidor"}, "ciddor, edlen, iag1999"),
        ((STANDARD, 45.0), {"radius": 0.0}, "radius is 0 m"),
        ((STANDARD, 45.0), {"unreachable": "maybe"}, "raise, nan"),
        ((STANDARD, 91.0, 550.0, 0.0), {}, "meets the ground"),
    ],
)
def test_bad_input(arguments, options, message):
    with pytest.raises(ValueError, match=message):
        refraction(*arguments, **options)


def test_not_a_profile():
    with pytest.raises(TypeError, match="a profile of cpm"):
        refraction("standard", 45.0)
