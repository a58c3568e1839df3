"""What a scene does not need is not run: proved by counters, not by a printed list (DESIGN section 5)."""

import numpy as np
from support import scenes

import cpm

OPTIONS = dict(size=(24, 18), photons=5000, nearest=30, wavelengths=[450.0, 550.0, 620.0], seed=1, progress=False)


def numbers(stats, *words, path=""):
    """All numbers in a nested mapping whose dotted path contains every word, as {path: value}."""
    found = {}
    for key, value in stats.items():
        here = f"{path}.{key}".lower()
        if isinstance(value, dict):
            found.update(numbers(value, *words, path=here))
        elif isinstance(value, (int, float, np.number)) and all(w in here for w in words):
            found[here] = float(value)
    return found


def stats_of(scene):
    return dict(cpm.render(scene, **OPTIONS).stats)


def test_homogeneous_room_runs_no_integrator():
    """0 gradient evaluations for photons and eye rays, 0 caustic bytes, no caustic projection map."""
    stats = stats_of(scenes.room(None, scenes.PAINTED))
    evaluations, caustic = numbers(stats, "evaluations"), numbers(stats, "caustic")
    assert evaluations and not any(evaluations.values()), evaluations
    assert any("byte" in key for key in caustic), f"no byte count of the caustic map in {list(stats)}"
    assert not any(caustic.values()), caustic


def test_exact_path_evaluates_nothing_either():
    """Parabolas need no integrator: the closed form is not counted as gradient evaluations of one."""
    stats = stats_of(scenes.room(scenes.curved_medium(), scenes.PAINTED))
    evaluations = numbers(stats, "evaluations")
    assert evaluations and not any(evaluations.values()), evaluations


def test_counters_can_count():
    """The same counters move where there is something: a cubic table, a glass sphere."""
    heights = np.linspace(-0.5, 7, 121)
    medium = cpm.media.Layered(heights, np.sqrt(1.69 - 0.1 * heights), up=(0, 1, 0), interpolation="cubic")
    scene = scenes.room(medium, scenes.PAINTED)
    scene.add_sphere((-0.8, 0.5, 0.0), 0.4, material=cpm.materials.Dielectric(1.5))
    stats = stats_of(scene)
    assert any(numbers(stats, "evaluations").values())
    assert any(v for k, v in numbers(stats, "caustic").items() if "byte" in k)


def test_photon_counters():
    """Photons: stored on two maps, an empty map is empty and never None."""
    photons = cpm.trace_photons(scenes.room(None, scenes.PAINTED), 5000, seed=1, wavelengths=[450.0, 620.0])
    assert photons.caustic is not None and len(photons.caustic.position) == 0
    assert photons.caustic.position.shape == (0, 3) and photons.caustic.power.shape[1:] in ((2,), (1,))
    stored = photons.diffuse
    count = len(stored.position)
    assert stored.position.shape == stored.direction.shape == (count, 3)
    assert (
        stored.power.shape == (count, 2) and stored.wavelength.shape == (count, 2) and stored.bounce.shape == (count,)
    )
    np.testing.assert_array_equal(np.unique(stored.wavelength), [450.0, 620.0])
    np.testing.assert_allclose(np.linalg.norm(stored.direction, axis=1), 1.0, rtol=0, atol=1e-3)


def test_one_path_for_all_wavelengths():
    """Without dispersion a photon carries the whole spectrum; with a dispersive sphere only what met it splits."""
    plain = scenes.room(None, scenes.PAINTED)
    stored = cpm.trace_photons(plain, 5000, seed=1, wavelengths=[450.0, 620.0]).diffuse
    assert np.all(stored.power > 0)
    glass = scenes.room(None, scenes.PAINTED)
    glass.add_sphere((-0.8, 0.5, 0.0), 0.4, material=cpm.materials.Dielectric(cpm.dispersion.Cauchy(1.5, 0.01)))
    photons = cpm.trace_photons(glass, 20_000, seed=1, wavelengths=[450.0, 620.0])
    carries = [np.count_nonzero(scenes.photons_of(photons.caustic, w)) for w in (450.0, 620.0)]
    assert min(carries) > 50
    assert not np.any((scenes.photons_of(photons.caustic, 450.0) > 0) & (scenes.photons_of(photons.caustic, 620.0) > 0))
    direct = photons.diffuse.bounce == 0
    assert np.mean(scenes.photons_of(photons.diffuse, 450.0)[direct] > 0) == 1.0
