"""Order conditions of the Runge-Kutta-Nyström tables, read from the header that is compiled.

Every order condition belongs to an elementary differential of r'' = g(r), and in a system without symmetry all of them
differ from 0. So the local error of one step in 60 digits, against a Taylor series, shows the order that a pair has.
"""
import re
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest

SHARED = Path(__file__).resolve().parents[2] / "cl" / "shared"
HEADER = (SHARED / "step_nystrom.h").read_text() + (SHARED / "step_nystrom12.h").read_text()
START = ("0.3", "-0.2"), ("0.7", "0.4")
#: pair → stages, orders of the result and of the embedded one.
PAIRS = {"rkn6": (6, 6, 4), "rkn8": (9, 8, 6), "rkn12": (18, 12, 10)}
ROUNDED = Fraction(1, 10**28)   # 12(10) is given to 30 digits, the others as fractions


def table(name):
    """The numbers of a table as fractions."""
    text = re.search(rf"cpm_{name}(?:\[\d+\])+ = (\{{.*?\}});", HEADER, re.DOTALL)[1]
    rows = re.findall(r"\{([^{}]*)\}", text)
    parsed = [[sum(_term(t) for t in re.findall(r"[+-]?[^+-]+", re.sub(r"\s", "", entry))) for entry in row.split(",") if entry.strip()]
              for row in rows]
    return parsed if len(parsed) > 1 else parsed[0]


def _term(text):
    over = text.split("/")
    return Fraction(over[0]) / (Fraction(over[1]) if len(over) > 1 else 1)


def force(x, y):
    """A potential without symmetry: x²y + x⁴/3 − y³/2 + xy/5."""
    return -(2 * x * y + 4 * x**3 / 3 + y / 5), -(x * x - 3 * y * y / 2 + x / 5)


def step(pair, h, lower=False):
    """State after one step, of the result or of the embedded one."""
    c, rows, b, e, d = (table(f"{pair}_{part}") for part in "cAbed")
    (x, y), (px, py) = ([mpmath.mpf(v) for v in pair_] for pair_ in START)
    g = []

    def total(weights, k):
        return sum(mpmath.mpf(w.numerator) / w.denominator * v[k] for w, v in zip(weights, g, strict=False))

    for i, row in enumerate(rows):
        ci = mpmath.mpf(c[i].numerator) / c[i].denominator
        at = x + ci * h * px + h * h * total(row, 0), y + ci * h * py + h * h * total(row, 1)
        g.append(force(*at))
    miss = [h * h * total(e, k) if lower else 0 for k in range(2)]
    slip = [h * total(d, k) if lower else 0 for k in range(2)]
    return [at[0] - miss[0], at[1] - miss[1], px + h * total(b, 0) - slip[0], py + h * total(b, 1) - slip[1]]


@pytest.mark.parametrize("lower", [False, True])
@pytest.mark.parametrize("pair", PAIRS)
def test_local_error(pair, lower):
    """Local errors of position and momentum fall as h^(p + 1)."""
    order = PAIRS[pair][2 if lower else 1]
    with mpmath.workdps(60):
        exact = mpmath.odefun(lambda _, s: [s[2], s[3], *force(s[0], s[1])], 0,
                              [mpmath.mpf(v) for half in START for v in half], tol=mpmath.mpf(10) ** -55)
        errors = []
        for h in (mpmath.mpf(1) / 32, mpmath.mpf(1) / 64):
            found, truth = step(pair, h, lower), exact(h)
            errors.append([mpmath.sqrt(sum((found[k] - truth[k])**2 for k in part)) for part in ((0, 1), (2, 3))])
        slopes = [float(mpmath.log(a / b, 2)) for a, b in zip(*errors, strict=True)]
    assert all(order + 0.7 < slope for slope in slopes), slopes
    assert min(slopes) < order + 1.5, slopes


@pytest.mark.parametrize("pair", PAIRS)
def test_first_same_as_last(pair):
    """The last stage is the step's end: its row sums to 1/2 and stands at c = 1; row sums are c²/2."""
    stages = PAIRS[pair][0]
    c, rows = table(f"{pair}_c"), table(f"{pair}_A")
    assert len(c) == len(rows) == stages and c[-1] == 1
    allowed = ROUNDED if pair == "rkn12" else 0
    assert all(abs(sum(row) - ci * ci / 2) <= allowed for row, ci in zip(rows, c, strict=True))
    for part, total in (("b", 1), ("e", 0), ("d", 0)):
        assert abs(sum(table(f"{pair}_{part}")) - total) <= allowed


def test_doubles_are_the_fractions():
    """No number loses digits on its way into the header (a literal without a decimal point would divide integers)."""
    for entry in re.findall(r"-?\d+(?:\.\d+)? / \d+(?:\.\d+)?", HEADER):
        assert "." in entry.split("/")[0], entry
        over, under = entry.split("/")
        np.testing.assert_allclose(float(over) / float(under), float(_term(re.sub(r"\s", "", entry))), rtol=1e-15)
