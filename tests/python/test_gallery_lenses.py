"""Luneburg's lens and the SELFOC bars (docs/gallery): what they image where, against closed forms of their rays."""

from pathlib import Path

import numpy as np
import pytest
from oracles import pictures

import cpm

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

# --- Luneburg: with R = 1 about the origin, a ray that meets the sphere at r0 with direction d leaves it at d with direction -r0.


def beyond_the_lens(camera, pixel, depth):
    """Where a line of sight through the lens meets the plane z = depth, (2,)."""
    d, o = camera.direction(pixel), camera.origin
    r0 = o + d * (-(o @ d) - np.sqrt((o @ d) ** 2 - o @ o + 1))
    return (d - r0 * (d[2] - depth) / r0[2])[:2]


@pytest.fixture(scope="module")
def through_the_lens():
    """The scene's view through a narrower angle: a square of the board is 7 pixels."""
    scene, size = cpm.load_scene(EXAMPLES / "luneburg.toml"), (120, 120)
    scene.camera = cpm.Camera.look_at((0, 0, 5), (0, 0, 0), fov=16.0)
    image = cpm.render(scene, size=size, samples=4, wavelengths=[450.0])
    return pictures.Camera.of(scene, size), image.data[..., 0].astype(float)


@pytest.mark.parametrize("place", [(8, 8), (8, 3), (2, 8), (2, 2), (1, 5)])
def test_luneburg_picture(through_the_lens, place):
    """Corners of the distant board in the lens: upside down, to a fifth of a pixel."""
    camera, values = through_the_lens
    target = -45 + 9.0 * np.array(place)
    pixel = camera.size / 2 + 0.5
    for _ in range(30):
        error = beyond_the_lens(camera, pixel, -60.0) - target
        ends = [[beyond_the_lens(camera, pixel + side * h, -60.0) for side in (1, -1)] for h in 0.01 * np.eye(2)]
        slope = np.stack([(ahead - behind) / 0.02 for ahead, behind in ends], axis=1)
        pixel = pixel - np.linalg.solve(slope, error)
    assert np.all((pixel - camera.size / 2) * (target * (1, -1)) <= 1e-6)  # right is left, up is down
    found = pictures.corner(values, pixel, half=3)
    assert np.linalg.norm(found - pixel) < 0.2


@pytest.mark.parametrize("angle", [0.0, 10.0, 25.0])
def test_luneburg_focus(angle):
    """Light from 1e5 radii away meets at the antipode: on the plane that touches the lens there, within 1e-4 R."""
    d = np.array([np.sin(np.radians(angle)), 0.0, -np.cos(np.radians(angle))])
    scene = cpm.Scene()
    scene.add_medium(cpm.media.Luneburg(1.0))
    across = np.array([d[2], 0.0, -d[0]])
    corner = (1 + 1e-9) * d - 0.5 * across - (0, 0.5, 0)
    scene.add_mesh([corner, corner + across, corner + across + (0, 1, 0), corner + (0, 1, 0)], [(0, 1, 2), (0, 2, 3)],
                   cpm.materials.Black())  # fmt: skip
    scene.add_light(cpm.lights.Spot(-1e5 * d, (0, 0, 0), np.degrees(0.9e-5), 1.0))
    photons = cpm.trace_photons(scene, 20_000, wavelengths=[550.0], projection=False)
    place = np.concatenate([photons.diffuse.position, photons.caustic.position]).astype(float)
    off = np.linalg.norm(place - d, axis=1)
    assert len(place) > 19_000
    assert np.median(off) < 2e-5 and np.percentile(off, 99) < 1e-4


# --- SELFOC: n² = n0²(1 − α²ρ²); transverse momentum is kept at the flat ends, inside y = y0 cos ωz + p0/(n0 α) sin ωz, ω = n0 α/p_z.

N0, ALPHA, HALF, STOP = 1.6, 4.0, 0.0499, 0.025
PERIOD = 2 * np.pi / ALPHA
#: x of the axis, length, distance to the letter and to the screen, magnification by the ABCD matrix.
BARS = {
    "A": (0.2, 0.65 * PERIOD, -np.tan(0.65 * np.pi) / (N0 * ALPHA), 1.0),
    "B": (-0.2, 0.25 * PERIOD, 1 / (N0 * ALPHA), -1.0),
}
#: Strokes of the letters: corner, width, height.
LETTER = [(0.0105, -0.03, 0.012, 0.06), (-0.0225, 0.018, 0.033, 0.012), (-0.0105, -0.006, 0.021, 0.012)]


def fresnel(before, after, transverse_squared):
    """Unpolarised reflectance from transverse momenta squared."""
    a, b = np.sqrt(before**2 - transverse_squared), np.sqrt(after**2 - transverse_squared)
    parallel = (after**2 * a - before**2 * b) / (after**2 * a + before**2 * b)
    return 0.5 * (((a - b) / (a + b)) ** 2 + parallel**2)


def through_bar(start, y0, length, distance):
    """Rays from `start` (N, 2), `distance` before the bar, that enter it at `y0`: (N, 2) places on the screen, (N,) shares of power."""
    way = np.column_stack([y0 - start, np.full(len(y0), distance)])
    p0 = way[:, :2] / np.linalg.norm(way, axis=1)[:, None]
    n = N0 * np.sqrt(1 - ALPHA**2 * (y0**2).sum(1))
    share = 1 - fresnel(1.0, n, (p0**2).sum(1))
    axial = np.sqrt(n**2 - (p0**2).sum(1))
    turn = (N0 * ALPHA / axial * length)[:, None]
    grade = N0 * ALPHA
    y, p = y0 * np.cos(turn) + p0 / grade * np.sin(turn), p0 * np.cos(turn) - grade * y0 * np.sin(turn)
    phase = np.arctan2(-p0 / grade, y0)  # y = amplitude cos(ωz + phase): does it touch the sleeve?
    crests = np.floor((turn + phase) / np.pi) >= np.ceil(phase / np.pi)
    largest = np.where(crests, np.hypot(y0, p0 / grade), np.maximum(np.abs(y0), np.abs(y)))
    squared = (p**2).sum(1)
    out = (largest < HALF).all(1) & (squared < 1) & (np.abs(y0) < STOP).all(1)
    squared = np.where(out, squared, 0.0)
    share = np.where(out, share * (1 - fresnel(np.sqrt(axial**2 + squared), 1.0, squared)), 0.0)
    return y + distance * p / np.sqrt(1 - squared)[:, None], share


def letter_image(length, distance, count=400_000):
    """Places on the screen (N, 2), weights (N,) and places on the letter (N, 2) of rays through the bar."""
    rng = np.random.default_rng(1)
    strokes = np.array(LETTER)
    area = strokes[:, 2] * strokes[:, 3]
    stroke = strokes[rng.choice(3, count, p=area / area.sum())]
    start = stroke[:, :2] + rng.random((count, 2)) * stroke[:, 2:]
    y0 = rng.uniform(-STOP, STOP, (count, 2))
    reach = np.sqrt(((y0 - start) ** 2).sum(1) + distance**2)
    weight = (distance / reach**2) ** 2 * (2 * STOP) ** 2 * area.sum() / count
    place, share = through_bar(start, y0, length, distance)
    return place, weight * share, start


@pytest.fixture(scope="module")
def selfoc():
    scene = cpm.load_scene(EXAMPLES / "selfoc.toml")
    return cpm.trace_photons(scene, 4_000_000, seed=3, wavelengths=[560.0]).caustic


@pytest.mark.parametrize("bar", BARS)
def test_selfoc_image(selfoc, bar):
    """Centroid, size and power of the letter's picture: 4 standard errors and 2 % of the closed form."""
    axis, length, distance, magnification = BARS[bar]
    place, power = selfoc.position.astype(float), selfoc.power[:, 0].astype(float)
    place[:, 0] -= axis
    radiance = 0.6 if bar == "A" else 0.25
    near = 0.05
    on = (np.abs(place[:, 2]) < 1e-5) & (np.abs(place[:, :2]) < near).all(1)
    found, found_power = place[on, :2], power[on]
    image, weight, letter = letter_image(length, distance)
    inside = (np.abs(image) < near).all(1)
    image, weight, letter = image[inside], weight[inside], letter[inside]
    expected, middle = (np.average(each, axis=0, weights=weight) for each in (image, letter))
    mean = np.average(found, axis=0, weights=found_power)
    spread = np.sqrt(np.average((image - expected) ** 2, axis=0, weights=weight))
    error = spread / np.sqrt(on.sum())
    assert on.sum() > 3000
    assert np.all(np.abs(mean - expected) < 4 * error), (mean, expected, error)
    np.testing.assert_allclose(np.sqrt(np.average((found - mean) ** 2, axis=0, weights=found_power)), spread, rtol=0.04)
    assert found_power.sum() == pytest.approx(radiance * weight.sum(), rel=0.05)
    # Upright or inverted, and as large as the ABCD matrix says but for aberrations.
    np.testing.assert_allclose(mean / middle, magnification, rtol=0, atol=0.05 + 4 * (error / np.abs(middle)).max())


@pytest.mark.parametrize("bar", BARS)
@pytest.mark.parametrize("point", [(0.02, 0.025), (-0.004, 0.005)])
def test_selfoc_point(bar, point):
    """The picture of a point: a narrow cone's centre of light on the screen, to 4 standard errors (below 20 µm)."""
    axis, length, distance, magnification = BARS[bar]
    point = np.array(point)
    scene = cpm.load_scene(EXAMPLES / "selfoc.toml")
    letter = -(2 * distance + length)
    scene.add_light(cpm.lights.Spot((axis + point[0], point[1], letter), (axis, 0, -distance - length), 2.0, 1e4))
    caustic = cpm.trace_photons(scene, 30_000, seed=4, wavelengths=[560.0], projection=False).caustic
    place, power = caustic.position.astype(float), caustic.power[:, 0].astype(float)
    place[:, 0] -= axis
    # The same cone in the oracle: a disc of directions about the way to the middle of the bar's end.
    rng = np.random.default_rng(2)
    ahead = np.append(-point, distance)
    ahead /= np.linalg.norm(ahead)
    side = np.cross(ahead, (0, 1, 0))
    side /= np.linalg.norm(side)
    cosine, turn = 1 - rng.random(200_000) * (1 - np.cos(np.radians(2.0))), 2 * np.pi * rng.random(200_000)
    sine = np.sqrt(1 - cosine**2)[:, None]
    d = cosine[:, None] * ahead + sine * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(side, ahead))
    start = np.broadcast_to(point, (len(d), 2))
    image, share = through_bar(start, start + distance * d[:, :2] / d[:, 2:], length, distance)
    # Without the ghost, light reflected at both ends of the bar (0.3 %): it lands elsewhere.
    share = np.where(np.linalg.norm(image - magnification * point, axis=1) < 0.003, share, 0.0)
    on = (np.abs(place[:, 2]) < 1e-5) & (np.linalg.norm(place[:, :2] - magnification * point, axis=1) < 0.003)
    expected = np.average(image, axis=0, weights=share)
    spread = np.sqrt(np.average((image - expected) ** 2, axis=0, weights=share))
    mean = np.average(place[on, :2], axis=0, weights=power[on])
    error = spread * np.sqrt(1 / on.sum() + 1 / len(d))
    assert on.sum() > 20_000 and np.all(error < 5e-6)
    assert np.all(np.abs(mean - expected) < 4 * error), (mean - expected, error)
    # The ABCD matrix's magnification, but for third-order aberrations: they grow as the squares of height and aperture.
    third_order = 0.06 * (point @ point + (distance * np.tan(np.radians(2.0))) ** 2) / (0.02**2 + 0.025**2)
    np.testing.assert_allclose(mean / point, magnification, rtol=0, atol=third_order + 4 * (error / np.abs(point)).max())


def test_abcd():
    """The bars' lengths and distances are those of sharp pictures of unit magnification, by the matrix of a SELFOC rod."""
    for _, length, distance, magnification in BARS.values():
        c, s, grade = np.cos(ALPHA * length), np.sin(ALPHA * length), N0 * ALPHA
        rod = np.array([[c, s / grade], [-grade * s, c]])
        free = np.array([[1, distance], [0, 1]])
        total = free @ rod @ free
        np.testing.assert_allclose(total, [[magnification, 0], [total[1, 0], magnification]], atol=1e-12)
