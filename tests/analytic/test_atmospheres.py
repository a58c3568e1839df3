"""Profiles: the published standard atmosphere, hydrostatics, what layers do to it, and radiosonde files."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cpm
from cpm.atmosphere import HotSurface, Inversion, Polytropic, Table, USStandard1976, read_sounding

SOUNDING = Path(__file__).resolve().parents[2] / "examples" / "soundings" / "inversion.txt"
LEVELS = np.array([0.0, 300.0, 350.0, 1500.0, 6000.0, 11000.0, 20000.0])
KELVIN = np.array([281.0, 279.5, 286.0, 280.0, 250.0, 217.0, 217.0])
HUMIDITY = np.array([0.9, 0.8, 0.4, 0.5, 0.3, 0.1, 0.0])

PROFILES = {
    "standard": USStandard1976(),
    "polytropic": Polytropic(288.15, 101325.0, humidity=0.7),
    "isothermal": Polytropic(280.0, 1e5, lapse=0.0, humidity=0.5),
    "table": Table(LEVELS, KELVIN, 1.01e5, HUMIDITY),
    "smooth table": Table(LEVELS, KELVIN, 1.01e5, HUMIDITY, interpolation="monotone"),
    "hot": HotSurface(USStandard1976(), 40.0, 0.05),
    "cold": HotSurface(Table(LEVELS, KELVIN, 1.01e5, HUMIDITY), -5.0, 2.0),
    "inversion": Inversion(Polytropic(288.15, 101325.0), 60.0, 7.0, 15.0),
    "both": Inversion(HotSurface(USStandard1976(), -3.0, 1.0), 300.0, 4.0, 50.0),
}

# Table I of the standard: geometric height m, K, Pa, kg/m³.
STANDARD = [
    (0, 288.150, 101325.0, 1.2250),
    (5000, 255.676, 5.4048e4, 0.73643),
    (11000, 216.774, 2.2700e4, 0.36480),
    (20000, 216.650, 5.5293e3, 0.088910),
    (32000, 228.490, 8.8906e2, 0.013555),
    (50000, 270.650, 7.9779e1, 1.0269e-3),
    (71000, 216.846, 4.4795, 7.1965e-5),
    (80000, 198.639, 1.0524, 1.8458e-5),
]


@pytest.mark.parametrize(("h", "temperature", "pressure", "density"), STANDARD)
def test_us_standard(h, temperature, pressure, density):
    profile = USStandard1976()
    assert profile.temperature(h) == pytest.approx(temperature, abs=6e-4)
    assert profile.pressure(h) == pytest.approx(pressure, rel=8e-5)  # five digits are printed
    assert profile.density(h) == pytest.approx(density, rel=8e-5)
    assert profile.humidity(h) == 0.0


@pytest.mark.parametrize("name", PROFILES)
def test_hydrostatics(name):
    """dp/dh = −ρ g with the profile's own density, between the kinks."""
    profile = PROFILES[name]
    h = np.concatenate([[0.01, 0.03, 0.2, 1.0, 5.0, 59.0, 61.0, 310.0], np.linspace(400, 70e3, 50)])
    kinks = np.array([*profile._kinks(), profile.ground])
    h = h[np.abs(h[:, None] - kinks).min(axis=1) > 2e-3]
    polytropic = "polytropic" in name or name in ("isothermal", "inversion")
    gravity = 9.784 * np.ones_like(h) if polytropic else 9.80665 * (6356766 / (6356766 + h)) ** 2
    if polytropic:
        h, gravity = h[h < 11e3], gravity[h < 11e3]  # vapour above follows the dry scale height
    step = np.minimum(1e-3 * h, 1.0)
    fall = -(np.log(profile.pressure(h + step)) - np.log(profile.pressure(h - step))) / (2 * step)
    # Rounding of ln p over the step, and the second difference of the slope.
    np.testing.assert_allclose(
        fall, profile.density(h) * gravity / profile.pressure(h), rtol=1e-6, atol=2e-16 * 20 / step.min()
    )


def test_table_against_an_ode():
    """Pressure by SciPy from the table's own definition: T and humidity linear, moist air, gravity falling off."""
    profile = Table(LEVELS, KELVIN, 1.01e5, HUMIDITY)

    def slope(h, log_pressure):
        t, p = np.interp(h, LEVELS, KELVIN), np.exp(log_pressure)
        saturated = np.exp(1.2378847e-5 * t * t - 1.9121316e-2 * t + 33.93711047 - 6.3431645e3 / t)
        vapour = np.interp(h, LEVELS, HUMIDITY) * saturated * (1.00062 + 3.14e-8 * p + 5.6e-7 * (t - 273.15) ** 2)
        molar = 28.9644 - (28.9644 - 18.0152) * vapour / p
        return -9.80665 * (6356766 / (6356766 + h)) ** 2 * molar / (8314.32 * t)

    start = np.log([1.01e5])
    for low, high in zip(LEVELS[:-1], LEVELS[1:], strict=True):
        middle = 0.5 * (low + high)
        found = solve_ivp(slope, (low, high), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=[middle, high]).y[
            0
        ]
        np.testing.assert_allclose(profile.pressure([middle, high]), np.exp(found), rtol=1e-8)
        start = found[-1:]


def test_given_pressures_are_kept():
    free = Table(LEVELS, KELVIN, 1.01e5, HUMIDITY)
    pressures = free.p * np.linspace(1.0, 0.98, LEVELS.size)  # not quite hydrostatic, as measured ones
    given = Table(LEVELS, KELVIN, pressures, HUMIDITY)
    np.testing.assert_allclose(given.pressure(LEVELS), pressures, rtol=1e-13)
    np.testing.assert_allclose(
        Table(LEVELS, KELVIN, free.p, HUMIDITY).pressure([150.0, 900.0, 9000.0]),
        free.pressure([150.0, 900.0, 9000.0]),
        rtol=1e-6,
    )


@pytest.mark.parametrize("name", PROFILES)
def test_everywhere(name):
    """From below the ground to above the top: finite, positive, vectorised, nothing above."""
    profile = PROFILES[name]
    h = np.array([[-200.0, 0.0, 17.0], [12345.0, 79e3, 1e6]])
    for method in (profile.temperature, profile.pressure, profile.density, profile.humidity, profile.vapour_pressure):
        values = method(h)
        assert values.shape == h.shape and np.isfinite(values).all() and (values >= 0).all()
        assert method(17.0) == values[0, 2] and isinstance(method(17.0), float)
    assert profile.pressure(1e6) == profile.density(1e6) == profile.refractivity(1e6, 550.0) == 0.0
    assert profile.refractivity(h, 550.0).shape == h.shape
    assert profile.refractivity(h[..., None], [450.0, 650.0]).shape == (2, 3, 2)


def test_refractivity_is_that_of_the_air():
    profile = PROFILES["table"]
    t, p, humidity = (getattr(profile, name)(700.0) for name in ("temperature", "pressure", "humidity"))
    for model in cpm.air.MODELS:
        function = getattr(cpm.air, model)
        assert profile.refractivity(700.0, 550.0, model) == pytest.approx(
            float(function(550.0, t, p, humidity)) - 1, abs=1e-15
        )


def test_refractivity_is_density_times_dispersion():
    """Dry air: N(λ, h)/N(λ, 0) is the ratio of densities, but for air's compressibility, and no wavelength's own."""
    profile, h = USStandard1976(), np.array([0.0, 1000.0, 8000.0, 30000.0])
    blue, red = (profile.refractivity(h, w) for w in (450.0, 650.0))
    np.testing.assert_allclose(blue / blue[0], red / red[0], rtol=1e-13)
    np.testing.assert_allclose(blue / blue[0], profile.density(h) / profile.density(0.0), rtol=1e-3)


def test_hot_surface():
    base, profile = USStandard1976(), HotSurface(USStandard1976(), 30.0, 0.05)
    h = np.array([0.0, 0.05, 0.5, 2.0])
    np.testing.assert_allclose(
        profile.temperature(h) - base.temperature(h), 30 * np.exp(-h / 0.05), rtol=1e-10, atol=1e-12
    )
    assert profile.pressure(0.0) == base.pressure(0.0)
    high = HotSurface(Table([500, 2000], [290, 280], 95000.0), 10.0, 1.0)  # counts from the table's ground
    assert high.temperature(500.0) == pytest.approx(300.0) and high.temperature(501.0) == pytest.approx(
        290 + 10 / np.e, abs=0.01
    )


def test_inversion():
    base = USStandard1976()
    profile = Inversion(base, 50.0, 8.0, 10.0)
    np.testing.assert_allclose(
        profile.temperature([0.0, 50.0, 200.0]) - base.temperature([0.0, 50.0, 200.0]), [-8, -4, 0], rtol=0, atol=1e-7
    )


def test_monotone_table_is_smooth_and_does_not_overshoot():
    profile = Table(LEVELS, KELVIN, interpolation="monotone")
    h = np.linspace(0, 20e3, 20001)
    values = profile.temperature(h)
    for low, high, a, b in zip(LEVELS[:-1], LEVELS[1:], KELVIN[:-1], KELVIN[1:], strict=True):
        inside = values[(h >= low) & (h <= high)]
        assert inside.min() >= min(a, b) - 1e-9 and inside.max() <= max(a, b) + 1e-9
    for level in LEVELS[1:-1]:
        left, right = (profile.temperature(level + s) - profile.temperature(level) for s in (-1e-4, 1e-4))
        assert left + right == pytest.approx(0, abs=1e-6)


def test_polytropic_is_hohenkerk_and_sinclair():
    """τ^γ below the tropopause, exponential above, constant gravity."""
    profile = Polytropic(280.0, 1e5, lapse=0.006, tropopause=10000.0, latitude=60.0)
    gravity = 9.784 * (1 + 0.0026 * 0.5)
    gamma = gravity * 28.9644 / (8314.32 * 0.006)
    assert profile.pressure(4000.0) == pytest.approx(1e5 * (256 / 280) ** gamma, rel=1e-13)
    edge = 1e5 * (220 / 280) ** gamma
    assert profile.pressure(15e3) == pytest.approx(edge * np.exp(-gravity * 28.9644 / (8314.32 * 220) * 5e3), rel=1e-13)
    assert profile.temperature(15e3) == 220.0 and profile.radius == 6378120.0


# Soundings.


def test_sounding():
    """A published one: its first and last levels, the inversion that it is there for, the hydrostatic heights."""
    profile = read_sounding(SOUNDING)
    assert profile.ground == pytest.approx(345.0, abs=0.05)
    assert profile.temperature(profile.ground) == pytest.approx(280.95)
    assert profile.pressure(profile.ground) == pytest.approx(97800.0)
    geometric = 6356766 * 16310 / (6356766 - 16310)
    assert profile.h[-1] == pytest.approx(geometric) and profile.p[-1] == pytest.approx(1e4)
    assert profile.temperature(2062.0) - profile.temperature(1563.0) > 9.0
    np.testing.assert_allclose(
        profile.rh[:3], [0.61, 0.61, 0.61], atol=0.01
    )  # from the dew points; the file prints 61 %
    free = Table(profile.h, profile.T, float(profile.p[0]), profile.rh)
    np.testing.assert_allclose(free.p, profile.p, rtol=2e-3)


WYOMING = """\
72357 OUN Norman Observations at 12Z
-----------------------------------------------------------------------------
   PRES   HGHT   TEMP   DWPT   RELH
    hPa     m      C      C      %
-----------------------------------------------------------------------------
 1000.0    -12
  978.0    180   20.4   16.5     78
  964.1    305   22.2            60
  954.0    397   23.6   17.6     69
  954.0    397   23.6   17.6     69
Station information and sounding indices
 1.0 2.0 3.0
"""


def test_wyoming_columns(tmp_path):
    """Blank fields, levels without temperature, a level twice, text after the table."""
    path = tmp_path / "w.txt"
    path.write_text(WYOMING)
    profile = read_sounding(path)
    np.testing.assert_allclose(profile.p, [97800, 96410, 95400])
    np.testing.assert_allclose(profile.T, [293.55, 295.35, 296.75])
    np.testing.assert_allclose(profile.rh, [0.78, 0.60, 0.69], atol=0.006)


def test_other_tables(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("height, pressure, temperature, RH\n0, 1013.25, 15, 50\n1000, 899, 8.5, 40\n# the end\n")
    profile = read_sounding(path, interpolation="monotone")
    np.testing.assert_allclose(profile.rh, [0.5, 0.4])
    np.testing.assert_allclose(profile.T, [288.15, 281.65])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no line names the columns"),
        ("PRES HGHT TEMP\n1000 10 15\n", "1 levels.*at least 2"),
        ("PRES HGHT TEMP\n1000 10 15\n900 5 10\n", "line 3: height is 5 after 10; it must rise"),
        ("PRES HGHT TEMP\n900 10 15\n1000 50 10\n", "line 3: pressure is 1000 after 900; it must fall"),
        ("PRES HGHT TEMP\n1000 10 15\n900 x 10\n", "line 3: 'x' is not a number"),
        ("PRES HGHT TEMP\n1000 10 288\n900 900 280\n", "T.*400 are allowed"),
    ],
)
def test_bad_soundings(tmp_path, text, message):
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as error:
        read_sounding(path)
    assert "\n" not in str(error.value) and str(path) in str(error.value)


def test_missing_sounding(tmp_path):
    with pytest.raises(ValueError, match="No such file"):
        read_sounding(tmp_path / "none.txt")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Polytropic(15.0, 101325.0), "T0 is 15 K.*°C"),
        (lambda: Polytropic(288.15, 1013.25), "p0 is 1013.25 Pa.*hPa"),
        (lambda: Polytropic(288.15, 101325.0, humidity=50.0), "humidity is 50.*percent"),
        (lambda: Polytropic(288.15, 101325.0, lapse=6.5), "lapse is 6.5 K/m.*K/km"),
        (lambda: Polytropic(288.15, 101325.0, lapse=0.03), "gives -41.85 K at the tropopause"),
        (lambda: Polytropic(288.15, 101325.0, latitude=100.0), "latitude is 100"),
        (lambda: Polytropic(288.15, 101325.0, tropopause=9e4), "tropopause is 90000 m"),
        (lambda: Polytropic(np.nan, 101325.0), "T0 is nan"),
        (lambda: Table([0, 1000], [15, 8]), r"T\[0\] is 15 K.*°C"),
        (lambda: Table([0, 1000], [288, 281], rh=[50, 40]), r"rh\[0\].*percent"),
        (lambda: Table([0, 0], [288, 281]), r"h\[1\] is 0 m.*increase strictly"),
        (lambda: Table([0], [288]), "at least 2"),
        (lambda: Table([0, 1], [288, 281, 270]), "T has shape"),
        (lambda: Table([0, 1000], [288, 281], [1e5, 1.1e5]), r"p\[1\].*must fall"),
        (lambda: Table([0, 1000], [288, 281], 1013.25), "hPa"),
        (lambda: Table([0, 1000], [288, 281], interpolation="cubic"), "monotone"),
        (lambda: HotSurface(USStandard1976(), 30.0, 1e-5), "thickness is 1e-05 m; 0.0001"),
        (lambda: HotSurface(USStandard1976(), 900.0, 1.0), "excess is 900 K"),
        (lambda: HotSurface(USStandard1976(), 400.0, 1.0), "gives 688.15 K"),
        (lambda: Inversion(USStandard1976(), -5.0, 3.0, 1.0), "height is -5 m"),
        (lambda: Inversion(USStandard1976(), 50.0, np.inf, 1.0), "strength is inf"),
    ],
)
def test_bad_profiles(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    "make",
    [
        lambda: HotSurface(288.0, 30.0, 1.0),
        lambda: Inversion("standard", 50.0, 3.0, 1.0),
        lambda: Table("x", [1]),
        lambda: Polytropic([288.0, 1.0], 1e5),
    ],
)
def test_wrong_types(make):
    with pytest.raises(TypeError):
        make()


def test_bad_heights():
    with pytest.raises(ValueError, match=r"h\[1\] is nan"):
        USStandard1976().pressure([0.0, np.nan])
