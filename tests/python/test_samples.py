"""A pixel is the mean over its square, whatever the number of eye rays from two on; one alone is in the middle.

The scene is a shining quadrilateral before nothing, seen directly: what a pixel holds is the part of its square that the
quadrilateral covers, known in closed form by clipping (Sutherland and Hodgman), without a photon.
"""

import numpy as np
import pytest
from scipy.stats import chi2

import cpm

SIZE = (24, 18)
SEEDS = 64
CORNERS = np.array([(-0.83, -0.41), (0.62, -0.57), (0.71, 0.33), (-0.55, 0.52)])  # in the picture; its half-width is 1


def scene():
    """Corners in the plane one metre ahead; 90 degrees: half the picture's width is one metre too."""
    made = cpm.Scene()
    vertices = np.column_stack([CORNERS, np.full(4, -1.0)])
    shape = made.add_mesh(vertices, [(0, 1, 2), (0, 2, 3)], material=cpm.materials.Black())
    made.add_light(cpm.lights.Area(shape, 1.0))
    made.camera = cpm.Camera.look_at((0, 0, 0), (0, 0, -1), (0, 1, 0), fov=90.0)
    return made


def clipped(polygon, axis, limit, sign):
    """The part of a polygon on one side of an axis-parallel line."""
    kept = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        inside, then = sign * (a[axis] - limit) >= 0, sign * (b[axis] - limit) >= 0
        if inside:
            kept.append(a)
        if inside != then:
            kept.append(a + (limit - a[axis]) / (b[axis] - a[axis]) * (b - a))
    return np.array(kept).reshape(-1, 2)


def coverage():
    """Covered part of each pixel."""
    width, height = SIZE
    side = 2.0 / width
    covered = np.zeros((height, width))
    for row, column in np.ndindex(height, width):
        left, top = -1.0 + column * side, height / width - row * side
        polygon = CORNERS
        for axis, limit, sign in ((0, left, 1), (0, left + side, -1), (1, top, -1), (1, top - side, 1)):
            polygon = clipped(polygon, axis, limit, sign)
            if not len(polygon):
                break
        else:
            x, y = polygon.T
            covered[row, column] = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / side**2
    return covered


def pictures(samples, seeds=SEEDS):
    options = dict(size=SIZE, photons=0, samples=samples, wavelengths=[550.0])
    return np.array([cpm.render(scene(), seed=seed, **options).data[..., 0] for seed in range(seeds)], dtype=float)


@pytest.mark.parametrize("samples", [2, 3, 5, 16])
def test_mean_is_the_covered_part(samples):
    """χ² over the pixels on the outline, of means over seeds; binomial variance is the most that it can be. 1e-6."""
    covered = coverage()
    mean = pictures(samples).mean(axis=0)
    np.testing.assert_array_equal(mean[covered < 1e-12], 0.0)
    np.testing.assert_allclose(mean[covered > 1 - 1e-12], 1.0, rtol=1e-6)
    outline = (covered > 0.02) & (covered < 0.98)
    assert outline.sum() > 50
    part = covered[outline]
    z = (mean[outline] - part) / np.sqrt(part * (1 - part) / (SEEDS * samples))
    assert (z**2).sum() < chi2.isf(1e-6, len(z))


def test_one_sample_is_the_middle():
    """Whether the pixel's middle is in the quadrilateral; the same for every seed (docs/decisions/0010)."""
    width, height = SIZE
    x = (np.arange(width) + 0.5) * 2 / width - 1
    y = (height - 2 * np.arange(height) - 1) / width
    edges = zip(CORNERS, np.roll(CORNERS, -1, axis=0), strict=True)
    sides = [(b - a)[0] * (y[:, None] - a[1]) - (b - a)[1] * (x - a[0]) for a, b in edges]
    for picture in pictures(1, seeds=3):
        np.testing.assert_array_equal(picture, np.all(np.array(sides) > 0, axis=0))


def test_samples_are_stratified():
    """Sixteen samples miss the covered part by far less than sixteen independent ones would."""
    covered = coverage()
    outline = (covered > 0.02) & (covered < 0.98)
    found = pictures(16, seeds=16).var(axis=0, ddof=1)[outline].mean()
    assert found < 0.4 * (covered * (1 - covered) / 16)[outline].mean()
