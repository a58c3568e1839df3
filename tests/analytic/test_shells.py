"""Spherical layers: field, exact paths, Snell between shells, Bouguer's invariant, and rays on the scale of the Earth."""

import numpy as np
import pytest
from oracles import rays, shells
from scipy.interpolate import CubicSpline

import cpm

RADIUS = 3.5
UP, ORIGIN = np.array([0.6, 0.8, 0.0]), (0.3, -0.2, 0.1)
HEIGHTS = np.array([-0.8, -0.3, 0.0, 0.4, 0.7, 1.2])
FALLING = np.array([1.5, 1.42, 1.40, 1.3, 1.2, 1.15])
DUCT = np.array([1.1, 1.25, 1.45, 1.3, 1.05, 1.2])  # bends down more than its spheres, 0.4 to 0.7: rays are trapped
CENTRE = np.array(ORIGIN) - RADIUS * UP


def layered(n=FALLING, interpolation="linear-squared", **options):
    return cpm.media.Layered(HEIGHTS, n, up=UP, origin=ORIGIN, radius=RADIUS, interpolation=interpolation, **options)


def bundle(count, seed):
    """Starts between and beyond the shells, all directions."""
    rng = np.random.default_rng(seed)
    out = rng.normal(size=(count, 3))
    rho = RADIUS + rng.uniform(-1.0, 1.5, count)
    return CENTRE + out / np.linalg.norm(out, axis=1)[:, None] * rho[:, None], rng.normal(size=(count, 3))


@pytest.mark.parametrize("interpolation", ["cubic", "linear-squared", "step"])
def test_index_and_gradient(interpolation):
    points, _ = bundle(300, 1)
    n, gradient = layered(interpolation=interpolation).evaluate(points)
    spline = CubicSpline(HEIGHTS, FALLING, bc_type="natural")
    for r, index, slope in zip(points, n, gradient, strict=True):
        h, out = shells.height(r, RADIUS, UP, ORIGIN)
        inside = HEIGHTS[0] < h < HEIGHTS[-1]
        if interpolation == "step":
            expected, rise = FALLING[np.clip(np.searchsorted(HEIGHTS, h) - 1, 0, 5)], 0.0
        elif interpolation == "cubic":
            clipped = np.clip(h, HEIGHTS[0], HEIGHTS[-1])
            expected, rise = float(spline(clipped)), float(spline(clipped, 1)) if inside else 0.0
        else:
            rho2 = (RADIUS + HEIGHTS) ** 2
            expected = np.sqrt(np.interp((RADIUS + h) ** 2, rho2, FALLING**2))
            i = np.clip(np.searchsorted(HEIGHTS, h) - 1, 0, 4)
            slope2 = (FALLING[i + 1] ** 2 - FALLING[i] ** 2) / (rho2[i + 1] - rho2[i])
            rise = slope2 * (RADIUS + h) / expected if inside else 0.0
        assert index == pytest.approx(expected, rel=1e-13)
        np.testing.assert_allclose(slope, rise * out, rtol=0, atol=1e-12)


@pytest.mark.parametrize("n", [FALLING, DUCT], ids=["falling", "duct"])
def test_exact_linear_squared(n):
    """n² linear in ρ²: circular or hyperbolic functions, against ODEs that end at each face."""
    origins, directions = bundle(60, 2)
    found = cpm.trace(layered(n), origins, directions, wavelength=550, length=6.0)
    assert set(found.method) == {"exact"} and np.all(found.status == cpm.RayStatus.ARRIVED)
    for i in range(len(origins)):
        r, p, optical = shells.linear_squared(HEIGHTS, n, RADIUS, origins[i], directions[i], 6.0, UP, ORIGIN)
        np.testing.assert_allclose(found.position[i], r, rtol=0, atol=2e-10)
        np.testing.assert_allclose(found.momentum[i], p, rtol=0, atol=2e-10)
        assert found.optical_path[i] == pytest.approx(optical, abs=2e-10)


@pytest.mark.parametrize("n", [FALLING, DUCT], ids=["falling", "duct"])
def test_step(n):
    """Discrete layers: straight, Snell and total reflection at each sphere."""
    origins, directions = bundle(60, 3)
    found = cpm.trace(layered(n, "step"), origins, directions, wavelength=550, length=9.0)
    for i in range(len(origins)):
        r, p, optical = shells.step(HEIGHTS, n, RADIUS, origins[i], directions[i], 9.0, UP, ORIGIN)
        np.testing.assert_allclose(found.position[i], r, rtol=0, atol=1e-9)
        np.testing.assert_allclose(found.momentum[i], p, rtol=0, atol=1e-9)
        assert found.optical_path[i] == pytest.approx(optical, abs=1e-9)


@pytest.mark.parametrize("interpolation", ["linear-squared", "step", "cubic"])
def test_bouguer(interpolation):
    """D × p, of size n ρ sin φ, is the same all along a ray."""
    origins, directions = bundle(100, 4)
    found = cpm.trace(layered(DUCT, interpolation), origins, directions, wavelength=550, length=30.0, rtol=1e-10)
    before = np.cross(origins - CENTRE, directions / np.linalg.norm(directions, axis=1)[:, None])
    n, _ = layered(DUCT, interpolation).evaluate(origins)
    np.testing.assert_allclose(np.cross(found.position - CENTRE, found.momentum), before * n[:, None],
                               rtol=0, atol=1e-7 if interpolation == "cubic" else 1e-11)


@pytest.mark.parametrize(("method", "options", "within"), [("dopri5", {"rtol": 1e-9}, 3e-8), ("rk4", {"step": 0.002}, 1e-3),
                                                           ("euler", {"rtol": 1e-4}, 2e-3)])
@pytest.mark.parametrize("interpolation", ["linear-squared", "cubic"])
def test_integrated(interpolation, method, options, within):
    """Every method ends where the exact path, or an independent integrator, does: in several layers, over kinks.

    Fixed steps do not end at kinks: a jump of 0.3/m of slope in the middle of 2 mm turns a ray by 1e-4, 3 m before its end.
    """
    origins, directions = bundle(24, 5)
    medium = layered(interpolation=interpolation)
    found = cpm.trace(medium, origins, directions, wavelength=550, length=3.0, method=method, **options)
    if interpolation == "linear-squared":
        expected = cpm.trace(medium, origins, directions, wavelength=550, length=3.0).position  # test_exact_linear_squared
    else:
        spline = CubicSpline(HEIGHTS, FALLING - 1, bc_type="natural")

        def refractivity(h):
            c = np.clip(h, HEIGHTS[0], HEIGHTS[-1])
            return float(spline(c)), float(spline(c, 1)) * (HEIGHTS[0] < h < HEIGHTS[-1])

        field = shells.OfHeight(refractivity, RADIUS, UP, ORIGIN, max_step=0.005)
        expected = np.array([rays.trace(field, o, d, length=3.0).position for o, d in zip(origins, directions, strict=True)])
    assert np.max(np.linalg.norm(found.position - expected, axis=1)) < within


def test_order():
    """rk4 within one layer: fourth order, against the closed form."""
    medium = cpm.media.Layered([-3.0, 2.0], [1.6, 1.1], radius=RADIUS, interpolation="linear-squared")
    start, d = (0.0, 0.1, 0.0), (1.0, 0.3, 0.2)
    exact = cpm.trace(medium, start, d, wavelength=550, length=2.0).position
    errors = [np.linalg.norm(cpm.trace(medium, start, d, wavelength=550, length=2.0, method="rk4", step=h).position - exact) for h in (0.2, 0.1, 0.05)]
    assert all(13 < a / b < 19 for a, b in zip(errors[:-1], errors[1:], strict=True))


def test_plane_and_samples():
    """Ended by a plane, the ray is the one that is ended by its length there; samples lie on it."""
    origins, directions = bundle(80, 6)
    for n in (FALLING, DUCT):
        medium = layered(n)
        point, normal = CENTRE + (0.2, 3.6, 0.1), (0.1, 1.0, 0.3)
        ended = cpm.trace(medium, origins, directions, wavelength=550, until=(point, normal), path=7)
        there = ended.status == cpm.RayStatus.ARRIVED
        assert 20 < there.sum() < 80
        np.testing.assert_allclose((ended.position[there] - point) @ normal, 0, atol=1e-11)
        again = cpm.trace(medium, origins[there], directions[there], wavelength=550, length=ended.length[there])
        np.testing.assert_allclose(ended.position[there], again.position, rtol=0, atol=1e-10)
        half = cpm.trace(medium, origins[there], directions[there], wavelength=550, length=0.5 * ended.length[there])
        np.testing.assert_allclose(ended.paths[there][:, 3], half.position, rtol=0, atol=1e-10)


def test_round_with_a_face():
    """Level on the axis of a duct: the ray goes round with the sphere, however long."""
    start, d = CENTRE + RADIUS * UP, np.array([0.8, -0.6, 0.0])
    duct = cpm.media.Layered([-0.5, 0.0, 0.2], [1.2, 1.45, 1.2], up=UP, origin=ORIGIN, radius=RADIUS, interpolation="linear-squared")
    found = cpm.trace(duct, start, d, wavelength=550, length=100.0)
    angle = 100.0 / RADIUS
    np.testing.assert_allclose(found.position[0], CENTRE + RADIUS * (np.cos(angle) * UP + np.sin(angle) * d), atol=1e-10)


def test_many_periods():
    """One layer from near the centre out: an ellipse about it, closed form, counted in whole periods."""
    medium = cpm.media.Layered([-3.4, -0.5], [1.6, 0.6], radius=RADIUS, interpolation="linear-squared")
    centre, rho2 = np.array([0.0, -RADIUS, 0.0]), np.array([0.1**2, 3.0**2])
    c = (0.6**2 - 1.6**2) / (rho2[1] - rho2[0])
    w, start = np.sqrt(-c), np.array([2.0, 0.0, 0.0])
    n = np.sqrt(1.6**2 + c * (4.0 - rho2[0]))
    p = n * np.array([0.3, 0.8, np.sqrt(1 - 0.73)])
    phase = np.linspace(0, 2 * np.pi, 4097)[:-1]
    speeds = np.linalg.norm(-2.0 * w * np.sin(phase)[:, None] * [1, 0, 0] + np.cos(phase)[:, None] * p, axis=1)
    around = speeds.mean() * 2 * np.pi / w  # the trapezoid over a period: exact to rounding
    found = cpm.trace(medium, [centre + start] * 2, p, wavelength=550, length=[around, 1000 * around])
    np.testing.assert_allclose(found.position, np.broadcast_to(centre + start, (2, 3)), atol=1e-9)
    np.testing.assert_allclose(found.momentum, np.broadcast_to(p, (2, 3)), atol=1e-9)


def test_berger_trout_converges():
    """Discrete layers, finer and finer, towards the smooth profile: second order in their thickness."""
    fine = np.linspace(-0.5, 1.5, 4001)
    smooth = cpm.media.Layered(fine, 1 + 0.3 * np.exp(-fine), radius=RADIUS)
    start, d = (0.0, 0.04, 0.0), (1.0, 0.35, 0.2)  # the middle of a layer, of each set
    expected = cpm.trace(smooth, start, d, wavelength=550, length=2.5, rtol=1e-11).position[0]
    errors = []
    for count in (50, 150, 450):
        edges = np.linspace(-0.5, 1.5, count + 1)
        layers = cpm.media.Layered(edges[:-1], 1 + 0.3 * np.exp(-0.5 * (edges[1:] + edges[:-1])), radius=RADIUS, interpolation="step")
        errors.append(np.linalg.norm(cpm.trace(layers, start, d, wavelength=550, length=2.5).position[0] - expected))
    assert errors[0] > 6 * errors[1] > 36 * errors[2] and errors[2] < 1e-4


@pytest.mark.parametrize("interpolation", ["cubic", "linear-squared", "step"])
def test_flat_limit(interpolation):
    """A radius of 1e9 m is flat to L²/(2R)."""
    origins, directions = np.random.default_rng(8).uniform(-1, 1, (2, 40, 3))
    flat, round_ = (cpm.media.Layered(HEIGHTS, FALLING, radius=r, interpolation=interpolation) for r in (None, 1e9))
    a, b = (cpm.trace(m, origins, directions, wavelength=550, length=2.0, rtol=1e-10) for m in (flat, round_))
    np.testing.assert_allclose(a.position, b.position, rtol=0, atol=3e-8)


def test_in_a_scene():
    """cpm.render's tracer and cpm.trace agree: a wall met through the shells, exact (quintics) and integrated."""
    origins, directions = bundle(50, 9)
    for interpolation in ("linear-squared", "step", "cubic"):
        medium = layered(DUCT, interpolation)
        scene = cpm.Scene(medium=medium, extent=cpm.Box((-30, -30, -30), (30, 30, 30)), rtol=1e-9)
        at = CENTRE[1] + 3.7
        scene.add_mesh([(-20, at, -20), (-20, at, 20), (20, at, 20), (20, at, -20)], [(0, 1, 2), (0, 2, 3)],
                       material=cpm.materials.Black())
        hit = cpm.trace(scene, origins, directions, wavelength=550)
        alone = cpm.trace(medium, origins, directions, wavelength=550, until=((0, at, 0), (0, 1, 0)), rtol=1e-9, max_evaluations=3000)
        both = (hit.status == cpm.RayStatus.HIT) & (alone.status == cpm.RayStatus.ARRIVED)
        assert both.sum() > 12
        np.testing.assert_allclose(hit.position[both], alone.position[both], rtol=0, atol=1e-6 if interpolation == "cubic" else 1e-9)


@pytest.mark.parametrize(("options", "message"), [({"radius": -1.0}, "radius is -1"), ({"radius": 0.0}, "radius is 0"),
                                                  ({"radius": np.inf}, "radius is inf"), ({"radius": "a"}, "radius"),
                                                  ({"radius": 0.8}, r"heights\[0\] is -0.8")])
def test_refused(options, message):
    with pytest.raises((ValueError, TypeError), match=message):
        cpm.media.Layered(HEIGHTS, FALLING, **options)


# ---------------------------------------------------------------------------------------------------------- the Earth

EARTH, FAR = 6.4e6, 5e5
GRID = np.linspace(-100.0, 9.0e4, 1803)


def air(h):
    return 2.77e-4 * np.exp(-h / 8000.0)


@pytest.fixture(scope="module")
def horizon():
    """The 500 km horizon ray from 2 m (ANCHORS, case 5) at 1e-12, n the spline through the table."""
    spline = CubicSpline(GRID, air(GRID), bc_type="natural")
    field = shells.OfHeight(lambda h: (float(spline(h)), float(spline(h, 1))), EARTH, max_step=2000.0)
    return rays.trace(field, (0, 2, 0), (1, 0, 0), length=FAR)


@pytest.mark.parametrize(("precision", "within"), [("double", 1e-3), ("single", 0.1)])
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (3e7, -4e7, 1e7)], ids=["origin", "moved"])
def test_horizon(horizon, precision, within, shift):
    """Position ≤ 1 mm in double, ≤ 0.1 m in float lanes, wherever the coordinates' origin is."""
    medium = cpm.media.Layered(GRID, 1 + air(GRID), radius=EARTH, origin=shift)
    start = np.array([0, 2.0, 0]) + shift
    found = cpm.trace(medium, start, (1, 0, 0), wavelength=550, length=FAR, rtol=1e-9 if precision == "double" else 1e-6, precision=precision)
    assert found.status[0] == cpm.RayStatus.ARRIVED
    assert np.linalg.norm(found.position[0] - shift - horizon.position) <= within
    assert found.optical_path[0] == pytest.approx(horizon.optical_path, abs=2 * within)


@pytest.mark.parametrize("method", ["euler", "rk4", "dopri5"])
def test_single_keeps_up_with_double(method):
    """Float lanes end within 0.1 m of double ones by every method, in any direction, over 500 km."""
    medium = cpm.media.Layered(GRID, 1 + air(GRID), radius=EARTH)
    rng = np.random.default_rng(10)
    d = np.column_stack([rng.normal(size=16), rng.uniform(-0.004, 0.01, 16), rng.normal(size=16)])
    options = {"step": 1000.0} if method == "rk4" else {"rtol": 1e-4, "max_step": 2000.0} if method == "euler" else {"rtol": 1e-6}
    a, b = (cpm.trace(medium, (0, 1000.0, 0), d, wavelength=550, length=FAR, method=method, precision=precision, **options)
            for precision in ("double", "single"))
    assert np.max(np.linalg.norm(a.position - b.position, axis=1)) < 0.1


def test_horizon_linear_squared():
    """Exact through hundreds of thin shells, against an ODE that sees the same n² in steps of 100 m."""
    heights = np.linspace(-100.0, 9e4, 1803)
    medium = cpm.media.Layered(heights, 1 + air(heights), radius=EARTH, interpolation="linear-squared")
    found = cpm.trace(medium, (0, 2, 0), (1, 0, 0), wavelength=550, length=FAR)
    assert found.method[0] == "exact"
    rho2 = EARTH * 2 * heights + heights**2  # ρ² − R²

    def refractivity(h):
        s = np.interp(h * (2 * EARTH + h), rho2, air(heights) * (2 + air(heights)))
        i = np.clip(np.searchsorted(heights, h) - 1, 0, len(heights) - 2)
        a = air(heights[i : i + 2])
        slope = (a[1] - a[0]) * (2 + a[0] + a[1]) / ((heights[i + 1] - heights[i]) * (2 * EARTH + heights[i] + heights[i + 1]))
        n = np.sqrt(1 + s)
        return s / (1 + n), slope * (EARTH + h) / n

    field = shells.OfHeight(refractivity, EARTH, max_step=100.0)
    expected = rays.trace(field, (0, 2, 0), (1, 0, 0), length=FAR)
    assert np.linalg.norm(found.position[0] - expected.position) <= 1e-3
