"""Gröller's gravity centres (docs/gallery/gravity_centres.md): corners of the boards in the picture, against DOP853."""

from pathlib import Path

import numpy as np
import pytest
from oracles import fields, pictures

import cpm

SCENE = Path(__file__).resolve().parents[2] / "examples" / "gravity_centres.toml"
SIZE = (300, 225)


def field(share=1.0):
    """The scene's sources, or a share of their strengths."""
    return fields.Sources(
        centers=((-0.9, 2.4, 0.0), (0.95, 1.3, 0.2), (0.35, 0, -1.2)),
        strengths=(share * 0.025, share * -0.04, share * 0.012),
        exponents=(2.0, 2.0, 2.0),
        directions=((0, 0, 0), (0, 0, 0), (0, 1, 0)),
    )


#: Column and row of corners of the back wall, from its lower left; between them all directions of bending.
CORNERS = [(2, 2), (1, 3), (3, 3), (7, 8), (4, 8), (2, 8)]


@pytest.fixture(scope="module")
def shown():
    scene = cpm.load_scene(SCENE)
    image = cpm.render(scene, size=SIZE, samples=9, wavelengths=[600.0])
    return pictures.Camera.of(scene, SIZE), image.data[..., 0].astype(float)


@pytest.mark.parametrize("place", CORNERS)
def test_corners(shown, place):
    """To a tenth of a pixel; the line of sight bends by many."""
    camera, values = shown
    point = np.array([-2 + 0.4 * place[0], 0.4 * place[1], -2.0])
    expected = camera.pixel(point)
    for share in (0.5, 1.0):  # the image that the straight one grows into
        expected = camera.pixel_along(field(share), point, (0, 0, 1), expected)
    assert np.linalg.norm(expected - camera.pixel(point)) > 1.0
    assert np.linalg.norm(pictures.corner(values, expected) - expected) < 0.1


def test_the_centre_swallows(shown):
    """Black where the impact parameter is below 2 sqrt(m) (k = 2): the shadow is as wide as that, to a pixel."""
    camera, values = shown
    x, y = camera.pixel((-0.9, 2.4, 0.0))
    row = values[int(y)]
    left, right = int(x), int(x)
    while row[left - 1] == 0:
        left -= 1
    while row[right] == 0:
        right += 1
    distance = np.linalg.norm(np.subtract((-0.9, 2.4, 0.0), camera.origin))
    assert 0.5 * (right - left) == pytest.approx(camera.scale * 2 * np.sqrt(0.025) / distance, abs=1.5)
