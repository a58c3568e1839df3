"""The index of air, against the tables of the papers; Rayleigh scattering, against two other papers' formulas.

Oracles: Ciddor (1996), tables 1 to 3; the values that NIST's calculator gives for Ciddor's equation and publishes to
check other programs with; PyPI ref_index; Nicolet's and Bodhaine et al.'s fits of the Rayleigh cross-section.
"""

import numpy as np
import pytest

import cpm
from cpm import air

# Ciddor (1996): °C, kPa, relative humidity %, 1e8 (n − 1) at 633 nm, 450 ppm. Table 1 is dry. In table 3 the paper's
# 19996.5 at 40 °C and 80 kPa is a misprint for 19896.5: its own column of differences says so.
TABLE_1 = [
    (20, 80, 0, 21458.0),
    (20, 100, 0, 26824.4),
    (20, 120, 0, 32191.6),
    (10, 100, 0, 27774.7),
    (30, 100, 0, 25937.2),
]
TABLE_3 = [
    (20, 80, 75, 21394.0),
    (20, 120, 75, 32127.8),
    (40, 80, 75, 19896.5),
    (40, 120, 75, 29941.8),
    (50, 80, 100, 19058.4),
    (50, 120, 100, 28792.4),
]
# Table 2: °C, Pa, vapour pressure Pa, CO₂ ppm.
TABLE_2 = [
    (19.526, 102094.8, 1065, 510, 27392.9),
    (19.517, 102096.8, 1065, 510, 27394.0),
    (19.173, 102993.0, 641, 450, 27682.4),
    (19.173, 103006.0, 642, 440, 27685.8),
    (19.188, 102918.8, 706, 450, 27658.7),
    (19.189, 102927.8, 708, 440, 27660.8),
    (19.532, 103603.2, 986, 600, 27802.0),
    (19.534, 103596.2, 962, 600, 27800.8),
    (19.534, 103599.2, 951, 610, 27802.2),
]
# NIST: °C, kPa, %, nm, n.
NIST = [
    (20, 101.325, 0, 633, 1.000271800),
    (20, 60, 0, 633, 1.000160924),
    (20, 120, 0, 633, 1.000321916),
    (50, 100, 0, 633, 1.000243285),
    (5, 100, 0, 633, 1.000282756),
    (-40, 100, 0, 633, 1.000337580),
    (50, 120, 100, 633, 1.000287924),
    (40, 120, 75, 633, 1.000299418),
    (20, 100, 100, 633, 1.000267394),
    (40, 110, 100, 1700, 1.000270247),
    (20, 101.325, 0, 1700, 1.000268479),
    (40, 110, 100, 300, 1.000289000),
    (20, 101.325, 0, 300, 1.000286581),
    (-40, 120, 0, 300, 1.000427233),
]


@pytest.mark.parametrize(("t", "p", "humidity", "expected"), TABLE_1 + TABLE_3)
def test_ciddor_tables_1_and_3(t, p, humidity, expected):
    """To 0.05 in 1e8 (n − 1): the tables' last digit."""
    n = air.ciddor(633.0, t + 273.15, 1e3 * p, humidity / 100)
    assert 1e8 * (n - 1) == pytest.approx(expected, abs=0.06)


@pytest.mark.parametrize(("t", "p", "vapour", "co2", "expected"), TABLE_2)
def test_ciddor_table_2(t, p, vapour, co2, expected):
    assert 1e8 * air.refractivity(633.0, t + 273.15, p, vapour, co2=co2) == pytest.approx(expected, abs=0.5)


@pytest.mark.parametrize(("t", "p", "humidity", "wavelength", "expected"), NIST)
def test_ciddor_nist(t, p, humidity, wavelength, expected):
    """To the digits that are published, one unit."""
    assert air.ciddor(wavelength, t + 273.15, 1e3 * p, humidity / 100) == pytest.approx(expected, abs=1e-9)


def test_ciddor_ref_index():
    assert air.ciddor(633.0, 293.15, 101325.0, 0.2) == pytest.approx(1.0002716285, abs=1e-10)


def test_models_agree_near_the_laboratory():
    """Birch and Downs say that theirs holds from 5 to 30 °C; Ciddor's paper finds it within 1e-8 there."""
    t, p = np.meshgrid(np.linspace(283.15, 303.15, 5), np.linspace(9e4, 1.1e5, 5))
    for wavelength in (400.0, 550.0, 633.0):
        for humidity in (0.0, 0.6):
            ciddor = air.ciddor(wavelength, t, p, humidity)
            np.testing.assert_allclose(air.edlen(wavelength, t, p, humidity), ciddor, rtol=0, atol=2e-8)
            np.testing.assert_allclose(air.iag1999(wavelength, t, p, humidity), ciddor, rtol=0, atol=2.5e-7)


def test_iag1999_is_the_formula():
    k = 1 / 0.574**2
    expected = 1e-6 * (287.6155 + 1.62887 * k + 0.01360 * k * k) * 273.15 / 288.15 * 900 / 1013.25
    assert air.refractivity(574.0, 288.15, 9e4, model="iag1999") == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("model", air.MODELS)
def test_dispersion_of_air_is_the_function(model):
    """`dispersion.Air` gives the core the same numbers in the form of shared/dispersion.h."""
    wavelengths = np.array([380.0, 500.0, 587.5618, 1000.0])
    model_of_air = cpm.dispersion.Air(300.0, 9e4, 0.7, model=model)
    expected = 1 + air.refractivity(wavelengths, 300.0, 9e4, air.vapour_pressure(300.0, 9e4, 0.7), model)
    np.testing.assert_allclose(model_of_air.n(wavelengths), expected, rtol=0, atol=3e-16)


def test_refractivity_is_density_times_dispersion():
    """A medium of density ρ(h) with air's dispersion has N(λ)/N(d) of air everywhere."""
    medium = cpm.media.Linear(1.00027, (0, -2.7e-8, 0), dispersion=cpm.dispersion.Air())
    points = [(0, 0, 0), (0, 3000, 0)]
    ratio = air.refractivity(450.0, 288.15, 101325.0) / air.refractivity(587.5618, 288.15, 101325.0)
    n, _ = medium.evaluate(points, 450.0)
    np.testing.assert_allclose(n - 1, ratio * (2.7e-4 - 2.7e-8 * np.array([0, 3000])), rtol=0, atol=4e-16)


def test_saturation_pressure():
    """WMO's values over water at −20, 0, 20 and 40 °C, Pa."""
    np.testing.assert_allclose(
        air.saturation_pressure([253.15, 273.15, 293.15, 313.15]), [125.4, 611.2, 2339.2, 7384], rtol=1.5e-3
    )


# Rayleigh. Nicolet (1984) fits Bates (1984) within 0.5 %, σ = 4.02e-28/λ^(4+x) cm², and Bates' own figures differ by as
# much from later ones; Bodhaine et al. (1999), eq. 29, fit their own at 360 ppm within 0.01 %.


def test_rayleigh_nicolet():
    um = np.array([0.30, 0.35, 0.40, 0.45, 0.50, 0.549, 0.60, 0.70, 0.80, 1.0])
    x = np.where(um < 0.55, 0.389 * um + 0.09426 / um - 0.3228, 0.04)
    np.testing.assert_allclose(air.rayleigh_cross_section(1e3 * um), 4.02e-32 / um ** (4 + x), rtol=0.012)


def test_rayleigh_bodhaine():
    um = np.linspace(0.30, 0.85, 23)
    k, u = um**-2, um**2
    expected = 1e-32 * (1.0455996 - 341.29061 * k - 0.90230850 * u) / (1 + 0.0027059889 * k - 85.968563 * u)
    np.testing.assert_allclose(air.rayleigh_cross_section(1e3 * um, co2=360), expected, rtol=2e-4)


def test_king_factor_bates():
    """(6 + 3ρ)/(6 − 7ρ) of the depolarisation that Bucholtz (1995), table 1, has from Bates (1984)."""
    depolarisation = 1e-2 * np.array([4.545, 3.565, 3.178, 3.010, 2.955, 2.842, 2.786, 2.730, 2.730])
    wavelengths = [200.0, 250.0, 300.0, 350.0, 400.0, 500.0, 600.0, 700.0, 1000.0]
    expected = (6 + 3 * depolarisation) / (6 - 7 * depolarisation)
    np.testing.assert_allclose(air.king_factor(wavelengths, co2=360), expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((633.0, 20.0), "temperature is 20 K"),
        ((633.0, 293.15, -1.0), "pressure is -1 Pa"),
        ((633.0, 293.15, 1e5, 50.0), "humidity is 50.*percent"),
        ((100.0,), "wavelength is 100 nm"),
        ((633.0, [288.0, np.nan]), r"temperature\[1\] is nan"),
        (([500.0, 3000.0],), r"wavelength\[1\] is 3000 nm"),
    ],
)
def test_nonsense_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        air.ciddor(*arguments)


def test_unknown_model():
    with pytest.raises(ValueError, match="ciddor, edlen, iag1999"):
        air.refractivity(633.0, 288.15, 1e5, model="cidor")
