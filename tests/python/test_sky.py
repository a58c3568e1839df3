"""Suns and environments: what eye rays see beyond the extent, and the photons that come from there.

Oracles: solid angles and cosines, quadrature of the limb darkening, furnaces (an object in an even environment of
radiance 1 receives pi n^2 everywhere), conservation of n^2 dA dOmega, bilinear look-ups in NumPy.
"""

import numpy as np
import pytest
from scipy.integrate import quad

import cpm
from cpm._sky import compass, limb_darkening, solar_irradiance, towards

CENTER, RADIUS = np.array((0.1, 0.2, -0.3)), 0.7
SQUARE = [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[0, 2, 1], [0, 3, 2]]
HEIGHTS = np.linspace(-9, 9, 161)
MEDIA = {
    "vacuum": lambda: cpm.media.Homogeneous(1.0),
    "homogeneous": lambda: cpm.media.Homogeneous(1.5),
    "linear-squared": lambda: cpm.media.LinearSquared(1.69, gradient=(0.2, -0.4, 0.1)),
    "layered": lambda: cpm.media.Layered(HEIGHTS, 1.3 + 0.2 * np.tanh(HEIGHTS), up=(0, 1, 0)),
    "fisheye": lambda: cpm.media.Fisheye(1.6, 2.0),
}


def ball(medium, light, albedo=0.5):
    scene = cpm.Scene(medium=medium)
    scene.add_sphere(CENTER, RADIUS, material=cpm.materials.Diffuse(albedo))
    scene.add_light(light)
    return scene


def floor(light, medium=None, **options):
    scene = cpm.Scene(medium=medium, **options)
    scene.add_mesh(*SQUARE, material=cpm.materials.Diffuse(0.5))
    scene.add_light(light)
    return scene


# ------------------------------------------------------------------------------------------------ directions, data


def test_compass():
    """A camera that looks along −z faces north; its right hand is east; also where z is up, as on maps."""
    up, north, east = compass((0, 2, 0))
    np.testing.assert_allclose([up, north, east], [[0, 1, 0], [0, 0, -1], [1, 0, 0]], atol=1e-15)
    up, north, east = compass((0, 0, 1))
    np.testing.assert_allclose([up, north, east], [[0, 0, 1], [0, 1, 0], [1, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(towards(30, 90, (0, 1, 0)), (np.cos(np.pi / 6), 0.5, 0), atol=1e-15)


def test_limb_darkening():
    """1 in the middle; Neckel and Labs' tabled coefficients (1994) at 519.93 nm within the fit's error; no jumps."""
    wavelengths = np.linspace(280, 1200, 500)
    a = limb_darkening(wavelengths)
    np.testing.assert_allclose(a.sum(axis=1), 1, atol=1e-12)
    # Pierce and Slaughter (1977) give I(0.5)/I(1) = 0.7075 +- 0.01 at 520 nm, and darkening falls with wavelength.
    half = a @ 0.5 ** np.arange(6)
    assert np.interp(520, wavelengths, half) == pytest.approx(0.70, abs=0.02)
    assert np.all(np.diff(half[wavelengths > 430]) > -1e-6)
    assert np.max(np.abs(np.diff(half))) < 0.02


def test_solar_irradiance():
    """1366.1 W/m² in all, of which 79 % lie between 250 and 1300 nm in the standard's own cumulative column."""
    sun = solar_irradiance()
    assert 5 * sun.values.sum() == pytest.approx(0.814 * 1366.1, rel=0.005)
    assert 1.8 < sun.at(550.0) < 1.95
    assert cpm.lights.Sun(10, 0).radiance.at(550.0) == pytest.approx(sun.at(550.0) / 6.80e-5, rel=0.003)


# ----------------------------------------------------------------------------------------------------- eye rays


def sun_picture(**options):
    sun = cpm.lights.Sun(30.0, 10.0, radiance=2.0, **options)
    scene = cpm.Scene()
    scene.add_light(sun)
    scene.camera = cpm.Camera.look_at((0, 0, 0), towards(30, 10, (0, 1, 0)), (0, 1, 0), fov=0.8)
    image = cpm.render(scene, size=(200, 200), wavelengths=[400.0, 700.0], progress=False)
    return scene, image


def test_sun_disc():
    """Size, limb darkening by wavelength, and mean; not one photon is made for it."""
    _, image = sun_picture()
    assert image.stats["photons_emitted"] == 0 and image.stats["photon_segments"] == 0
    x = (np.arange(200) + 0.5) / 100 - 1
    tangent = np.tan(np.radians(0.4)) * np.hypot(*np.meshgrid(x, x))
    sine = np.sin(np.arctan(tangent)) / np.sin(np.radians(cpm.lights.SUN_RADIUS))
    a = limb_darkening([400.0, 700.0])
    mu = np.sqrt(np.maximum(1 - sine**2, 0))
    for b in range(2):
        mean = 2 * quad(lambda m, b=b: m * np.polyval(a[b][::-1], m), 0, 1)[0]
        expected = np.where(sine <= 1, 2.0 * np.polyval(a[b][::-1], mu) / mean, 0)
        sure = np.abs(sine - 1) > 1e-6
        np.testing.assert_allclose(image.data[..., b][sure], expected[sure], rtol=2e-5)
        assert image.data[..., b][sine <= 1].mean() == pytest.approx(2.0, rel=2e-3)


def test_even_disc():
    _, image = sun_picture(limb_darkening=False)
    assert set(np.unique(image.data)) == {0.0, 2.0}


@pytest.mark.parametrize("name", MEDIA)
def test_even_environment(name):
    """A camera in index n sees n² times the basic radiance, wherever it looks."""
    scene = cpm.Scene(medium=MEDIA[name]())
    scene.add_light(cpm.lights.Environment(3.0))
    scene.camera = cpm.Camera.look_at(CENTER, (1, 1, 1), (0, 1, 0), fov=90)
    image = cpm.render(scene, size=(9, 7), wavelengths=[550.0], progress=False)
    n = scene.medium.evaluate(CENTER, 550.0)[0][0]
    np.testing.assert_allclose(image.data, 3 * n**2, rtol=1e-6)


def test_final_direction():
    """In n² = n₀² + g·r a ray that leaves has turned: the sky's image tells how far. p = p₀ + σ g/2 in closed form."""
    g = np.array((0.0, -0.3, 0.0))
    medium = cpm.media.LinearSquared(1.69, gradient=g)
    values = np.random.default_rng(3).uniform(size=(60, 120, 1)).astype(np.float32)
    half = 1.5
    scene = cpm.Scene(medium=medium, extent=cpm.Box((-half,) * 3, (half,) * 3))
    scene.add_light(cpm.lights.Environment(([550.0], values)))
    scene.camera = cpm.Camera.look_at((0, 0, 0), (0.3, 0.1, -1), (0, 1, 0), fov=60)
    image = cpm.render(scene, size=(12, 8), wavelengths=[550.0], progress=False)
    forward = np.array((0.3, 0.1, -1)) / np.linalg.norm((0.3, 0.1, -1))
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    top = np.cross(right, forward)
    for row in range(8):
        for column in range(12):
            a, b = (column + 0.5) / 6 - 1, (1 - (row + 0.5) / 4) * 8 / 12
            d = forward + np.tan(np.radians(30)) * (a * right + b * top)
            p0 = 1.3 * d / np.linalg.norm(d)
            roots = [np.roots([g[k] / 4, p0[k], -side]) for k in range(3) for side in (half, -half)]
            sigma = min(s.real for r in roots for s in np.atleast_1d(r) if abs(s.imag) < 1e-12 and s.real > 1e-9)
            p = p0 + sigma * g / 2
            assert image.data[row, column, 0] == pytest.approx(1.69 * looked_up(values, p)[0], rel=2e-5)


def looked_up(values, d):
    """Bilinear, with up +y, north −z, east +x."""
    height, width = values.shape[:2]
    d = d / np.linalg.norm(d)
    r = np.arccos(d[1]) / np.pi * height - 0.5
    c = (np.arctan2(d[0], -d[2]) + np.pi) / (2 * np.pi) * width - 0.5
    r = np.clip(r, 0, height - 1)
    r0, c0 = int(np.floor(r)), int(np.floor(c))
    r1 = min(r0 + 1, height - 1)
    rows = [(r0, 1 - (r - r0)), (r1, r - r0)]
    columns = [(c0 % width, 1 - (c - c0)), ((c0 + 1) % width, c - c0)]
    return sum(wr * wc * values[i, j].astype(float) for i, wr in rows for j, wc in columns)


# ------------------------------------------------------------------------------------------------------ photons


@pytest.mark.parametrize("name", MEDIA)
def test_furnace(name):
    """E = π n² everywhere on a ball in an even environment of 1, and it cannot be told from what is behind it."""
    scene = ball(MEDIA[name](), cpm.lights.Environment(1.0))
    count = 20_000 if name in ("layered", "fisheye") else 60_000
    photons = cpm.trace_photons(scene, count, seed=1, wavelengths=[550.0])
    p = np.random.default_rng(1).normal(size=(300, 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    points = CENTER + RADIUS * p
    found = photons.diffuse.irradiance(points, p, nearest=100)[:, 0] / np.pi
    basic = found / scene.medium.evaluate(points, 550.0)[0] ** 2
    assert basic.mean() == pytest.approx(1.0, abs=0.02)
    assert np.max(np.abs(basic - 1)) < 6 / np.sqrt(98)
    for axis in range(3):
        assert basic[p[:, axis] > 0].mean() == pytest.approx(basic[p[:, axis] < 0].mean(), abs=0.04)


def test_furnace_where_light_disperses():
    """Each wavelength has its own n and its own paths: 16 photons of one path split."""
    scene = ball(cpm.media.Homogeneous(cpm.dispersion.Cauchy(1.5, 0.02)), cpm.lights.Environment(1.0))
    photons = cpm.trace_photons(scene, 40_000, seed=2, wavelengths=[450.0, 650.0])
    power = photons.diffuse.power.sum(axis=0) / (np.pi * 4 * np.pi * RADIUS**2)
    n = scene.medium.dispersion.n([450.0, 650.0])
    np.testing.assert_allclose(power, n**2, rtol=0.01)


@pytest.mark.parametrize("curved", [False, True])
def test_aiming_changes_no_mean(curved):
    """Paths started on the box about the shapes, about a part of space, and far out: the same power lands (z-test)."""
    medium = cpm.media.LinearSquared(1.69, gradient=(0.2, -0.4, 0.1)) if curved else cpm.media.Homogeneous(1.2)
    aim = cpm.Box((-1, -1, -1.5), (1.2, 1.1, 0.9))
    found = {}
    for kind, light, projection in (
        ("shapes", cpm.lights.Environment(1.0), True),
        ("aim", cpm.lights.Environment(1.0, aim=aim), True),
        ("far", cpm.lights.Environment(1.0), False),
    ):
        scene = ball(medium, light, albedo=0.0)
        sums = [
            cpm.trace_photons(scene, 6_000, seed=s, wavelengths=[550.0], projection=projection).diffuse.power.sum()
            for s in range(12)
        ]
        found[kind] = np.mean(sums), np.std(sums, ddof=1) / np.sqrt(len(sums))
    for kind in ("aim", "far"):
        difference = found[kind][0] - found["shapes"][0]
        assert abs(difference) < 4 * np.hypot(found[kind][1], found["shapes"][1]), found


@pytest.mark.parametrize("elevation", [90.0, 30.0, 5.0])
def test_sun_on_the_floor(elevation):
    """E = L Ω sin e for a mean radiance L, whatever the limb darkening (Ω is small: cosines vary by 1e-5)."""
    sun = cpm.lights.Sun(elevation, 40.0, radiance=1000.0)
    photons = cpm.trace_photons(floor(sun), 20_000, seed=1, wavelengths=[450.0, 650.0])
    expected = 1000.0 * sun.solid_angle * np.sin(np.radians(elevation))
    np.testing.assert_allclose(photons.diffuse.power.sum(axis=0) / 4, expected, rtol=2e-3)


def test_large_sun():
    """A sun of 20° radius at 60°: E by quadrature of limb darkening times cosine over its disc."""
    sun = cpm.lights.Sun(60.0, 0.0, radiance=1.0, angular_radius=20.0)
    photons = cpm.trace_photons(floor(sun), 60_000, seed=3, wavelengths=[550.0])
    a = limb_darkening(550.0)[::-1]
    s = np.sin(np.radians(20.0))
    mean = quad(lambda t: np.polyval(a, np.sqrt(1 - (np.sin(t) / s) ** 2)) * np.sin(t), 0, np.radians(20))[0]
    tilted = quad(  # about the axis the cosine averages to cos t sin 60°
        lambda t: np.polyval(a, np.sqrt(1 - (np.sin(t) / s) ** 2)) * np.sin(t) * np.cos(t), 0, np.radians(20)
    )[0]
    expected = 2 * np.pi * (1 - np.cos(np.radians(20))) * tilted / mean * np.sin(np.radians(60))
    assert photons.diffuse.power.sum() / 4 == pytest.approx(expected, rel=5e-3)


def test_sun_through_layers():
    """n² dA dΩ cos is kept in flat layers: E = n_e² L Ω for a sun in the zenith, n_e at the extent's top."""
    medium = cpm.media.LinearSquared(1.69, gradient=(0.0, -0.05, 0.0))
    sun = cpm.lights.Sun(90.0, 0.0, radiance=1000.0)
    scene = floor(sun, medium, extent=cpm.Box((-2, -1, -2), (2, 3, 2)))
    photons = cpm.trace_photons(scene, 40_000, seed=1, wavelengths=[550.0])
    found = photons.diffuse.power.sum() / 4 / (1000 * sun.solid_angle)
    assert found == pytest.approx(1.69 - 0.15, rel=0.02)


def test_image_lights_a_floor():
    """Irradiance under an image of one bright patch against a sum over its pixels; and the energy balance."""
    values = np.full((32, 64, 2), 0.1, dtype=np.float32)
    values[6:10, 20:30] = (40.0, 10.0)
    scene = floor(cpm.lights.Environment(([450.0, 650.0], values)))
    photons = cpm.trace_photons(scene, 60_000, seed=5, wavelengths=[450.0, 650.0])
    middles = np.arange(960) + 0.5
    theta, phi = np.meshgrid(middles * np.pi / 960, middles * np.pi / 480 - np.pi, indexing="ij")
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], axis=-1)
    fine = np.array([looked_up(values, v) for v in d[:480:8, ::8].reshape(-1, 3)])
    weight = (np.sin(theta) * np.maximum(np.cos(theta), 0))[:480:8, ::8].reshape(-1, 1)
    expected = np.sum(fine * weight, axis=0) * (np.pi / 960 * 8) * (np.pi / 480 * 8)
    down = photons.diffuse.direction[:, 1] < 0
    found = photons.diffuse.power[down & (photons.diffuse.bounce == 0)].sum(axis=0) / 4
    np.testing.assert_allclose(found, expected, rtol=0.03)


def test_nothing_to_light():
    """No shapes, or none within the aim: no photon is made."""
    scene = cpm.Scene()
    scene.add_light(cpm.lights.Environment(1.0))
    assert len(cpm.trace_photons(scene, 10_000, wavelengths=[550.0]).diffuse.power) == 0


def test_a_roof_hides_the_sun():
    """With an aim below a roof the sun is hidden, with the whole scene it is not less so."""
    for aim in (None, cpm.Box((-1.1, -0.1, -1.1), (1.1, 0.1, 1.1))):
        scene = floor(cpm.lights.Sun(90.0, 0.0, radiance=1000.0, aim=aim))
        scene.add_mesh(np.array(SQUARE[0]) * 3.0 + (0, 1, 0), SQUARE[1], material=cpm.materials.Black())
        photons = cpm.trace_photons(scene, 4000, seed=1, wavelengths=[550.0])
        assert not np.any(photons.diffuse.position[:, 1] < 0.5)


# ---------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: cpm.lights.Sun(91.0, 0.0), "elevation is 91"),
        (lambda: cpm.lights.Sun(0.0, float("nan")), "azimuth is nan"),
        (lambda: cpm.lights.Sun(0.0, 0.0, angular_radius=0.0), "angular_radius is 0"),
        (lambda: cpm.lights.Sun(0.0, 0.0, radiance=-1.0), "radiance is -1"),
        (lambda: cpm.lights.Sun(0.0, 0.0, up=(0, 0, 0)), "up is"),
        (lambda: cpm.lights.Environment(([550.0], np.full((2, 2, 1), -1.0))), "row 0, column 0"),
        (lambda: cpm.lights.Environment(([550.0, 650.0], np.ones((2, 2, 1)))), "shape"),
        (lambda: cpm.lights.Environment({"file": "sky.npy"}), "no such file"),
    ],
)
def test_refused(make, message):
    with pytest.raises((ValueError, FileNotFoundError), match=message):
        make()


def test_wrong_types():
    with pytest.raises(TypeError, match="aim"):
        cpm.lights.Environment(1.0, aim=((0, 0, 0), (1, 1, 1)))
    with pytest.raises(TypeError, match="limb_darkening"):
        cpm.lights.Sun(0.0, 0.0, limb_darkening="no")


# -------------------------------------------------------------------------------------------------- scene files

SCENE = """
[[lights]]
type = "sun"
elevation = 20.0
azimuth = 90.0
[[lights]]
type = "environment"
radiance = {radiance}
[camera]
origin = [0, 0, 0]
target = [0, 0, -1]
fov = 60.0
[render]
size = [8, 6]
wavelengths = [450.0, 650.0]
"""


def load(folder, radiance):
    path = folder / "scene.toml"
    path.write_text(SCENE.replace("{radiance}", radiance))
    return cpm.load_scene(path)


def test_scene_file(tmp_path):
    scene = load(tmp_path, '{ wavelengths = [400, 700], values = [1, 2] }')
    sun, sky = scene.lights
    assert (sun.elevation, sun.azimuth) == (20.0, 90.0) and sky.radiance.at(550.0) == 1.5
    np.testing.assert_allclose(cpm.render(scene, progress=False).data[0, 0], (7 / 6, 11 / 6), rtol=1e-6)


def test_scene_files_with_images(tmp_path):
    """A spectral EXR that this library wrote, and a .npy with its wavelengths, give the same picture."""
    values = np.random.default_rng(1).uniform(size=(16, 32, 2)).astype(np.float32)
    np.save(tmp_path / "sky.npy", values)
    scene = load(tmp_path, '{ file = "sky.npy", wavelengths = [450, 650], scale = 2.0 }')
    picture = cpm.render(scene, progress=False)
    cpm.Image(values, [450.0, 650.0]).save(tmp_path / "sky.exr")
    again = cpm.render(load(tmp_path, '{ file = "sky.exr", scale = 2.0 }'), progress=False)
    np.testing.assert_array_equal(picture.data, again.data)
    assert picture.data.std() > 0.1


@pytest.mark.parametrize(
    ("radiance", "message"),
    [
        ('{ file = "none.exr" }', "no such file"),
        ('{ file = "rgb.exr" }', "RGB has no spectrum"),
        ('{ file = "sky.npy" }', "needs wavelengths"),
        ('{ file = "sky.npy", wavelengths = [450, 550, 650] }', "shape"),
        ('{ file = "sky.npy", wavelengths = [450, 650], colour = 1 }', "unknown key"),
    ],
)
def test_bad_scene_files(tmp_path, radiance, message):
    np.save(tmp_path / "sky.npy", np.ones((4, 8, 2), dtype=np.float32))
    import OpenImageIO

    pixels = OpenImageIO.ImageBuf(np.ones((4, 8, 3), dtype=np.float32))
    assert pixels.write(str(tmp_path / "rgb.exr"))
    with pytest.raises(ValueError, match=message) as caught:
        load(tmp_path, radiance)
    assert "lights[1].radiance" in str(caught.value) and "\n" not in str(caught.value)
