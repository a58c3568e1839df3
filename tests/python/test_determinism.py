"""The same bits for any thread count and batch size (DESIGN section 4: counter-based random numbers)."""

import numpy as np
import pytest
from support import scenes

import cpm

WAVELENGTHS = [450.0, 550.0, 620.0]


def room_with_glass():
    scene = scenes.room(scenes.curved_medium(), {"white": 0.75, "red": ([400, 700], [0.1, 0.6]), "green": 0.15})
    scene.add_sphere((-0.8, 0.5, 0.0), 0.4, material=cpm.materials.Dielectric(cpm.dispersion.Cauchy(1.5, 0.01)))
    return scene


SCENES = {
    "straight": lambda: scenes.room(None, scenes.PAINTED),
    "curved": lambda: scenes.room(scenes.curved_medium(), scenes.PAINTED),
    "glass": room_with_glass,
}


def same(one, other):
    """Bit-equal photon maps, in the same order."""
    for name in ("diffuse", "caustic"):
        a, b = getattr(one, name), getattr(other, name)
        for field in ("position", "direction", "power", "wavelength", "bounce"):
            np.testing.assert_array_equal(getattr(a, field), getattr(b, field), err_msg=f"{name}.{field}")


@pytest.mark.parametrize("name", SCENES)
def test_photons(name):
    scene = SCENES[name]()
    runs = [
        cpm.trace_photons(scene, 30_000, seed=9, wavelengths=WAVELENGTHS, **options)
        for options in ({"threads": 1}, {"threads": 2}, {"threads": 2, "batch": 1000}, {"threads": 1, "batch": 777})
    ]
    assert len(runs[0].diffuse.power) > 1000
    for other in runs[1:]:
        same(runs[0], other)
    for key, value in runs[0].energy.items():
        np.testing.assert_allclose(value, runs[1].energy[key], rtol=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_picture(name):
    """1 and 2 threads, any batch: the same picture to the last bit."""
    scene = SCENES[name]()
    options = dict(size=(32, 24), photons=20_000, nearest=50, wavelengths=WAVELENGTHS, seed=3, progress=False)
    first = cpm.render(scene, threads=1, **options).data
    np.testing.assert_array_equal(first, cpm.render(scene, threads=2, **options).data)
    np.testing.assert_array_equal(first, cpm.render(scene, threads=2, batch=333, **options).data)
    assert first.max() > 0


def test_seed_matters():
    """Another seed gives other photons; the same seed again, the same."""
    scene = SCENES["curved"]()
    a, b, c = (cpm.trace_photons(scene, 5000, seed=s, wavelengths=[550.0]).diffuse.position for s in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert a.shape != c.shape or not np.array_equal(a, c)


def test_rays():
    """`cpm.trace`: one ray alone and in a crowd, the same bits."""
    rng = np.random.default_rng(0)
    d = rng.normal(size=(257, 3))
    heights = np.linspace(-5, 5, 201)
    medium = cpm.media.Layered(heights, 1.3 + 0.1 * np.tanh(heights), up=(0, 1, 0), interpolation="cubic")
    together = cpm.trace(medium, np.zeros((257, 3)), d, wavelength=550.0, length=3.0, method="dopri5")
    for i in (0, 100, 256):
        alone = cpm.trace(medium, np.zeros((1, 3)), d[i : i + 1], wavelength=550.0, length=3.0, method="dopri5")
        np.testing.assert_array_equal(alone.position[0], together.position[i])
        assert alone.evaluations[0] == together.evaluations[i]
