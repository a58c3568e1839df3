"""What fibre, Luneburg lens, fish-eye and Eaton lens are known for, by `exact` and integrated (DESIGN section 2)."""

import numpy as np
import pytest
from oracles import central, fields
from oracles import rays as oracle
from oracles.cases import CASES

import cpm

CENTER = np.array([0.3, -0.2, 0.5])
RNG = np.random.default_rng(11)


def trace(medium, origins, directions, **options):
    origins, directions = np.atleast_2d(origins), np.atleast_2d(directions)
    return cpm.trace(medium, origins, directions, wavelength=550.0, **options)


def beam(axis, count=9, width=0.9):
    """Parallel rays along `axis` towards a unit ball about CENTER, from 2 m before it: origins, offsets."""
    axis = np.array(axis) / np.linalg.norm(axis)
    a = np.cross(axis, (0.3, 0.5, -0.8))
    a /= np.linalg.norm(a)
    angles, radii = np.linspace(0, 5, count), np.linspace(0.0, width, count)
    offsets = radii[:, None] * (np.cos(angles)[:, None] * a + np.sin(angles)[:, None] * np.cross(axis, a))
    return CENTER - 2 * axis + offsets, offsets, axis


NUMERIC = [("exact", None, 1e-12), ("dopri5", 1e-9, 3e-8), ("euler", 1e-4, 1e-2)]


@pytest.mark.parametrize("name", ["parabolic", "luneburg", "fisheye", "eaton", "sources"])
def test_field(name):
    """n and its analytic gradient, against the oracle's field and its central differences."""
    case = CASES[name]
    points = np.array(case.origin) + RNG.uniform(-1, 1, (40, 3))
    n, gradient = case.make(cpm).evaluate(points)
    for i, r in enumerate(points):
        square, half = case.field(r)
        assert n[i] == pytest.approx(np.sqrt(square), rel=1e-13)
        np.testing.assert_allclose(n[i] * gradient[i], half, rtol=0, atol=1e-12 * (1 + np.linalg.norm(half)))
        np.testing.assert_allclose(half, fields.numerical_half_gradient(case.field, r), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(("method", "rtol", "limit"), NUMERIC)
def test_fibre_period(method, rtol, limit):
    """After 2π p_z/(n₀α) along the axis a ray is where it was across it, and goes the same way."""
    n, alpha, axis = 1.5, 0.6, np.array([1.0, 2.0, 2.0]) / 3
    across = np.cross(axis, (0, 0, 1.0))
    across /= np.linalg.norm(across)
    origin = CENTER + 0.7 * across
    for d in (axis + 0.3 * across, axis + 0.2 * np.cross(axis, across), axis - 0.4 * across):
        p_z = n * np.sqrt(1 - (alpha * 0.7) ** 2) * (d @ axis) / np.linalg.norm(d)
        period = 2 * np.pi * p_z / (n * alpha)
        medium = cpm.media.Parabolic(n, alpha, axis, CENTER)
        rays = trace(medium, origin, d, until=(origin + period * axis, axis), method=method, rtol=rtol)
        assert np.linalg.norm(rays.position[0] - origin - period * axis) < limit * period
        np.testing.assert_allclose(rays.direction[0], d / np.linalg.norm(d), rtol=0, atol=10 * limit)


def test_fibre_arc_length():
    """Half a period in a meridional plane from the axis: the complete elliptic integral of SciPy."""
    from scipy.special import ellipe

    n, alpha, slope = 1.5, 0.8, 0.7
    p, p_z = n * np.sin(slope), n * np.cos(slope)
    # speed² = p_z² + p² cos² u = n² (1 − (p/n)² sin² u), dσ = du/(n α): u over π/2 to the turning point
    quarter = n * ellipe((p / n) ** 2) / (n * alpha)
    medium = cpm.media.Parabolic(n, alpha)
    d = (np.sin(slope), 0, np.cos(slope))
    rays = trace(medium, np.zeros((3, 3)), [d] * 3, length=np.array([1, 2, 7]) * quarter)
    amplitude, quarter_z = p / (n * alpha), p_z * 0.5 * np.pi / (n * alpha)
    expected = [(amplitude, 0, quarter_z), (0, 0, 2 * quarter_z), (-amplitude, 0, 7 * quarter_z)]
    np.testing.assert_allclose(rays.position, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("method", "rtol", "limit"), NUMERIC)
def test_luneburg_focus(method, rtol, limit):
    """Parallel light meets at the antipode, and each ray's optical path there is the same (Fermat)."""
    origins, offsets, axis = beam((1, 0.4, -0.3))
    rays = trace(cpm.media.Luneburg(1.0, CENTER), origins, axis + 0 * origins, until=(CENTER + axis, axis),
                 method=method, rtol=rtol)  # fmt: skip
    assert np.all(rays.status == 0)
    assert np.max(np.linalg.norm(rays.position - CENTER - axis, axis=1)) < 5 * limit
    assert np.ptp(rays.optical_path) < 5 * limit


@pytest.mark.parametrize(("method", "rtol", "limit"), NUMERIC)
def test_fisheye_image(method, rtol, limit):
    """All rays of a point meet in its image −r a²/|r|² with optical path π n₀ a/2; there and back is a circle."""
    n, a, y = 1.7, 1.2, np.array([0.5, -0.3, 0.6])
    image = CENTER - y * a * a / (y @ y)
    medium = cpm.media.Fisheye(n, a, CENTER)
    for d in RNG.normal(size=(6, 3)):
        d = d / np.linalg.norm(d)
        big = (a * a + y @ y) / (2 * np.linalg.norm(y - (y @ d) * d))  # the circle's radius
        chord = image - CENTER - y
        length = 2 * big * np.arccos(d @ chord / np.linalg.norm(chord))  # twice the angle of tangent and chord
        rays = trace(medium, CENTER + y, d, length=length, method=method, rtol=rtol)
        assert np.linalg.norm(rays.position[0] - image) < 20 * limit
        assert rays.optical_path[0] == pytest.approx(0.5 * np.pi * n * a, abs=20 * limit)
        circumference = 2 * np.pi * big
        if method == "exact":
            rays = trace(medium, CENTER + y, d, length=circumference)
            assert np.linalg.norm(rays.position[0] - CENTER - y) < 1e-12 * circumference
            assert rays.optical_path[0] == pytest.approx(np.pi * n * a, rel=1e-12)


@pytest.mark.parametrize(("method", "rtol", "limit"), NUMERIC)
def test_eaton_retro_reflects(method, rtol, limit):
    """Every ray leaves antiparallel, as far on the other side: half an ellipse, its centre the lens's focus."""
    origins, offsets, axis = beam((0.2, -1, 0.6))
    origins, offsets = origins[1:], offsets[1:]
    rays = trace(cpm.media.Eaton(1.0, CENTER), origins, axis + 0 * origins, length=6.5, method=method, rtol=rtol)
    out = rays.position - CENTER
    assert np.all(rays.status == 0) and np.all(out @ axis < -1)
    np.testing.assert_allclose(rays.direction, -axis + 0 * origins, rtol=0, atol=30 * limit)
    np.testing.assert_allclose(out - (out @ axis)[:, None] * axis, -offsets, rtol=0, atol=100 * limit)


@pytest.mark.parametrize("kind", ["luneburg", "eaton"])
def test_in_and_out(kind):
    """Random rays from outside and inside, through the lens and beyond, to rounding: straight, ellipse, straight."""
    make = {"luneburg": cpm.media.Luneburg, "eaton": cpm.media.Eaton}[kind](1.0, CENTER)
    origins = CENTER + RNG.uniform(-1.6, 1.6, (200, 3))
    directions, lengths = RNG.normal(size=(200, 3)), RNG.uniform(0, 6, 200)
    rays = trace(make, origins, directions, length=lengths)
    for i in range(200):
        expected = getattr(central, kind)(1.0, CENTER, origins[i], directions[i], length=lengths[i])
        # near Eaton's centre the way out is a sensitive function of the way in
        y = origins[i] - CENTER
        slack = 1.0 if kind == "luneburg" else 1 + 1 / np.linalg.norm(np.cross(y, directions[i]))
        assert np.linalg.norm(rays.position[i] - expected.position) < 3e-13 * slack * (1 + lengths[i])
        assert np.linalg.norm(rays.momentum[i] - expected.momentum) < 2e-12 * slack**2
        assert rays.optical_path[i] == pytest.approx(expected.optical_path, abs=1e-12 * slack)


@pytest.mark.parametrize("kind", ["parabolic", "fisheye"])
def test_any_plane(kind):
    """Random planes, the first crossing of each; where there is none the ray has left, or never comes."""
    parameters = {"parabolic": (1.5, 0.6, (1.0, 2.0, 2.0), CENTER), "fisheye": (1.7, 1.2, CENTER)}[kind]
    medium = {"parabolic": cpm.media.Parabolic, "fisheye": cpm.media.Fisheye}[kind](*parameters)
    curve_of = getattr(central, kind + "_curve")
    met = 0
    for _ in range(150):
        origin, d = CENTER + RNG.uniform(-0.6, 0.6, 3), RNG.normal(size=3)
        point, normal = CENTER + RNG.uniform(-1, 1, 3), RNG.normal(size=3)
        curve = curve_of(*parameters, origin, d)
        x = curve.x_of_plane(point, normal, 0.02)
        rays = trace(medium, origin, d, until=(point, normal))
        if not np.isfinite(x):
            assert rays.status[0] == cpm.RayStatus.LEFT
            continue
        expected = curve.at(np.array([x]))[0][0]
        assert np.linalg.norm(rays.position[0] - expected) < 1e-11 * (1 + curve.length(x))
        assert rays.length[0] == pytest.approx(curve.length(x), abs=1e-11)
        met += 1
    assert met > 60


@pytest.mark.parametrize("kind", ["parabolic", "luneburg", "fisheye", "eaton"])
def test_scaled_by_dispersion(kind):
    """n² − 1 (the fish-eye's n₀ − 1) scales as its dispersion does; exact paths stay those of DOP853."""
    glass = cpm.dispersion.Cauchy(1.5, 0.02)
    medium = {"parabolic": cpm.media.Parabolic(1.5, 0.4, dispersion=glass),
              "luneburg": cpm.media.Luneburg(2.0, dispersion=glass),
              "fisheye": cpm.media.Fisheye(1.7, 1.2, dispersion=glass),
              "eaton": cpm.media.Eaton(2.0, dispersion=glass)}[kind]  # fmt: skip
    wavelength, d_line = 430.0, 587.5618
    n, n_d = glass.n(np.array([wavelength, d_line]))
    s, t = (n**2 - 1) / (n_d**2 - 1), (n - 1) / (n_d - 1)
    field = {
        "parabolic": fields.OfRadius(None),
        "luneburg": fields.OfRadius(lambda r: (1 + s * (1 - r * r / 4), -s * r / 2)),
        "fisheye": fields.fisheye(1 + t * 0.7, 1.2),
        "eaton": fields.OfRadius(lambda r: (1 + s * (4 / r - 2), -4 * s / r**2)),
    }[kind]
    if kind == "parabolic":
        field = lambda r: (1 + s * (2.25 * (1 - 0.16 * (r[0] ** 2 + r[1] ** 2)) - 1), -s * 0.36 * np.array([r[0], r[1], 0]))  # noqa: E731
        field = type("Fibre", (), {"__call__": staticmethod(field), "max_step": np.inf})()
    for origin, d in [((0.5, 0.4, -0.3), (1, 0.2, 0.7)), ((-0.4, 0.2, 0.6), (0.3, -1, 0.1))]:
        expected = oracle.trace(field, origin, d, length=1.0)
        got = cpm.trace(medium, [origin], [d], wavelength=wavelength, length=1.0)
        assert got.method[0] == "exact"
        np.testing.assert_allclose(got.position[0], expected.position, rtol=0, atol=2e-12)
        np.testing.assert_allclose(got.momentum[0], expected.momentum, rtol=0, atol=2e-11)
        assert got.optical_path[0] == pytest.approx(expected.optical_path, abs=2e-11)


def test_dispersion_that_unmakes_a_lens():
    """An Eaton lens whose n² − 1 is halved has no ellipses left: refused when the wavelength is used."""
    falling = cpm.dispersion.Tabulated([400, 587.5618, 800], [1.5, 1.5, 1.2])
    medium = cpm.media.Eaton(1.0, dispersion=falling)
    cpm.trace(medium, [(0.5, 0, 0)], [(0, 1, 0)], wavelength=500.0, length=0.2)
    with pytest.raises(ValueError, match="0.5"):
        cpm.trace(medium, [(0.5, 0, 0)], [(0, 1, 0)], wavelength=800.0, length=0.2)
