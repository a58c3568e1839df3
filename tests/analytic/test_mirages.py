"""Mirages: rays of the shipped scenes, and their pictures measured, against air and rays by other means.

Every angle is above the horizontal at the camera. A picture is measured at the rows of one of its columns: what each
row shows follows from the height that its ray reaches (`oracles.mirage.curve`).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from oracles import camera as pinhole
from oracles import mirage as oracle

import cpm

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
EARTH, ROAD_EYE = 6371e3, 1.2


@pytest.fixture(scope="module")
def road_air():
    return oracle.Air(oracle.hot_surface(30.0, 0.05), top=60.0)


LIDS = {
    "superior_mirage": [oracle.inversion(25.0, 8.0, 12.0)],
    "fata_morgana": [oracle.inversion(15.0, 3.0, 4.0), oracle.inversion(30.0, 6.0, 5.0)],
}


def sea_air(name, wavelength=550.0):
    return oracle.Air(*LIDS[name], wavelength=wavelength, finest=0.25, top=400.0)


@pytest.mark.parametrize("name", ["inferior_mirage", *LIDS])
def test_air_of_the_scenes(name, road_air):
    """The scene's medium is the air that the oracle makes of the laws alone: n − 1 to 1e-8, as `Atmosphere` promises."""
    air = road_air if name == "inferior_mirage" else sea_air(name)
    medium = cpm.load_scene(EXAMPLES / f"{name}.toml").medium
    h = np.array([0.0, 0.003, 0.02, 0.1, 0.7, 3.0, 14.0, 24.0, 31.0, 50.0])
    n, _ = medium.evaluate(np.column_stack([0 * h, h, 0 * h]), 550.0)
    np.testing.assert_allclose(n - 1, [air(x)[0] for x in h], rtol=1.3e-8, atol=0)


def forward(angles):
    """Directions (N, 3) towards −z."""
    angles = np.atleast_1d(angles)
    return np.column_stack([0 * angles, np.sin(angles), -np.cos(angles)])


def heights_reached(medium, eye, angles, distance, **options):
    """y (N,) at z = −distance by the library."""
    origins, plane = np.tile((0.0, eye, 0.0), (np.size(angles), 1)), ((0, 0, -distance), (0, 0, 1))
    rays = cpm.trace(medium, origins, forward(angles), wavelength=550.0, until=plane, **options)
    assert (rays.status == cpm.RayStatus.ARRIVED).all()
    return rays.position[:, 1]


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_images_over_the_road(road_air, rtol):
    """Where things at 300, 430 and 800 m appear, upright and inverted: to 1e-6 rad (to be reached)."""
    medium = cpm.load_scene(EXAMPLES / "inferior_mirage.toml").medium
    vanishing = oracle.vanishing(road_air, ROAD_EYE)
    for distance, seen in ((300.0, 0.65), (430.0, 0.85), (800.0, 2.0)):
        sight = (seen - ROAD_EYE) / distance
        for between in ((vanishing * (1 - 1e-9), 0.5 * (vanishing + sight)), (0.5 * (vanishing + sight), 0.02)):
            angle = oracle.image(road_air, ROAD_EYE, between, distance, seen)
            step = 1e-6
            low, high = heights_reached(medium, ROAD_EYE, [angle - step, angle + step], distance, rtol=rtol)
            assert min(low, high) < seen < max(low, high)


def test_turning_points_over_the_road(road_air):
    """Lowest heights, to the height that 1e-6 rad of the ray's start make; the same through layers of linear n²."""
    scene = cpm.load_scene(EXAMPLES / "inferior_mirage.toml")
    atmosphere = scene.medium
    fine = np.concatenate([np.linspace(0, 0.6, 1201), np.linspace(0.61, 2.0, 100)])
    n, _ = atmosphere.evaluate(np.column_stack([0 * fine, fine, 0 * fine]), 550.0)
    layers = cpm.media.Layered(fine, n, interpolation="linear-squared")
    for share in (0.999, 0.9, 0.7, 0.5):
        angle = share * oracle.vanishing(road_air, ROAD_EYE)
        lowest = oracle.turning(road_air, ROAD_EYE, angle)
        allowed = abs(oracle.turning(road_air, ROAD_EYE, angle + 1e-6) - lowest)
        for medium in (atmosphere, layers):
            # the ray is level there: asked for a little more than the way, its path's least height is the turning point
            rays = cpm.trace(medium, [[0, ROAD_EYE, 0]], forward(angle), wavelength=550.0, length=400.0, rtol=1e-10,
                             path=20001)
            assert rays.paths[0, :, 1].min() == pytest.approx(lowest, abs=allowed)


def test_vanishing_line_by_rays(road_air):
    """Half a microradian under the line a ray meets the asphalt, half a microradian above it does not."""
    scene = cpm.load_scene(EXAMPLES / "inferior_mirage.toml")
    angle = oracle.vanishing(road_air, ROAD_EYE) + np.array([-5e-7, 5e-7])
    # beside the middle, where there is nothing but the road and what is behind it
    directions = forward(angle) + np.array([0.0012, 0, 0])
    rays = cpm.trace(scene, np.tile((0, ROAD_EYE, 0), (2, 1)), directions, wavelength=550.0)
    assert rays.status[0] == cpm.RayStatus.HIT and abs(rays.position[0, 1]) < 1e-9 and -rays.position[0, 2] < 400
    assert -rays.position[1, 2] > 2000


@pytest.mark.parametrize("name", LIDS)
def test_images_over_the_sea(name):
    """Where heights at 20 km appear, each of the three or five images: to 1e-6 rad; there are no others."""
    air, scene = sea_air(name), cpm.load_scene(EXAMPLES / f"{name}.toml")
    eye, distance = scene.camera.origin[1], 20e3
    sea = -(distance**2) / (EARTH + np.sqrt(EARTH**2 - distance**2))
    angles = np.linspace(-2.2e-3, 4.2e-3, 500)
    reached = oracle.curve(air, eye, angles, distance, EARTH)
    seen = {"superior_mirage": 12.0, "fata_morgana": 9.9}[name]
    above = reached > seen
    crossings = np.flatnonzero((above[1:] != above[:-1]) & ~np.isnan(reached[1:] + reached[:-1]))
    assert len(crossings) == {"superior_mirage": 3, "fata_morgana": 5}[name]
    step = 1e-6
    for i in crossings:
        # `seen` is above the sea there; along y over x = distance: the two differ by a part in 10⁵
        angle = oracle.image(air, eye, angles[i : i + 2], distance, sea + seen, EARTH)
        low, high = heights_reached(scene.medium, eye, [angle - step, angle + step], distance, rtol=1e-9)
        assert min(low, high) < sea + seen < max(low, high)


# Pictures.

WIDTH, HEIGHT = 1000, 400  # of the scenes' pictures; rendered is a strip of them, with the same pixels
BLUE = 450.0  # nm; 1 % more bending than at 550 nm are 2 pixels over 20 km


def strip(name, x, photons, torch=None, columns=8):
    """A few columns of the scene's picture around the direction (x, ·, −1), in blue light.

    Returns
    -------
    radiance : ndarray, shape (H,)
        Of one column.
    angle : ndarray, shape (H,)
        Elevation of its rays.
    x : float
        Its rays' x over −z.
    """
    scene = cpm.load_scene(EXAMPLES / f"{name}.toml")
    whole = scene.camera
    slope = (whole.target[1] - whole.origin[1]) / -whole.target[2]
    target = np.add(whole.origin, (x, slope, -1.0))
    pitch = 2 * np.tan(np.radians(whole.fov / 2)) / WIDTH * np.sqrt(1 + x * x + slope * slope)
    fov = np.degrees(2 * np.arctan(columns * pitch / 2))
    scene.camera = cpm.Camera.look_at(whole.origin, target, fov=fov)
    if torch is not None:
        scene.add_light(torch)
    image = cpm.render(scene, size=(columns, HEIGHT), photons=photons, wavelengths=[BLUE]).data[..., 0]
    d = pinhole.directions((columns, HEIGHT), whole.origin, target, (0, 1, 0), fov)[:, columns // 2]
    return image[:, columns // 2], np.arctan2(d[:, 1], np.hypot(d[:, 0], d[:, 2])), (d[:, 0] / -d[:, 2])[HEIGHT // 2]


def differ(shown, expected):
    """Rows that show another thing than expected, of those that are not within a pixel of an edge."""
    edge = expected[1:] != expected[:-1]
    near = np.concatenate([edge, [False]]) | np.concatenate([[False], edge])
    return int(np.sum((shown != expected) & ~near))


def test_picture_of_the_vanishing_line():
    """To a pixel of 61 microradians."""
    air = oracle.Air(oracle.hot_surface(30.0, 0.05), wavelength=BLUE, top=60.0)
    image, angle, _ = strip("inferior_mirage", 0.0012, 20_000)
    dark = image < 0.12  # asphalt; hills and sky are brighter
    road = HEIGHT - np.argmin(dark[::-1])  # first row of the run that reaches the bottom
    expected = int(np.sum(angle > oracle.vanishing(air, ROAD_EYE)))
    assert 280 < expected < 320 and abs(road - expected) <= 1


def test_picture_of_the_mast():
    """Red and white bands of half a metre: five white ones upright and one inverted, each edge to a pixel."""
    air = oracle.Air(oracle.hot_surface(30.0, 0.05), wavelength=BLUE, top=60.0)
    torch = cpm.lights.Spot((-8.0, 3.0, -300.0), (-8.0, 2.5, -359.7), cutoff=3.0, intensity=1e9)  # takes most photons
    image, angle, _ = strip("inferior_mirage", -8.0 / 359.7, 20_000, torch)
    reached = oracle.curve(air, ROAD_EYE, angle, 359.7)
    on_mast = (reached > 0) & (reached < 5)
    white = on_mast & (np.floor(reached / 0.5) % 2 == 1)
    shown = on_mast & (image > 0.3 * image.max())  # white reflects 0.8, red 0.04
    assert oracle.runs(white) == 6 and white.sum() > 100
    assert differ(shown, white) == 0 and oracle.runs(shown) == 6


#: x at 20 km; heights above the sea between which the column there is dark in blue light, as (lower, upper) of its x;
#: heights between which nothing else is.
SIGHTS = {
    # a window of the deck
    "superior_mirage": (-70.8, lambda x: (10.6, 12.6), (8.0, 14.0)),
    # the red gable of the house beside the lighthouse
    "fata_morgana": (123.0, lambda x: (12.0, 16.0 - 4 / 8.5 * abs(x - 123)), (8.0, 40.0)),
}


@pytest.mark.parametrize("name", SIGHTS)
def test_pictures_of_the_sea(name):
    """Rows that show a window and a roof in each of their images; and how many images there are."""
    x, bounds, (bottom, top) = SIGHTS[name]
    image, angle, at = strip(name, x / 20e3, 0)
    low, high = bounds(20e3 * at)
    eye = cpm.load_scene(EXAMPLES / f"{name}.toml").camera.origin[1]
    reached = oracle.curve(sea_air(name, BLUE), eye, angle, 20e3, EARTH)
    around = (reached > bottom) & (reached < top)
    expected = around & (reached > low) & (reached < high)
    shown = around & (image < 0.2)
    assert differ(shown, expected) == 0
    assert oracle.runs(shown) == oracle.runs(expected) == 3
