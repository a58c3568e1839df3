"""cpm.media.Atmosphere: the spline is the profile, and rays through it are those of the refraction integral."""

import numpy as np
import pytest

import cpm
from cpm.atmosphere import HotSurface, Inversion, Polytropic, Table, USStandard1976, read_sounding, refraction
from cpm.media import Atmosphere

R = 6371e3
D_LINE = 587.5618
LEVELS = Table(
    [0.0, 300.0, 350.0, 1500.0, 11000.0, 20000.0],
    [281.0, 279.5, 286.0, 280.0, 217.0, 217.0],
    1.01e5,
    [0.9, 0.8, 0.4, 0.5, 0.1, 0.0],
)
PROFILES = {
    "standard": USStandard1976(),
    "polytropic": Polytropic(288.15, 101325.0, humidity=0.6),
    "road": HotSurface(USStandard1976(), 30.0, 0.05),
    "thin": HotSurface(USStandard1976(), 40.0, 0.01),
    "cold": Inversion(HotSurface(USStandard1976(), -5.0, 2.0), 40.0, 5.0, 8.0),
    "levels": LEVELS,
}


def heights_of(profile, count=4000):
    """Everywhere, and many where it varies: near the ground and at the kinks."""
    random = np.random.default_rng(1)
    near = [
        at + random.normal(0, width, count // 8)
        for at in [profile.ground, *profile._kinks()[:4]]
        for width in (0.02, 2.0)
    ]
    h = np.concatenate([random.uniform(profile.ground, profile.top, count), *near])
    return np.sort(h[(h > profile.ground) & (h < profile.top - 1e-3)])


@pytest.mark.parametrize("name", PROFILES)
def test_spline_is_the_profile(name):
    """Flat, so that the height is exact: 1e-12, or 1e-8 of n − 1 (1e-7 is to be reached), and rounding of n."""
    profile = PROFILES[name]
    medium, h = Atmosphere(profile, radius=None), heights_of(PROFILES[name])
    n, gradient = medium.evaluate(np.column_stack([0 * h, h, 0 * h]), D_LINE)
    wanted = profile.refractivity(h, D_LINE)
    assert (np.abs(n - 1 - wanted) < np.maximum(1.3e-12, 1.3e-8 * wanted) + 3e-16).all()
    assert (gradient[:, [0, 2]] == 0).all()
    assert medium.heights.size < 3000


def test_kinks_are_kept():
    """Just beside the tropopause and a level of a table the slopes are those of either side."""
    for profile, kink in ((Polytropic(288.15, 101325.0), 11000.0), (LEVELS, 300.0), (LEVELS, 350.0)):
        medium, step = Atmosphere(profile, radius=None), 0.05
        for side in (-0.1, 0.1):
            _, gradient = medium.evaluate([0, kink + side, 0], D_LINE)
            high, low = (profile.refractivity(kink + side + s, D_LINE) for s in (step, -step))
            assert gradient[0, 1] == pytest.approx((high - low) / (2 * step), rel=3e-3)


@pytest.mark.parametrize("up", [(0, 1, 0), (1, 2, -2)])
def test_around_the_earth(up):
    """Height is the distance to the centre, `radius` under the origin, less the radius; 300 km away too."""
    profile, axis = PROFILES["polytropic"], np.array(up) / np.linalg.norm(up)
    origin = np.array([10.0, -20.0, 5.0])
    medium, side = Atmosphere(profile, up=up, origin=origin), np.cross(axis, [0.3, 0.1, 0.9])
    side /= np.linalg.norm(side)
    h, angle = np.array([0.5, 1000.0, 30e3, 79e3]), np.array([0.0, 1e-3, 0.047, -0.02])
    points = origin - R * axis + (R + h)[:, None] * (np.cos(angle)[:, None] * axis + np.sin(angle)[:, None] * side)
    n, gradient = medium.evaluate(points, D_LINE)
    np.testing.assert_allclose(n - 1, profile.refractivity(h, D_LINE), rtol=1e-8, atol=2e-12)
    outward = (points - (origin - R * axis)) / (R + h)[:, None]
    steep = np.linalg.norm(gradient, axis=1)
    np.testing.assert_allclose(gradient / -steep[:, None], outward, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", cpm.air.MODELS)
def test_wavelengths(model):
    """n − 1 is density times dispersion, of dry air and of vapour each its own, at every wavelength."""
    h = np.array([0.0, 2000.0, 12000.0])
    points = np.column_stack([0 * h, h, 0 * h])
    for profile, tolerance in ((USStandard1976(), 2e-8), (LEVELS, 2e-8), (PROFILES["polytropic"], 2e-8),
                               (Polytropic(288.15, 101325.0, humidity=0.02), 5e-6)):
        medium = Atmosphere(profile, radius=None, refractivity=model)
        for wavelength in (400.0, 450.0, 700.0):
            n, _ = medium.evaluate(points, wavelength)
            np.testing.assert_allclose(n - 1, profile.refractivity(h, wavelength, model), rtol=tolerance, atol=2e-12)


def turned(rays, directions):
    """Angle between the first and the last direction, positive towards the ground."""
    d = np.asarray(directions) / np.linalg.norm(directions, axis=1)[:, None]
    e = rays.direction
    return np.arctan2(d[:, 1] * e[:, 0] - d[:, 0] * e[:, 1], np.sum(d * e, axis=1))


@pytest.mark.parametrize("name", ["standard", "polytropic", "levels"])
@pytest.mark.parametrize("height", [2.0, 2000.0])
def test_rays_are_refracted_as_the_integral_says(name, height):
    """From the observer out of the air, at and below the horizon: to 2e-9 rad (0.0004″), each wavelength its own; under
    an inversion of 50 m, where what the spline may be off by counts for more, to 8e-9."""
    profile = PROFILES[name]
    medium = Atmosphere(profile, radius=profile.radius)
    zenith = np.array([60.0, 85.0, 89.0, 90.0] + ([90.5, 91.0] if height > 100 else []))
    zenith, wavelength = (a.ravel() for a in np.meshgrid(zenith, [450.0, 587.5618, 680.0]))
    directions = np.column_stack([np.sin(np.radians(zenith)), np.cos(np.radians(zenith)), 0 * zenith])
    rays = cpm.trace(
        medium,
        np.tile((0.0, height, 0.0), (zenith.size, 1)),
        directions,
        wavelength=wavelength,
        length=1.6e6,
        rtol=1e-11,
    )
    assert (rays.status == cpm.RayStatus.ARRIVED).all()
    expected = np.radians(refraction(profile, zenith, wavelength, height))
    np.testing.assert_allclose(turned(rays, directions), expected, rtol=2e-8, atol=8e-9 if name == "levels" else 2e-9)


def test_the_setting_sun_is_flattened():
    """Refraction 34′ at the horizon and 29′ half a degree above it: five sixths as high as wide. The almanacs' figures,
    which hold at 10 °C and 1010 hPa (Bennett 1982: 34.5′ and 28.7′)."""
    medium = Atmosphere(Polytropic(283.15, 101000.0))
    altitude = np.radians([0.0, 0.5])
    directions = np.column_stack([np.cos(altitude), np.sin(altitude), 0 * altitude])
    rays = cpm.trace(medium, np.tile((0.0, 2.0, 0.0), (2, 1)), directions, wavelength=590.0, length=1.6e6)
    minutes = np.degrees(turned(rays, directions)) * 60
    assert minutes[0] == pytest.approx(34, abs=0.7) and minutes[1] == pytest.approx(29, abs=1.0)
    assert 0.80 < (30 - (minutes[0] - minutes[1])) / 30 < 0.87


def test_mirage_turning_points():
    """Over a flat hot road a ray at angle α below the horizontal turns where n(h) = n(eye) cos α: to 1e-6 rad."""
    profile, eye = HotSurface(USStandard1976(), 30.0, 0.05), 1.5
    medium = Atmosphere(profile, radius=None)
    for height in (0.02, 0.05, 0.1):
        ratio = (1 + profile.refractivity(height, D_LINE)) / (1 + profile.refractivity(eye, D_LINE))
        alpha = np.arccos(ratio)
        for delta, turns in ((-1e-6, True), (1e-6, True)):
            direction = [[np.cos(alpha + delta), -np.sin(alpha + delta), 0.0]]
            rays = cpm.trace(medium, [[0, eye, 0]], direction, wavelength=D_LINE, length=3000.0, rtol=1e-10, path=20001)
            lowest = rays.paths[0, :, 1].min()
            slope = (profile.refractivity(height + 1e-4, D_LINE) - profile.refractivity(height - 1e-4, D_LINE)) / 2e-4
            shift = -np.sin(alpha) * delta / slope
            assert (lowest < eye) == turns and lowest == pytest.approx(height + shift, abs=0.3 * abs(shift) + 3e-5)


def test_scene_ends_at_the_top():
    scene = cpm.Scene(Atmosphere(USStandard1976(), up=(0, 2, 0)))
    np.testing.assert_allclose(scene.extent.low, [-R - 86e3, -2 * R - 86e3, -R - 86e3])
    np.testing.assert_allclose(scene.extent.high, [R + 86e3, 86e3, R + 86e3])
    rays = cpm.trace(scene, [[0, 2, 0]], [[0, 1, 0]], wavelength=550.0)
    assert rays.status[0] == cpm.RayStatus.LEFT and rays.position[0, 1] == pytest.approx(86e3, abs=1.0)
    small = cpm.Scene(Atmosphere(USStandard1976()), extent=cpm.Box((-1, -1, -1), (1, 9, 1)))
    assert small.extent.high == (1, 9, 1)


def test_sum_with_a_hot_road():
    """An atmosphere plus a warm layer: refractivities add, and the scene ends where the atmosphere does."""
    air, road = Atmosphere(USStandard1976()), cpm.media.Layered([0.0, 0.1, 1.0], [0.99998, 0.999995, 1.0])
    both, points = air + road, [[0.0, 0.05, 0.0], [3.0, 0.5, 0.0], [0.0, 200.0, 0.0]]
    n, _ = both.evaluate(points)
    np.testing.assert_allclose(n - 1, (air.evaluate(points)[0] - 1) + (road.evaluate(points)[0] - 1), rtol=0, atol=5e-16)
    assert both.extent.high == air.extent.high and cpm.Scene(both).extent.low == air.extent.low


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (("standard",), TypeError, "a profile of cpm.atmosphere"),
        ((USStandard1976(), 0.0), ValueError, "radius is 0 m"),
        ((USStandard1976(), R, (0, 0, 0)), ValueError, "up is"),
        ((USStandard1976(), R, (0, 1, 0), "n"), ValueError, "ciddor"),
    ],
)
def test_bad_input(arguments, error, message):
    with pytest.raises(error, match=message):
        Atmosphere(*arguments)


def test_out_of_range_wavelengths():
    with pytest.raises(ValueError, match="valid in"):
        Atmosphere(USStandard1976()).evaluate([0, 0, 0], 100.0)


def test_bounded():
    """A box of air in vacuum: n − 1 inside, 0 outside."""
    scene = cpm.Scene()
    scene.add_medium(Atmosphere(USStandard1976(), bounds=cpm.Box((-1, 0, -1), (1, 2, 1))))
    rays = cpm.trace(scene, [[-3, 1, 0]], [[1, 0, 0]], wavelength=550.0, length=6.0)
    n = 1 + USStandard1976().refractivity(1.0, 550.0)
    assert rays.optical_path[0] - 6.0 == pytest.approx(2 * (n - 1), rel=1e-6)


# Scene files.

SCENE = """
[medium]
type = "atmosphere"
profile = {profile}
{more}
[[shapes]]
type = "quads"
quads = [[[-1,0,-1], [0,0,2], [2,0,0]]]
material = {{ type = "black" }}
"""
FILES = {
    '{ type = "us-standard-1976" }': USStandard1976(),
    '{ type = "polytropic", T0 = 288.15, p0 = 101325.0, humidity = 0.5, lapse = 0.006 }': Polytropic(
        288.15, 101325.0, lapse=0.006, humidity=0.5
    ),
    '{ type = "table", h = [0, 1000, 20000], T = [288, 282, 217], p = 1.01e5, rh = 0.4, interpolation = "monotone" }': Table(
        [0, 1000, 20000], [288, 282, 217], 101000.0, 0.4, "monotone"
    ),
    '{ type = "hot-surface", base = { type = "us-standard-1976" }, excess = 30.0, thickness = 0.05 }': HotSurface(
        USStandard1976(), 30.0, 0.05
    ),
    '{ type = "inversion", base = { type = "hot-surface", base = { type = "us-standard-1976" }, excess = -3, thickness = 1 },'
    " height = 50.0, strength = 6.0, thickness = 10.0 }": Inversion(
        HotSurface(USStandard1976(), -3.0, 1.0), 50.0, 6.0, 10.0
    ),
}


def load(folder, profile, more=""):
    (folder / "scene.toml").write_text(SCENE.format(profile=profile, more=more))
    return cpm.load_scene(folder / "scene.toml")


@pytest.mark.parametrize("text", FILES)
def test_scene_file(tmp_path, text):
    medium = load(tmp_path, text).medium
    assert isinstance(medium, Atmosphere) and medium.radius == R
    h = np.array([0.03, 1.0, 48.0, 900.0, 15e3])
    np.testing.assert_array_equal(medium.profile.refractivity(h, 550.0), FILES[text].refractivity(h, 550.0))


def test_scene_file_of_a_sounding(tmp_path):
    text = "PRES HGHT TEMP RELH\n1000 100 15 50\n900 1000 8 40\n500 5500 -20 10\n"
    (tmp_path / "sonde.txt").write_text(text)
    medium = load(
        tmp_path, '{ type = "table", file = "sonde.txt" }', 'radius = inf\nrefractivity = "edlen"\nup = [0, 0, 1]'
    ).medium
    assert medium.radius is None and medium.up == (0, 0, 1) and medium.refractivity == "edlen"
    assert medium.profile.pressure(900.0) == read_sounding(tmp_path / "sonde.txt").pressure(900.0)


@pytest.mark.parametrize(
    ("profile", "more", "message"),
    [
        (
            '{ type = "standard" }',
            "",
            r"medium.profile.type: 'standard': unknown type \(allowed: us-standard-1976, polytropic",
        ),
        ('{ type = "polytropic", T0 = 15, p0 = 101325 }', "", "medium.profile: T0 is 15 K"),
        ('{ type = "polytropic", p0 = 101325 }', "", "medium.profile.T0: is missing"),
        ('{ type = "us-standard-1976", T0 = 3 }', "", "medium.profile.T0: unknown key"),
        ('{ type = "table", h = [0, 1] }', "", "h and T belong together"),
        ('{ type = "table", file = "no.txt" }', "", "no such file"),
        ('{ type = "table" }', "", "exactly one of file, h"),
        (
            '{ type = "hot-surface", base = { type = "us-standard-1976" }, excess = 30.0, thickness = 0.0 }',
            "",
            "profile.thickness",
        ),
        (
            '{ type = "hot-surface", base = { type = "table", h = [0, 1], T = [15, 15] }, excess = 3, thickness = 1 }',
            "",
            r"medium.profile.base: T\[0\] is 15 K",
        ),
        ('{ type = "us-standard-1976" }', "radius = -1.0", "medium.radius"),
        ('{ type = "us-standard-1976" }', "radius = nan", "medium.radius"),
        ('{ type = "us-standard-1976" }', 'dispersion = "air"', "medium.dispersion: unknown key"),
        ('{ type = "us-standard-1976" }', 'refractivity = "cidor"', "medium.refractivity"),
    ],
)
def test_bad_scene_files(tmp_path, profile, more, message):
    with pytest.raises(cpm.SceneFileError, match=message) as error:
        load(tmp_path, profile, more)
    assert "\n" not in str(error.value)


GROUND = """
[[shapes]]
type = "ground"
name = "earth"
material = { type = "diffuse", reflectance = 0.2 }
"""


def test_ground(tmp_path):
    """The sphere under the air: rays a little below the horizon meet it where curvature and refraction say."""
    scene = load(tmp_path, '{ type = "us-standard-1976" }', "up = [0, 1, 0]" + GROUND)
    assert next(shape.name for shape in scene.shapes) == "earth"
    angle = np.radians([-90.0, -1.0, -0.1, -0.06])
    rays = cpm.trace(
        scene,
        np.tile((0.0, 2.0, 0.0), (4, 1)),
        np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]),
        wavelength=550.0,
    )
    assert (rays.status == cpm.RayStatus.HIT).all()
    x, y = rays.position[:, 0], rays.position[:, 1]
    np.testing.assert_allclose((2 * R * y + y * y + x * x) / (R + np.hypot(x, R + y)), 0, rtol=0, atol=1e-8)
    # A ray of curvature −n'/n over the sphere falls as over a flat Earth of curvature 1/R + n'/n.
    slope = (USStandard1976().refractivity(3.0, 550.0) - USStandard1976().refractivity(0.0, 550.0)) / 3.0
    drop, curve = np.tan(-angle[1:]), 1 / R + slope
    np.testing.assert_allclose(x[1:], (drop - np.sqrt(drop**2 - 4 * curve)) / curve, rtol=1e-4)


@pytest.mark.parametrize(
    "medium",
    [
        "",
        '[medium]\ntype = "homogeneous"\n',
        '[medium]\ntype = "atmosphere"\nradius = inf\nprofile = { type = "us-standard-1976" }\n',
    ],
)
def test_ground_needs_an_earth(tmp_path, medium):
    (tmp_path / "scene.toml").write_text(medium + GROUND)
    with pytest.raises(cpm.SceneFileError, match=r"shapes\[0\].type: .*needs \[medium\] to be an atmosphere"):
        cpm.load_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize("humidity", [0.0, 0.02, 0.9])
def test_moist_air_disperses_by_height(humidity):
    """At the horizon, 400 to 700 nm, against the integral: to 0.01″ however moist. With the dispersion of the air at the
    ground for all of it, 90 % humidity gave 0.27″ at 400 nm."""
    profile = Polytropic(288.15, 101325.0, humidity=humidity)
    wavelength = np.array([400.0, 500.0, 700.0])
    forward = np.tile((1.0, 0.0, 0.0), (3, 1))
    medium = Atmosphere(profile, radius=profile.radius)
    rays = cpm.trace(medium, np.tile((0, 2.0, 0), (3, 1)), forward, wavelength=wavelength, length=1.6e6, rtol=1e-11)
    off = 3600 * (np.degrees(turned(rays, forward)) - refraction(profile, 90.0, wavelength, 2.0))
    assert np.max(np.abs(off)) < (0.01 if humidity == 0.02 else 0.001)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_single_keeps_up_with_double(rtol):
    """The 500 km horizon ray of the standard atmosphere in float lanes: within 0.1 m of double ones at 1e-12."""
    medium = cpm.media.Atmosphere(cpm.atmosphere.USStandard1976())
    slopes = np.array([0.0, 1e-4, 1e-3, 5e-3])
    aims = np.column_stack([np.ones(4), slopes, np.zeros(4)])
    sure, single = (cpm.trace(medium, (0, 2.0, 0), aims, wavelength=550.0, length=500e3, rtol=tight, precision=precision)
                    for tight, precision in ((1e-12, "double"), (rtol, "single")))
    assert np.linalg.norm(sure.position - single.position, axis=1).max() < 0.1
