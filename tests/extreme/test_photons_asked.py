"""No photons asked, a thousand million, and more than there can be."""

import pytest
from support import scenes

import cpm


def lit():
    """A lit triangle."""
    scene = cpm.Scene()
    scene.add_mesh(*scenes.rectangle((0, 0, 0), (0, 0, 1), (1, 0, 0)), material=cpm.materials.Diffuse(0.5))
    scene.add_light(cpm.lights.Point((0.5, 1.0, 0.5), 1.0))
    return scene


def test_none():
    photons = cpm.trace_photons(lit(), 0, wavelengths=[550.0])
    assert photons.diffuse.position.shape == (0, 3) and photons.caustic.position.shape == (0, 3)


def test_a_thousand_million_can_be_stopped():
    """Work begins at once and ends with the call-back's exception: nothing is reserved for 1e9 before."""
    seen = []

    class Enough(Exception):  # noqa: N818
        pass

    def progress(stage, fraction):
        seen.append(fraction)
        if fraction > 0:
            raise Enough

    with pytest.raises(Enough):
        cpm.trace_photons(lit(), 10**9, wavelengths=[550.0], progress=progress)
    assert 0 < seen[-1] < 0.2


@pytest.mark.parametrize("count", [-1, 2**32, 10**13, 2**63, 2**64, 10**400])
def test_more_than_there_can_be(count):
    with pytest.raises((ValueError, OverflowError), match=r"photons is .*; 0 to 4294967295 are allowed"):
        cpm.trace_photons(lit(), count, wavelengths=[550.0])
