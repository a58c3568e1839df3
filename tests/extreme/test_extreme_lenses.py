"""Centres without a bound, unstable orbits, cut-offs, a million periods, scales from 1e-9 to 1e9 m (DESIGN section 13)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import central, fields
from oracles import rays as oracle

import cpm

ARRIVED, CAPTURED, CUTOFF = cpm.RayStatus.ARRIVED, cpm.RayStatus.CAPTURED, cpm.RayStatus.CUTOFF
CENTER = np.array([0.3, -0.2, 0.5])


def trace(medium, origin, direction, **options):
    return cpm.trace(medium, np.atleast_2d(origin), np.atleast_2d(direction), wavelength=550.0, **options)


def aimed(impact, distance=3.0, axis=(1.0, 2.0, 2.0)):
    """A ray that passes CENTER at `impact` if nothing bends it; the axis, and the side that it is on."""
    axis = np.array(axis) / np.linalg.norm(axis)
    side = np.cross(axis, (0, 0, 1.0))
    side /= np.linalg.norm(side)
    return CENTER - distance * axis + impact * side, axis, side


# --- Eaton's centre ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("impact", [0.0, 1e-300, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
def test_eaton_near_misses_exact(impact):
    """Straight at the centre and past it by next to nothing: back antiparallel, offset −b, path 4R + the way outside."""
    origin, axis, side = aimed(impact)
    rays = trace(cpm.media.Eaton(1.0, CENTER), origin, axis, length=7.0)
    assert rays.status[0] == ARRIVED
    np.testing.assert_allclose(rays.direction[0], -axis, rtol=0, atol=1e-9)
    # 2 m to the sphere, 2 R within at b → 0 (a flat ellipse's half perimeter is 2R), 3 m out again
    way = 2 * np.sqrt(1 - impact**2) + 0.0 if impact < 1e-9 else None
    out = rays.position[0] - CENTER
    assert out @ side == pytest.approx(-impact, abs=1e-12)
    if way is not None:
        assert out @ axis == pytest.approx(-4.0, abs=1e-12)
        assert rays.optical_path[0] == pytest.approx(7 + np.pi, abs=1e-12)  # ∫√(2/r − 1) dr = 1 + π/2 each way


@pytest.mark.parametrize("length", [2.0 + 1e-3, 3.0 - 1e-12, 3.0, 3.0 + 1e-12, 4.0])
def test_eaton_into_the_centre(length):
    """Ends before, at and after the centre: finite, on the line, unit direction."""
    origin, axis, _ = aimed(0.0)
    rays = trace(cpm.media.Eaton(1.0, CENTER), origin, axis, length=length, path=11)
    assert rays.status[0] == ARRIVED
    np.testing.assert_allclose(rays.position[0], CENTER - abs(3.0 - length) * axis, rtol=0, atol=1e-12)
    assert np.linalg.norm(rays.direction[0]) == pytest.approx(1.0, abs=1e-14)
    assert np.all(np.isfinite(rays.paths)) and np.all(np.isfinite(rays.momentum)) and np.isfinite(rays.drift[0])


@pytest.mark.parametrize("method", ["dopri5", "euler"])
@pytest.mark.parametrize(("center", "near"), [(np.zeros(3), 1e-9), (CENTER, 1e-5)], ids=["at 0", "away"])
def test_eaton_captures_what_is_integrated(method, center, near):
    """Integrated, a ray straight at the centre is captured there, or where its coordinates are too coarse."""
    origin, axis, _ = aimed(0.0)
    rtol = 1e-6 if method == "dopri5" else 1e-3
    rays = trace(cpm.media.Eaton(1.0, center), origin - CENTER + center, axis, length=7.0, method=method, rtol=rtol)
    assert rays.status[0] == CAPTURED
    assert np.linalg.norm(rays.position[0] - center) < near
    assert np.all(np.isfinite(rays.momentum))


@pytest.mark.parametrize("impact", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("center", [np.zeros(3), CENTER], ids=["at 0", "away"])
def test_eaton_near_misses_integrated(impact, center):
    """dopri5 past the centre returns antiparallel too, or says that it could not: where the centre is not at 0, rounding
    of coordinates leaves a ray little within 1e-6 R of it."""
    origin, axis, side = aimed(impact)
    medium = cpm.media.Eaton(1.0, center)
    rays = trace(medium, origin - CENTER + center, axis, length=7.0, method="dopri5", rtol=1e-9)
    if rays.status[0] == CAPTURED:
        assert impact < (3e-6 if center[0] == 0 else 2e-3)
        assert np.linalg.norm(rays.position[0] - center) < 1e-5
        return
    assert rays.status[0] == ARRIVED
    # |p|² − 1 at the end is δ·∇n² at the periapsis r = b²/2, δ the rounding of a coordinate there
    rounding = 1e-8 + 1e-15 * (np.max(np.abs(center)) + impact**2) / impact**4
    assert np.linalg.norm(rays.direction[0] + axis) < 100 * rounding
    assert (rays.position[0] - center) @ side == pytest.approx(-impact, abs=100 * rounding)


def test_start_at_the_centre():
    """Exactly there: `exact` goes straight out along the direction; integrated it is captured at once."""
    axis = np.array([0.6, 0.0, 0.8])
    rays = trace(cpm.media.Eaton(1.0, CENTER), CENTER, axis, length=2.0)
    assert rays.status[0] == ARRIVED
    np.testing.assert_allclose(rays.position[0], CENTER + 2 * axis, rtol=0, atol=1e-12)
    for medium in (cpm.media.Eaton(1.0, CENTER), cpm.media.Sources([CENTER], 0.1, 2)):
        rays = trace(medium, CENTER, axis, length=2.0, method="dopri5")
        assert rays.status[0] == CAPTURED and np.all(np.isfinite(rays.momentum))
        np.testing.assert_array_equal(rays.position[0], CENTER)


# --- gravity centres and lines ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("strength", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("method", ["auto", "euler"])
def test_critical_impact(strength, method):
    """n = 1 + m/r²: impact 2√m parts those that fall in from those that turn; n r sin φ = b is conserved."""
    unit = np.sqrt(strength)
    far = 2000.0  # n there is 1 + 2.5e-7
    for factor, status in [(0.5, CAPTURED), (0.95, CAPTURED), (1.05, ARRIVED), (3.0, ARRIVED)]:
        medium = cpm.media.Sources([CENTER * unit], strength, 2)
        start = CENTER * unit + unit * np.array([-far, 2 * factor, 0])
        rtol = 1e-8 if method == "auto" else 1e-3
        rays = trace(medium, start, (1, 0, 0), length=2 * far * unit, method=method, rtol=rtol)
        assert rays.status[0] == status, factor
        if status == CAPTURED:
            assert np.linalg.norm(rays.position[0] - CENTER * unit) < 1e-2 * unit
        else:
            bouguer = np.linalg.norm(np.cross(rays.position[0] - CENTER * unit, rays.momentum[0]))
            assert bouguer == pytest.approx(2 * factor * unit, rel=1e-4 if method == "auto" else 0.1)


def test_close_to_critical():
    """Within 1e-6 of the critical impact: ln(1e6) turns of the unstable orbit more or less, then in or out."""
    start = np.array([-2000.0, 0, 0])
    n = 1 + 1 / 2000.0**2
    for excess, status in [(-1e-6, CAPTURED), (1e-6, ARRIVED)]:
        sine = 2 * (1 + excess) / (n * 2000.0)  # n r sin φ = 2 (1 + excess)
        d = np.array([np.sqrt(1 - sine**2), sine, 0])
        rays = trace(cpm.media.Sources([(0, 0, 0)], 1.0, 2), start, d, length=3000.0, rtol=1e-11)
        assert rays.status[0] == status


def test_unstable_orbit():
    """At r = √m across the radius: round and round, until e^σ has made 1e-9 of it; DOP853 at 1e-12 is there after a turn."""
    m = 0.49
    medium, field = cpm.media.Sources([(0, 0, 0)], m, 2), fields.Sources(((0, 0, 0),), (m,), (2,), ((0, 0, 0),))
    turn = 2 * np.pi * np.sqrt(m)
    rays = trace(medium, (np.sqrt(m), 0, 0), (0, 1, 0), length=turn, rtol=1e-11)
    assert rays.status[0] == ARRIVED
    np.testing.assert_allclose(rays.position[0], (np.sqrt(m), 0, 0), rtol=0, atol=1e-7)
    for nudge in (1.02, 0.98):
        expected = oracle.trace(field, (nudge * np.sqrt(m), 0, 0), (0, 1, 0), length=2.0)
        rays = trace(medium, (nudge * np.sqrt(m), 0, 0), (0, 1, 0), length=2.0, rtol=1e-11)
        np.testing.assert_allclose(rays.position[0], expected.position, rtol=0, atol=1e-8)


def test_exponent_one():
    """n = 1 + m/r: n r = r + m, so b < m falls in (a logarithmic spiral at last), b > m turns at r = b − m."""
    m = 0.5
    medium = cpm.media.Sources([(0, 0, 0)], m, 1)
    for b, status in [(0.4, CAPTURED), (0.6, ARRIVED)]:
        start = np.array([-50.0, 0, 0])
        sine = b / (50.0 + m)
        rays = trace(medium, start, (np.sqrt(1 - sine**2), sine, 0), length=100.0, rtol=1e-9, path=4000)
        assert rays.status[0] == status
        if status == ARRIVED:
            assert np.min(np.linalg.norm(rays.paths[0], axis=1)) == pytest.approx(b - m, abs=2e-3)


def test_gravity_line():
    """A line captures as a point does in the plane across it, and leaves the momentum along it alone."""
    line = dict(directions=[(0, 0, 2.0)])
    medium = cpm.media.Sources([(0, 0, 7.0)], 1.0, 2, **line)
    for b, status in [(1.9, CAPTURED), (2.1, ARRIVED)]:
        rays = trace(medium, (-500, b, 0), (1, 0, 0), length=1000.0, rtol=1e-9)
        assert rays.status[0] == status
        assert abs(rays.position[0, 2]) < 1e-12
    rays = trace(medium, (-5, 3, 0), (1, 0, 0.5), length=15.0, rtol=1e-10)
    n = 1 + 1 / 34.0
    assert rays.momentum[0, 2] == pytest.approx(n * 0.5 / np.sqrt(1.25), abs=1e-8)
    expected = oracle.trace(fields.Sources(((0, 0, 7.0),), (1.0,), (2,), ((0, 0, 2.0),)), (-5, 3, 0), (1, 0, 0.5), length=15.0)
    np.testing.assert_allclose(rays.position[0], expected.position, rtol=0, atol=1e-7)


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-8])
def test_small_source_far_away_is_seen(rtol):
    """A source of 1e-4 m, 100 m ahead: bent as DOP853 started near it says, not stepped over; straight at it, captured."""
    m, k = 1e-8, 2
    medium = cpm.media.Sources([(100.0, 0, 0)], m, k)
    assert trace(medium, (0, 0, 0), (1, 0, 0), length=200.0, rtol=rtol).status[0] == CAPTURED
    b = 4e-4  # 2 × critical
    field = fields.Sources(((100.0, 0, 0),), (m,), (k,), ((0, 0, 0),))
    expected = oracle.trace(field, (99.0, b, 0), (1, 0, 0), length=2.0).direction
    rays = trace(medium, (0, b, 0), (1, 0, 0), length=101.0, rtol=rtol)
    assert np.linalg.norm(rays.direction[0] - expected) < 30 * rtol + 1e-6
    assert np.linalg.norm(expected - (1, 0, 0)) > 0.1


def test_repelling_source_cuts_off():
    """n = 1 − 1/r falls to 0 at r = 1: head on the ray is cut off there, else it turns."""
    medium = cpm.media.Sources([(0, 0, 0)], -1.0, 1)
    rays = trace(medium, (-5, 0, 0), (1, 0, 0), length=10.0, rtol=1e-8)
    assert rays.status[0] == CUTOFF
    assert np.linalg.norm(rays.position[0]) == pytest.approx(1.0, abs=1e-4)
    rays = trace(medium, (-5, 0.5, 0), (1, 0, 0), length=10.0, rtol=1e-8)
    expected = oracle.trace(fields.Sources(((0, 0, 0),), (-1.0,), (1,), ((0, 0, 0),)), (-5, 0.5, 0), (1, 0, 0), length=10.0)
    np.testing.assert_allclose(rays.position[0], expected.position, rtol=0, atol=1e-5)


# --- fibre and fish-eye -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_fibre_cuts_off(method):
    """Straight across the fibre p → 0 at ρ = 1/α; a degree off it turns and comes back."""
    medium = cpm.media.Parabolic(1.5, 0.5)
    rays = trace(medium, (0.5, 0, 0), (1, 0, 0), length=5.0, method=method, rtol=1e-8)
    assert rays.status[0] == CUTOFF
    np.testing.assert_allclose(rays.position[0], (2, 0, 0), rtol=0, atol=2e-6)
    a = np.radians(1.0)
    rays = trace(medium, (0.5, 0, 0), (np.cos(a), 0, np.sin(a)), length=2.5, method=method, rtol=1e-9)
    expected = central.parabolic(1.5, 0.5, (0, 0, 1), (0, 0, 0), (0.5, 0, 0), (np.cos(a), 0, np.sin(a)), length=2.5)
    assert rays.status[0] == ARRIVED
    np.testing.assert_allclose(rays.position[0], expected.position, rtol=0, atol=1e-12 if method == "auto" else 1e-6)


def test_fibre_cuts_off_in_a_scene():
    """The same where pieces are hit by geometry: the walls beyond 1/α are not reached."""
    scene = cpm.Scene(cpm.media.Parabolic(1.5, 0.5))
    scene.add_sphere((0, 0, 0), 4.0, cpm.materials.Black())
    rays = cpm.trace(scene, [(0.5, 0, 0), (0.5, 0.1, 0)], [(1, 0, 0), (1, 0, 0.2)], wavelength=550.0)
    assert list(rays.status) == [CUTOFF, cpm.RayStatus.HIT]
    np.testing.assert_allclose(rays.position[0], (2, 0, 0), rtol=0, atol=2e-6)


def test_start_beyond_the_fibre():
    with pytest.raises(ValueError, match=r"\b1\b"):
        trace(cpm.media.Parabolic(1.5, 0.5), [(0.5, 0, 0), (2.1, 0, 0)], [(0, 0, 1)] * 2, length=1.0)


def test_million_periods():
    """10⁶ periods of a fibre in closed form: one step, home to 1e-8 rad of phase, which is what 1e-16 of the length is."""
    n, alpha, slope = 1.5, 800.0, 0.1
    period = 2 * np.pi * np.cos(slope) / alpha
    d = (np.sin(slope), 0, np.cos(slope))
    far = 1e6 * period
    rays = trace(cpm.media.Parabolic(n, alpha), (0, 0, 0), d, until=((0, 0, far), (0, 0, 1)))
    assert rays.status[0] == ARRIVED and rays.steps[0] == 1 and rays.evaluations[0] == 0
    assert abs(rays.position[0, 0]) * alpha < 1e-8
    np.testing.assert_allclose(rays.direction[0], d, rtol=0, atol=1e-8)
    again = trace(cpm.media.Parabolic(n, alpha), (0, 0, 0), d, length=rays.length[0])
    assert abs(again.position[0, 0]) * alpha < 1e-8
    assert again.position[0, 2] == pytest.approx(far, rel=1e-15)
    transverse = rays.momentum[0, 0] ** 2 + (n * alpha * rays.position[0, 0]) ** 2
    assert transverse == pytest.approx((n * d[0]) ** 2, rel=1e-12)


def test_plane_along_the_fibre():
    """A plane nearly along the axis, reached after a thousand periods: the first crossing, on the plane."""
    n, alpha = 1.5, 2.0
    tilt = 1e-4
    medium, normal = cpm.media.Parabolic(n, alpha), np.array([np.cos(tilt), 0, np.sin(tilt)])
    d, point = np.array([0.2, 0.1, 1.0]), np.array([0.3, 0, 0])
    rays = trace(medium, (0, 0, 0), d, until=(point, normal))
    curve = central.parabolic_curve(n, alpha, (0, 0, 1), (0, 0, 0), (0, 0, 0), d)
    xs = np.linspace(0, 1.2 * rays.length[0] / n, 400_000)
    gaps = (curve.at(xs)[0] - point) @ normal
    first = xs[np.nonzero(np.sign(gaps) != np.sign(gaps[0]))[0][0]]
    assert rays.status[0] == ARRIVED
    assert abs((rays.position[0] - point) @ normal) < 1e-12
    assert rays.position[0, 2] == pytest.approx(curve.at(np.array([first]))[0][0, 2], abs=1e-2)


OVERSHOOTS = pytest.mark.xfail(strict=True, reason="dopri5's last step passes the cut-off: it ends at 1101 a, not 1000 a")


@pytest.mark.parametrize("method", ["auto", pytest.param("dopri5", marks=OVERSHOOTS)])
def test_fisheye_to_infinity(method):
    """Straight out from the centre n falls as 1/r²: cut off at n = 1e-6 of the start, r = 1000 a. Integrated at rtol 1e-6
    |p| loses its last digit where n is 1e-3 of the start, and the ray ends there, cut off too.
    """
    rays = trace(cpm.media.Fisheye(2.0, 0.5), (0, 0, 0), (0, 1, 0), length=1e6, method=method)
    assert rays.status[0] == CUTOFF
    distance = 0.5 * np.sqrt(1e6 - 1)
    if method == "auto":
        assert rays.position[0, 1] == pytest.approx(distance, rel=1e-9)
    else:
        assert 0.5 * np.sqrt(1e3 - 1) < rays.position[0, 1] <= distance
    assert rays.optical_path[0] <= 2.0 * 0.5 * np.pi / 2 + 1e-9


# --- scales, places, anything -----------------------------------------------------------------------------------------

MAKE = {
    "parabolic": lambda s, c: cpm.media.Parabolic(1.5, 0.4 / s, (0.2, 1, 0.3), c),
    "luneburg": lambda s, c: cpm.media.Luneburg(1.1 * s, c),
    "fisheye": lambda s, c: cpm.media.Fisheye(1.7, 1.2 * s, c),
    "eaton": lambda s, c: cpm.media.Eaton(1.1 * s, c),
    "sources": lambda s, c: cpm.media.Sources([c + s * np.array([2.0, 0, 0]), c], [0.2 * s**2, -0.1 * s], [2, 1]),
}


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 1e5, 1e9])
@pytest.mark.parametrize("kind", MAKE)
@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_scales(kind, scale, method):
    """A world of 1e-9 m or 1e9 m is the world of 1 m, scaled."""
    rng = np.random.default_rng(8)
    origins, directions = rng.uniform(-0.8, 0.8, (20, 3)), rng.normal(size=(20, 3))
    options = dict(method=method, rtol=1e-9)
    one = trace(MAKE[kind](1.0, np.zeros(3)), origins, directions, length=2.0, **options)
    got = trace(MAKE[kind](scale, np.zeros(3)), origins * scale, directions, length=2.0 * scale, **options)
    np.testing.assert_array_equal(got.status, one.status)
    arrived = one.status == ARRIVED
    assert np.mean(arrived) > 0.8
    limit = 1e-12 if one.method[0] == "exact" else 1e-6
    assert np.max(np.linalg.norm(got.position / scale - one.position, axis=1)[arrived]) < limit


@pytest.mark.parametrize("kind", MAKE)
def test_far_from_the_origin(kind):
    """1e9 m from the origin: what rounding of coordinates (1e-7 m) leaves."""
    far = np.array([1e9, -1e9, 1e9])
    for d in [(1, 0.3, -0.2), (-0.4, 1, 0.6)]:
        near = trace(MAKE[kind](1.0, np.zeros(3)), (0.3, 0.4, -0.2), d, length=1.5, rtol=1e-9)
        moved = trace(MAKE[kind](1.0, far), far + (0.3, 0.4, -0.2), d, length=1.5, rtol=1e-9)
        if moved.status[0] == ARRIVED:
            np.testing.assert_allclose(moved.position[0] - far, near.position[0], rtol=0, atol=3e-5)
        else:
            assert moved.status[0] in (CAPTURED, cpm.RayStatus.STEP_UNDERFLOW)


@pytest.mark.parametrize("kind", ["luneburg", "eaton"])
@pytest.mark.parametrize("method", ["auto", "dopri5"])
def test_on_the_sphere(kind, method):
    """Starts on the lens's surface: inward, outward, along it."""
    medium = MAKE[kind](1.0, CENTER)
    out = np.array([2.0, -1.0, 2.0]) / 3
    start = CENTER + 1.1 * out
    rays = trace(medium, start, out, length=1.0, method=method)
    np.testing.assert_allclose(rays.position[0], start + out, rtol=0, atol=1e-9)
    for d in (np.array([-1.0, 0.2, 0.1]), np.array([-0.3, 0.9, 0.5])):
        expected = getattr(central, kind)(1.1, CENTER, start, d, length=1.5)
        rays = trace(medium, start, d, length=1.5, method=method, rtol=1e-9)
        np.testing.assert_allclose(rays.position[0], expected.position, rtol=0, atol=1e-12 if method == "auto" else 1e-7)
    along = np.cross(out, (0, 0, 1))
    rays = trace(medium, start, along, length=1.0, method=method)
    assert rays.status[0] == ARRIVED and np.all(np.isfinite(rays.position))


unit = st.floats(-1, 1, allow_nan=False)
#: Places that are special, and any.
place = st.one_of(st.tuples(unit, unit, unit), st.sampled_from([(0, 0, 0), (1.1, 0, 0), (0, 0, -1.1), (1e-17, 0, 0), (2, 0, 0)]))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(kind=st.sampled_from(sorted(MAKE)), place=place, direction=st.one_of(st.tuples(unit, unit, unit), st.sampled_from([(1, 0, 0), (0, 1, 0), (0, 0, 1)])),
       length=st.floats(0, 50), exponent=st.floats(-9, 9), method=st.sampled_from(["auto", "dopri5", "euler"]),
       rtol=st.sampled_from([1.0, 1e-2, 1e-6, 1e-12]), precision=st.sampled_from(["double", "single"]))  # fmt: skip
def test_anything(kind, place, direction, length, exponent, method, rtol, precision):
    """Any start, aim, scale and tolerance: a status, finite numbers, a bound on evaluations; |p| = n where it arrived."""
    if np.linalg.norm(direction) < 1e-6:
        return
    scale = 10.0**exponent
    medium = MAKE[kind](scale, np.zeros(3))
    try:
        rays = trace(medium, np.array(place) * scale, direction, length=length * scale, method=method, rtol=rtol,
                     precision=precision, max_evaluations=20_000, path=5)  # fmt: skip
    except ValueError as problem:
        assert "n^2 <= 0" in str(problem)
        return
    for name in ("position", "direction", "momentum", "length", "optical_path", "drift", "error_estimate", "paths"):
        assert np.all(np.isfinite(getattr(rays, name))), name
    assert rays.evaluations[0] <= 20_100
    if rays.method[0] == "exact" and rays.status[0] == ARRIVED:
        n, _ = medium.evaluate(rays.position)
        if np.linalg.norm(rays.position[0]) > 1e-6 * scale:
            assert np.linalg.norm(rays.momentum[0]) == pytest.approx(n[0], rel=1e-6)
        assert rays.length[0] == length * scale
