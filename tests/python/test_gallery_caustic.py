"""The coloured caustic (docs/gallery/coloured_caustic.md): the bow's radius on the screen, per wavelength, from the photon map.

Oracle: meridional rays (`oracles.bows`), in air and in a liquid whose n varies along the axis.
"""

from pathlib import Path

import numpy as np
import pytest
from oracles import bows, fields, prisms
from support import scenes

import cpm

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WAVELENGTHS = [420.0, 520.0, 680.0]
GEOMETRY = dict(radius=0.1, lamp=2.0, screen=0.4)

#: Daimon & Masumura 2007, water at 20.0 °C; n² = 1 + Σ A λ²/(λ² − B).
WATER = prisms.sellmeier((5.684027565e-1, 1.726177391e-1, 2.086189578e-2, 1.130748688e-1),
                         (5.101829712e-3, 1.821153936e-2, 2.620722293e-2, 1.069792721e1))
CASES = {
    "coloured_caustic": (fields.Homogeneous(1.0), WATER, np.arcsin(0.05), 0.01),
    "coloured_caustic_tank": (fields.LinearSquared(1.777, (0, 0, 0.8)), prisms.SF11, np.radians(2.47), 0.03),
}


@pytest.mark.parametrize("name", CASES)
def test_rim(name):
    """The density of photons falls off a cliff at the fold: the radius of steepest fall, to 1.5 mm of 0.5 m.

    Blue to red it moves by centimetres.
    """
    field, glass, cone, spread = CASES[name]
    scene = cpm.load_scene(EXAMPLES / f"{name}.toml")
    caustic = cpm.trace_photons(scene, 250_000, seed=5, wavelengths=WAVELENGTHS).caustic
    place = caustic.position.astype(float)
    on_screen = np.abs(place[:, 2] - GEOMETRY["screen"]) < 1e-4
    radius = np.hypot(place[:, 0], place[:, 1])
    rims = []
    for wavelength in WAVELENGTHS:
        expected = bows.rim(field, glass(wavelength), cone, **GEOMETRY)
        power = np.where(on_screen, scenes.photons_of(caustic, wavelength), 0.0)
        edges = expected + 0.001 * np.arange(-30, 31)
        density = np.histogram(radius, edges, weights=power)[0] / np.diff(edges**2)
        fall = density[:-2] - density[2:]
        found = 0.5 * (edges[:-1] + edges[1:])[1:-1][np.argmax(fall)]
        assert found == pytest.approx(expected, abs=0.0015), (wavelength, 1e3 * (found - expected))
        inside, outside = density[20:29].mean(), density[31:40].mean()
        assert inside > 2 * outside  # there is a cliff
        rims.append(expected)
    assert rims[0] < rims[1] < rims[2] and rims[2] - rims[0] > spread
