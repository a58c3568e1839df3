"""A prism's spectrum on a wall (docs/gallery/prism.md): each line's place in the photon map, against Snell and Sellmeier.

In air, and in a liquid whose n varies, where the oracle's rays are curves by DOP853 and refract with the local n.
"""

from pathlib import Path

import numpy as np
import pytest
from oracles import fields, prisms
from support import scenes

import cpm

#: Daimon & Masumura 2007, water at 20.0 °C.
WATER = prisms.sellmeier((5.684027565e-1, 1.726177391e-1, 2.086189578e-2, 1.130748688e-1),
                         (5.101829712e-3, 1.821153936e-2, 2.620722293e-2, 1.069792721e1))
D_LINE = 587.5618
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WAVELENGTHS = [410.0, 450.0, 500.0, 550.0, 600.0, 690.0]
#: n² outside, the prism's turn (degrees), the lamp's x and z, x and ends in z of the slit, corner and edge of the wall.
CASES = {
    "prism": (fields.Homogeneous(1.0), 213.6, (-1, 0.0184), (-0.25, 0.0174, 0.0194), (0.04, -0.742), (0.461, 0.194)),
    "prism_tank": (fields.LinearSquared(1.777, (0, 0, -0.6)), 192.0, (-1, -0.0364), (-0.25, 0.0106, 0.0116),
                   (0.6975, -0.534), (0.159, 0.254)),
}
HEIGHT, BAND = 0.03, 0.006  # of the level rays, and of what counts beside them, metres


def aimed(field, start, end):
    """Direction (in the plane) in which a parabola or straight line leaves `start` for `end`: p σ + a σ²/2 spans them."""
    n_squared, acceleration = field(start)
    span = end - start
    # |p|² = n²: with p = span/σ − aσ/2, a quadratic for σ²; the smaller root is the short way.
    a, b, c = (acceleration @ acceleration) / 4, -(span @ acceleration) - n_squared, span @ span
    time = np.sqrt(2 * c / (-b + np.sqrt(b * b - 4 * a * c)))
    return span / time - acceleration * time / 2


def expected_lines(name, disperses=False, count=9):
    """Mean place along the wall of each wavelength, metres from its corner: level rays evenly over the slit.

    `disperses`: n² − 1 outside goes as water's.
    """
    field, turn, lamp, slit, corner, edge = CASES[name]
    lamp = np.array([lamp[0], HEIGHT, lamp[1]])
    corner, along = np.array([corner[0], HEIGHT, corner[1]]), np.array([edge[0], 0, edge[1]])
    along = along / np.linalg.norm(along)
    wall = corner, np.array([along[2], 0, -along[0]])
    faces = prisms.faces_of(0.1, turn)
    first, last = sorted((faces[0], faces[2]), key=lambda face: face[1][0])  # beside edge 0; the lamp is at -x
    openings = [np.array([slit[0], HEIGHT, slit[1] + (slit[2] - slit[1]) * (i + 0.5) / count]) for i in range(count)]
    lines = []
    for w in WAVELENGTHS:
        here = field
        if disperses:
            share = (WATER(w) ** 2 - 1) / (WATER(D_LINE) ** 2 - 1)
            here = fields.LinearSquared(1 + share * (field.n_squared - 1), tuple(share * np.array(field.gradient)))
        ends = [prisms.through(here, prisms.SF11(w), (first, last), lamp, aimed(here, lamp, at), wall) for at in openings]
        lines.append(np.mean([(end - corner) @ along for end in ends]))
    return np.array(lines)


@pytest.mark.parametrize("name, disperses", [("prism", False), ("prism_tank", False), ("prism_tank", True)])
def test_lines(name, disperses):
    """To 4 standard errors (0.1 mm) and what the band's height adds (10 µm); the spectrum is centimetres long."""
    *_, corner, edge = CASES[name]
    scene = cpm.load_scene(EXAMPLES / f"{name}.toml")
    if disperses:
        medium = scene.medium
        scene.medium = cpm.media.LinearSquared(medium.n_squared, medium.gradient, dispersion="water")
    photons = cpm.trace_photons(scene, 300_000, seed=2, wavelengths=WAVELENGTHS)
    caustic = photons.caustic
    place = caustic.position.astype(float)
    corner, edge = np.array([corner[0], 0, corner[1]]), np.array([edge[0], 0, edge[1]])
    length = np.linalg.norm(edge)
    along, across = (place - corner) @ edge / length, (place - corner) @ np.array([edge[2], 0, -edge[0]]) / length
    on_wall = (np.abs(across) < 1e-4) & (np.abs(place[:, 1] - HEIGHT) < BAND) & (along > 0) & (along < length)
    on_wall &= caustic.bounce == 2  # in and out; more: reflected at the prism's foot, from another height
    expected = expected_lines(name, disperses)
    for wavelength, where in zip(WAVELENGTHS, expected, strict=True):
        power = scenes.photons_of(caustic, wavelength).astype(float)
        line = on_wall & (power > 0) & (np.abs(along - where) < 0.006)
        assert line.sum() > 100
        mean = np.average(along[line], weights=power[line])
        error = np.std(along[line]) / np.sqrt(line.sum())
        assert abs(mean - where) < 4 * error + 1e-5, (wavelength, 1e3 * (mean - where), 1e3 * error)
    assert np.ptp(expected) > 0.03
