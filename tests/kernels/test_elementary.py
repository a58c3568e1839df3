"""The elementary functions of cl/ against long double (80 bits): the error bounds that their headers state, in ulp."""
import ctypes as ct
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
LONG = np.longdouble
COUNT = 1_000_000


@pytest.fixture(scope="module")
def functions(tmp_path_factory):
    out = tmp_path_factory.mktemp("elementary") / "elementary.so"
    subprocess.run(["cc", "-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-shared", f"-I{ROOT}", "-o", out,
                    Path(__file__).parent / "elementary_more.c", "-lm"], check=True)
    return ct.CDLL(str(out))


def call(functions, name, x, y=None):
    out, p = np.empty_like(x), ct.POINTER(ct.c_double)
    y = x if y is None else y
    getattr(functions, f"test_{name}")(*(a.ctypes.data_as(p) for a in (x, y, out)), ct.c_long(len(x)))
    return out


def spread(rng, low, high):
    """Both signs, evenly over powers of two."""
    return rng.choice([-1.0, 1.0], COUNT) * np.exp2(rng.uniform(np.log2(low), np.log2(high), COUNT))


CASES = {"atan": (np.arctan, 1e-12, 1e12, 4), "asin": (np.arcsin, 1e-12, 1.0, 4), "acos": (np.arccos, 1e-12, 1.0, 4),
         "tan": (np.tan, 1e-3, 1e6, 6), "sinh": (np.sinh, 1e-12, 700.0, 3), "cosh": (np.cosh, 1e-12, 700.0, 3), "tanh": (np.tanh, 1e-12, 100.0, 4)}


@pytest.mark.parametrize("name", CASES)
def test_error(functions, name):
    function, low, high, bound = CASES[name]
    x = spread(np.random.default_rng(1), low, high)
    found, expected = call(functions, name, x), function(x.astype(LONG))
    if name == "tan":
        keep = np.abs(expected) > 1e-3
        found, expected = found[keep], expected[keep]
    ulp = np.abs(found - expected) / np.spacing(np.abs(expected.astype(float)))
    assert float(ulp.max()) <= bound


def test_atan2(functions):
    rng = np.random.default_rng(2)
    y, x = spread(rng, 1e-9, 1e9), spread(rng, 1e-9, 1e9)
    expected = np.arctan2(y.astype(LONG), x.astype(LONG))
    assert float(np.max(np.abs(call(functions, "atan2", y, x) - expected) / np.spacing(np.abs(expected.astype(float))))) <= 4


@pytest.mark.parametrize(("name", "x", "expected"), [
    ("atan", [0, np.inf, -np.inf, np.nan], [0, np.pi / 2, -np.pi / 2, np.nan]), ("asin", [0, 1, -1, 1.0000001, np.nan], [0, np.pi / 2, -np.pi / 2, np.nan, np.nan]),
    ("acos", [1, -1, 0, -2], [0, np.pi, np.pi / 2, np.nan]), ("tanh", [0, 800, -800, np.nan], [0, 1, -1, np.nan]),
    ("sinh", [0, 800, -800], [0, np.inf, -np.inf]), ("cosh", [0, 800, -800], [1, np.inf, np.inf])])
def test_special(functions, name, x, expected):
    np.testing.assert_allclose(call(functions, name, np.array(x, float)), expected, rtol=1e-15)


def test_atan2_axes(functions):
    y, x = np.array([0.0, 1, -1, 0, 0]), np.array([0.0, 0, 0, 1, -1])
    np.testing.assert_allclose(call(functions, "atan2", y, x), [0, np.pi / 2, -np.pi / 2, 0, np.pi], rtol=1e-15)
