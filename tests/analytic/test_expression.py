"""Formulas: n and ∇n against Python's own arithmetic and differences, digits of small refractivities, rays, statuses.

The oracle evaluates the same text by Python with NumPy in long double: neither our grammar nor SymPy is in it.
"""

import math
import warnings

import numpy as np
import pytest
from oracles import rays
from oracles.fields import OfIndex

import cpm

LONG = np.longdouble
NUMPY = {name: getattr(np, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")} | {
    "asin": np.arcsin, "acos": np.arccos, "atan2": np.arctan2, "abs": np.abs, "min": lambda *a: np.minimum.reduce(np.broadcast_arrays(*a)),
    "max": lambda *a: np.maximum.reduce(np.broadcast_arrays(*a)), "pi": LONG(np.pi)}


def index(text, points, wavelength=587.5618, **constants):
    """n of a formula at (N, 3) points, long double, by Python itself."""
    x, y, z = np.asarray(points, LONG).T
    names = {"x": x, "y": y, "z": z, "r": np.sqrt(x * x + y * y + z * z), "wavelength": LONG(wavelength)}
    value = eval(text, {"__builtins__": {}}, NUMPY | {k: LONG(v) for k, v in constants.items()} | names)  # noqa: S307 - a test's own text
    return value + 0 * x


def slope(text, points, **constants):
    """∇n by central differences of fourth order."""
    out, h = np.empty((len(points), 3)), LONG(1e-4)
    for axis in range(3):
        d = np.zeros(3, LONG)
        d[axis] = h
        f = [index(text, np.asarray(points, LONG) + k * d, **constants) for k in (-2, -1, 1, 2)]
        out[:, axis] = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h)
    return out


FORMULAS = [
    ("1 + N*(1 + e*exp(-y/d))", {"N": 2.77e-4, "e": -0.05, "d": 0.2}),
    ("sqrt(2.25*(1 - 0.1*(x**2 + y**2)))", {}),
    ("2/(1 + r**2)", {}),
    ("1.5 + 0.1*sin(3*x)*cos(2*y - z) + 0.05*tan(z/2)", {}),
    ("1.2 + asin(x/4) + acos(y/5)/9 + atan2(z + 3, x - 4)/10", {}),
    ("1.4 + sinh(x)/20 + cosh(y)/30 + tanh(z*5)/10", {}),
    ("max(1.2 + 0.1*x, 1.1, 1.3 - y*z) + min(x*x, 0.1) + abs(y + 0.123)/8", {}),
    ("1 + E*exp(-S*r) + I/(3 + x) - N*log(4 + y)", {"E": 0.3, "S": 0.7, "I": 0.2, "N": 0.05}),
    ("1.3 + (2 + x)**y/20 + 2**-z/50 + (3 + z)**1.7/90 + (2 + y)**2.5/70 - x**3*y**-0/40", {}),
    ("1 + 1e-4*(wavelength/500)**-2*(3 + x)", {}),
    ("+1.5 - -0.1*x**2/2/(1 + y*y)*3", {}),
    ("pi/2 - .5e-1*(x - y)*(x + y) + 1E-2*z", {}),
    ("1 + exp(-((x - 0.1)**2 + y**2 + z**2))/(1 + exp(-((x - 0.1)**2 + y**2 + z**2)))", {}),
]


@pytest.mark.parametrize(("text", "constants"), FORMULAS, ids=[t for t, _ in FORMULAS])
def test_index_and_gradient(text, constants):
    points = np.random.default_rng(1).uniform(-0.9, 0.9, (300, 3))
    n, gradient = cpm.media.Expression(text, **constants).evaluate(points)
    np.testing.assert_allclose(n, index(text, points, **constants).astype(float), rtol=3e-15)
    if "max" in text:  # differences straddle the kinks
        near = np.abs(gradient - slope(text, points, **constants)).max(axis=1) < 1e-8
        assert near.mean() > 0.95
    else:
        np.testing.assert_allclose(gradient, slope(text, points, **constants), rtol=0, atol=1e-11)


def test_small_refractivity_keeps_its_digits():
    """1 + small, √(1 + small), 1/(1 + small): ∇n to 1e-13 of itself, not of 1."""
    y = np.linspace(-0.05, 0.3, 50)
    points, small = np.column_stack([0 * y, y, 0 * y]), 1e-9 * np.exp(-y / 0.1)
    for text, factor in (("1 + 1e-9*exp(-y/0.1)", 1 + 0 * y), ("sqrt(1 + 1e-9*exp(-y/0.1))", 0.5 / np.sqrt(1 + small)),
                         ("1/(1 + 1e-9*exp(-y/0.1))", -1 / (1 + small) ** 2)):
        _, gradient = cpm.media.Expression(text).evaluate(points)
        np.testing.assert_allclose(gradient[:, 1], -10 * small * factor, rtol=1e-13)


def test_wavelength():
    """A formula of the wavelength disperses by itself, ray by ray; `dispersion` beside it is refused."""
    medium = cpm.media.Expression("1.3 + 0.05*(500/wavelength)**2*exp(-y)")
    waves = np.array([400.0, 550.0, 700.0])
    found = cpm.trace(medium, [(0, 0, 0)] * 3, (1, 0.1, 0), wavelength=waves, length=2.0, rtol=1e-10)
    for i, w in enumerate(waves):
        b = 0.05 * (500 / w) ** 2
        field = OfIndex(lambda r, b=b: (1.3 + b * np.exp(-r[1]), (0, -b * np.exp(-r[1]), 0)))
        np.testing.assert_allclose(found.position[i], rays.trace(field, (0, 0, 0), (1, 0.1, 0), length=2.0).position, atol=1e-9)
    with pytest.raises(ValueError, match="wavelength itself"):
        cpm.media.Expression("1.3 + 0.1/wavelength", dispersion="BK7")
    plain, glass = (cpm.media.Expression("1.3 + 0.1*x", dispersion=d) for d in (None, cpm.dispersion.Cauchy(1.5, 0.02)))
    factor = (0.5 + 0.02 / 0.45**2) / (0.5 + 0.02 / 0.5875618**2)
    np.testing.assert_allclose(glass.evaluate((1, 0, 0), 450)[0] - 1, factor * (plain.evaluate((1, 0, 0))[0] - 1), rtol=1e-13)


@pytest.mark.parametrize(("method", "options", "within"), [("dopri5", {"rtol": 1e-9}, 1e-8), ("rk4", {"step": 0.01}, 1e-8),
                                                           ("euler", {"rtol": 1e-4}, 1e-3)])
def test_rays(method, options, within):
    """Every method, against SciPy at 1e-12."""
    text = "1.5 + 0.1*sin(3*x)*cos(2*y - z)"
    medium = cpm.media.Expression(text)
    rng = np.random.default_rng(2)
    origins, directions = rng.uniform(-1, 1, (12, 3)), rng.normal(size=(12, 3))

    def field(r):
        x, y, z = r
        s, c, u, v = np.sin(3 * x), np.cos(3 * x), np.sin(2 * y - z), np.cos(2 * y - z)
        return 1.5 + 0.1 * s * v, (0.3 * c * v, -0.2 * s * u, 0.1 * s * u)

    found = cpm.trace(medium, origins, directions, wavelength=550, length=3.0, method=method, **options)
    expected = [rays.trace(OfIndex(field), o, d, length=3.0).position for o, d in zip(origins, directions, strict=True)]
    assert np.max(np.linalg.norm(found.position - expected, axis=1)) < within


def test_same_as_layers():
    """A hot road as a formula and as a fine cubic table: the same mirage."""
    heights = np.linspace(0, 1, 2001)
    table = cpm.media.Layered(heights, 1 + 2.77e-4 * (1 - 0.05 * np.exp(-heights / 0.02)))
    road = cpm.media.Expression("1 + N*(1 - 0.05*exp(-y/d))", N=2.77e-4, d=0.02)
    angles = np.linspace(-0.004, 0.003, 20)
    starts, d = np.tile((0, 0.3, 0), (20, 1)), np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    a, b = (cpm.trace(m, starts, d, wavelength=550, length=90.0, rtol=1e-9, max_step=1.0).position for m in (table, road))
    above = b[:, 1] > 0
    assert above.sum() > 10
    np.testing.assert_allclose(a[above], b[above], rtol=0, atol=3e-6)


@pytest.mark.parametrize("text", ["1 + log(y)*0 + sqrt(y)", "1 + y", "1 + y - y + 1/(2 + y) + 0.01*log(1 + y)", "1 - 0.2*exp(-y*900)",
                                  "2 + exp(exp(-9*y))*1e-300", "1.5 + 0*(2 + y)**0.5 + (1 + y)**1.5", "1.5 + sin(1e6*y)*1e-9*log(1 + y)"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_ends_where_it_cannot_be(text, precision):
    """NaN, infinity, n ≤ 0 met on the way: a status, a finite place, no hang."""
    found = cpm.trace(cpm.media.Expression(text), (0, 0.5, 0), [(0.1, -1, 0.05), (0, -1, 0)][:1], wavelength=550, length=50.0, precision=precision,
                      max_evaluations=20_000)
    assert found.status[0] in (cpm.RayStatus.CUTOFF, cpm.RayStatus.STEP_UNDERFLOW, cpm.RayStatus.ARRIVED, cpm.RayStatus.EVALUATIONS_EXHAUSTED)
    assert np.isfinite(found.position).all() and np.isfinite(found.momentum).all() and np.isfinite(found.optical_path).all()
    if "log(1 + y)" in text and found.status[0] != cpm.RayStatus.EVALUATIONS_EXHAUSTED:
        assert found.status[0] in (cpm.RayStatus.CUTOFF, cpm.RayStatus.STEP_UNDERFLOW) and found.position[0, 1] > -1.01


def test_bad_start():
    medium = cpm.media.Expression("1.5 + log(y)")
    with pytest.raises(ValueError, match=r"origins\[1\].*not positive and finite"):
        cpm.trace(medium, [(0, 1, 0), (0, -1, 0)], (1, 0, 0), wavelength=550, length=1.0)


def test_at_the_centre():
    """r = 0, the tip of a cone: a gradient of 0, no NaN; a ray goes out straight, to what the missing gradient costs."""
    medium = cpm.media.Expression("2/(1 + r)")
    n, gradient = medium.evaluate((0, 0, 0))
    assert n[0] == 2 and not gradient.any()
    found = cpm.trace(medium, (0, 0, 0), (1, 0, 0), wavelength=550, length=1.0)
    np.testing.assert_allclose(found.position[0], (1, 0, 0), atol=1e-5)


@pytest.mark.parametrize(("text", "expected"), [("2", 2.0), ("1 + N", 1.25), ("2**3**2/512", 1.0), ("-2**2 + 5", 1.0), ("8/2/2", 2.0),
                                                ("2 - 3 - -4", 3.0), ("2**-1*4", 2.0), ("1.5e0*2", 3.0), ("min(3, max(1, 2), 5)", 2.0), ("9**0.5", 3.0)])
def test_arithmetic(text, expected):
    assert cpm.media.Expression(text, N=0.25).evaluate((0, 0, 0))[0][0] == expected


def test_constants_of_any_name():
    """N, E, S, I, Q, O, lambda_0, self, text, é, exp, pi: plain names; x is the formula's own."""
    text = "1 + N + E + S + I + Q + O + lambda_0 + self + text + é + exp(exp) + pi - cos(pi*x*0)"
    names = ("N", "E", "S", "I", "Q", "O", "lambda_0", "self", "text", "é", "exp", "pi")
    medium = cpm.media.Expression(text, **{name: 0.01 * i for i, name in enumerate(names)})
    expected = 0.01 * sum(range(12)) - 0.10 + math.exp(0.10)
    assert medium.evaluate((0, 0, 0))[0][0] == pytest.approx(expected, rel=1e-14)
    for name in ("x", "y", "z", "r", "wavelength"):
        with pytest.raises(ValueError, match=f"a constant is named '{name}'"):
            cpm.media.Expression("1.5", **{name: 1.0})


def test_single_precision_at_the_scale_of_the_earth_warns():
    medium = cpm.media.Expression("1 + N*exp(-(r - R)/8000)", N=2.77e-4, R=6.4e6)
    with pytest.warns(RuntimeWarning, match=r"Layered\(\.\.\., radius"):
        cpm.trace(medium, (0, 6.4e6 + 2, 0), (1, 0, 0), wavelength=550, length=1e3, precision="single")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cpm.trace(medium, (0, 6.4e6 + 2, 0), (1, 0, 0), wavelength=550, length=1e3)
        cpm.trace(cpm.media.Expression("2/(1 + r)"), (0, 2, 0), (1, 0, 0), wavelength=550, length=1.0, precision="single")


def test_in_a_scene():
    """A formula in a sphere, dispersing: cpm.render runs, and a ray is Snell's at its bounds."""
    lens = cpm.media.Expression("1.4 + 0.1*(1 - x*x - y*y - z*z) + 1e4/wavelength**2", bounds=cpm.Sphere((0, 0, 0), 1.0))
    scene = cpm.Scene(rtol=1e-8)
    scene.add_medium(lens)
    scene.add_mesh([(-5, -5, 3), (5, -5, 3), (0, 5, 3)], [(0, 1, 2)], material=cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Point((0, 0, -3), 1.0))
    scene.camera = cpm.Camera.look_at((0, 0.5, -3), (0, 0, 0), (0, 1, 0), fov=40)
    image = cpm.render(scene, size=(16, 12), photons=20_000, wavelengths={"from": 400, "to": 700, "bins": 3}, progress=False)
    assert np.isfinite(image.data).all() and image.data.max() > 0
    hit = cpm.trace(scene, (0, 0.3, -3), (0, 0, 1), wavelength=550)
    entry = np.array([0, 0.3, -np.sqrt(1 - 0.09)])
    index_at_rim, cosine = 1.4 + 1e4 / 550**2, np.sqrt(1 - 0.09)
    sine = np.sqrt(1 - cosine**2) / index_at_rim
    turned = np.arcsin(0.3) - np.arcsin(sine)
    d = np.array([0, -np.sin(turned), np.cos(turned)])
    field = OfIndex(lambda r: (1.4 + 0.1 * (1 - r @ r) + 1e4 / 550**2, -0.2 * r))
    inside = rays.trace(field, entry, d, until=((0, 0, 0.7), (0, 0, 1)))
    plane = cpm.trace(cpm.media.Expression(lens.text), entry, d, wavelength=550, until=((0, 0, 0.7), (0, 0, 1)), rtol=1e-10)
    np.testing.assert_allclose(plane.position[0], inside.position, atol=1e-9)
    assert hit.status[0] == cpm.RayStatus.HIT and hit.position[0, 1] < 0.3
