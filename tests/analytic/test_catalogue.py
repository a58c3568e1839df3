"""The catalogue against published *values*: data sheets and tables of measurements, never the same coefficients.

Each list is (wavelength nm, n). Tolerances are those of the sources' last digits, or of the specimens where two papers
measured different ones.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cpm
from cpm.dispersion import catalogue

LINE = {
    "i": 365.0146,
    "h": 404.6561,
    "g": 435.8343,
    "F'": 479.9914,
    "F": 486.1327,
    "e": 546.0740,
    "d": 587.5618,
    "D": 589.2938,
    "C'": 643.8469,
    "C": 656.2725,
    "r": 706.5188,
}
# SCHOTT data sheets: five decimals, and the Abbe number of d.
SCHOTT = {
    "BK7": (
        {
            "i": 1.53627,
            "h": 1.53024,
            "g": 1.52668,
            "F'": 1.52283,
            "F": 1.52238,
            "e": 1.51872,
            "d": 1.51680,
            "D": 1.51673,
            "C'": 1.51472,
            "C": 1.51432,
            "r": 1.51289,
        },
        64.17,
    ),
    "F2": ({"i": 1.66623, "h": 1.65064, "g": 1.64202, "F": 1.63208, "e": 1.62408, "d": 1.62004, "C": 1.61503}, 36.37),
    "SF11": ({"g": 1.82518, "F": 1.80645, "e": 1.79190, "d": 1.78472, "C": 1.77599}, 25.76),
}
# Malitson (1965), table 1: six decimals, fit within 1e-6 of what he prints.
SILICA = [
    (213.856, 1.534307),
    (404.656, 1.469618),
    (435.835, 1.466693),
    (486.133, 1.463126),
    (587.561, 1.458464),
    (589.262, 1.458404),
    (656.272, 1.456367),
    (1013.98, 1.450242),
    (3706.7, 1.399389),
]
# Tilton and Taylor (1938), 20 °C, relative to air at 20 °C: another laboratory and seventy years before.
WATER = [
    (404.66, 1.342742),
    (435.83, 1.340210),
    (486.13, 1.337123),
    (546.07, 1.334466),
    (589.30, 1.332988),
    (656.28, 1.331151),
    (667.81, 1.330875),
    (706.52, 1.330019),
]
# Malitson (1962), ordinary ray at 24 °C; dn/dT = 1.3e-5/K.
SAPPHIRE = [
    (361.05, 1.79450),
    (435.83, 1.78120),
    (579.06, 1.76871),
    (852.12, 1.75885),
    (1128.66, 1.75339),
    (1529.52, 1.74660),
    (1813.07, 1.74144),
    (2249.29, 1.73232),
    (4255.30, 1.66371),
]
# A supplier's table (Valley Design), ordinary ray, where it has the wavelength to a nanometre: five decimals.
SAPPHIRE_SUPPLIED = [
    (532, 1.77170),
    (590, 1.76804),
    (633, 1.76590),
    (670, 1.76433),
    (755, 1.76141),
    (780, 1.76068),
    (800, 1.76013),
    (820, 1.75961),
    (980, 1.75607),
    (1064, 1.75449),
    (1320, 1.75009),
    (1550, 1.74618),
    (2010, 1.73748),
]
# Handbook values of C, D, F; stones differ by a few 1e-4.
DIAMOND = [(656.28, 2.4099), (589.29, 2.4175), (486.13, 2.4354)]


@pytest.mark.parametrize("name", SCHOTT)
def test_schott(name):
    lines, abbe = SCHOTT[name]
    glass = catalogue(name)
    for line, n in lines.items():
        assert glass.n(LINE[line]) == pytest.approx(n, abs=6e-6), line
    assert (glass.n(LINE["d"]) - 1) / (glass.n(LINE["F"]) - glass.n(LINE["C"])) == pytest.approx(abbe, abs=0.006)
    assert glass.reference == "air"


def check(name, table, tolerance, offset=0.0):
    wavelengths, expected = np.array(table).T
    np.testing.assert_allclose(catalogue(name).n(wavelengths), expected + offset, rtol=0, atol=tolerance)


def test_fused_silica():
    check("fused silica", SILICA, 1.5e-6)
    assert catalogue("fused silica").reference == "air"


def test_water():
    """Daimon and Masumura's index is absolute: Tilton and Taylor's times that of air."""
    wavelengths, relative = np.array(WATER).T
    absolute = relative * cpm.air.ciddor(wavelengths, 293.15)
    np.testing.assert_allclose(catalogue("water").n(wavelengths), absolute, rtol=0, atol=1e-5)
    assert catalogue("water").reference == "vacuum"


def test_sapphire():
    check("sapphire", SAPPHIRE, 3e-5, offset=-4 * 1.3e-5)
    check("sapphire", SAPPHIRE_SUPPLIED, 1e-5)


def test_diamond():
    check("diamond", DIAMOND, 3e-4)


def test_air():
    """Ciddor's dry standard air. Edlén's 1966 formula, for 300 ppm of CO₂, differs by 1.3e-8 at most."""
    wavelengths = np.array([300.0, 400.0, 550.0, 700.0, 1000.0])
    k = 1e6 / wavelengths**2
    edlen = 1 + 1e-8 * (8342.13 + 2406030 / (130 - k) + 15997 / (38.9 - k)) * (1 + 0.54e-6 * 150)
    np.testing.assert_allclose(catalogue("air").n(wavelengths), edlen, rtol=0, atol=1.3e-8)
    assert catalogue("air").n(633.0) == pytest.approx(1.00027653, abs=5e-9)


NAMES = ("BK7", "F2", "SF11", "fused silica", "water", "sapphire", "diamond", "air")


@pytest.mark.parametrize("name", NAMES)
def test_every_entry_serves(name):
    """As the interior of a dielectric, as a medium, as `dispersion=`; it says where it is from and where it ends."""
    model = catalogue(name)
    assert model.reference in ("air", "vacuum") and len(model.source) > 20
    low, high = model.range
    for outside in (low - 1.0, high + 1.0):
        with pytest.raises(ValueError, match="valid in"):
            model.n(outside)
        assert model.n(outside, extrapolate=True) == catalogue(name, extrapolate=True).n(outside) > 1
    wavelengths = np.array([450.0, 550.0, 650.0])
    medium = cpm.media.Homogeneous(name)
    rays = cpm.trace(medium, np.zeros((3, 3)), np.tile((1.0, 0, 0), (3, 1)), wavelength=wavelengths, length=2.0)
    np.testing.assert_allclose(rays.optical_path, 2 * model.n(wavelengths), rtol=1e-15)
    varying = cpm.media.Linear(1.3, (0, -0.1, 0), dispersion=name)
    scale = (model.n(450.0) - 1) / (model.n(587.5618) - 1)
    assert varying.evaluate([0, 1, 0], 450.0)[0] - 1 == pytest.approx(0.2 * scale, rel=1e-9)
    cpm.materials.Dielectric(name)


def test_gas_is_its_formula():
    """n − 1 = Σ B/(C − σ²) + polynomial in σ²."""
    um = np.array([0.4, 0.55, 0.7])
    k = um**-2
    model = cpm.dispersion.Gas([0.05], [200.0], [1e-5, 2e-6, 3e-7, 4e-8])
    expected = 1 + 0.05 / (200 - k) + 1e-5 + 2e-6 * k + 3e-7 * k**2 + 4e-8 * k**3
    np.testing.assert_allclose(model.n(1e3 * um), expected, rtol=0, atol=3e-16)
    with pytest.raises(ValueError, match="at most 4"):
        cpm.dispersion.Gas(polynomial=[1e-5] * 5)
    with pytest.raises(ValueError, match="as many"):
        cpm.dispersion.Gas([1.0], [])


def test_tabulated():
    model = cpm.dispersion.Tabulated([400, 500, 700], [1.5, 1.48, 1.46])
    np.testing.assert_allclose(model.n([400, 450, 600, 700]), [1.5, 1.49, 1.47, 1.46], rtol=1e-15)
    with pytest.raises(ValueError, match="valid in"):
        model.n(399.0)


def test_c_has_the_same_catalogue():
    """The library's table is made from the one that Python reads."""
    generator = Path(__file__).resolve().parents[2] / "spectral" / "generate_catalogue.py"
    subprocess.run([sys.executable, generator, "--check"], check=True)
