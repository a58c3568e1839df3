"""What rays do not need is not run: by counts of evaluations, steps, bytes and paths, and `cpm.explain` says the same."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from oracles.cases import CASES
from support import scenes

import cpm

EXACT = [name for name, case in CASES.items() if case.exact]
ONE_STEP = [name for name in EXACT if not name.startswith("layered")]
FAR = cpm.Box((-100,) * 3, (100,) * 3)


def rays_of(name, target=None, **options):
    case = CASES[name]
    medium = case.make(cpm) if target is None else target
    options.setdefault("wavelength", 550.0)
    return cpm.trace(medium, case.origins(), case.directions(), length=case.length, **options)


def feature(explained, name):
    return next(f for f in explained.features if f.name == name)


@pytest.mark.parametrize("name", ONE_STEP)
def test_exact_is_one_step(name):
    """A closed form goes the whole path in one step and asks for no gradient."""
    rays = rays_of(name)
    assert set(rays.method) == {"exact"}
    assert np.all(rays.steps == 1) and np.all(rays.evaluations == 0) and np.all(rays.rejected == 0)


def test_layers_are_one_step_each():
    """Layers: as many parabolas as layers are entered, counted along a straight way down through all of them."""
    heights = np.array([0.0, 1.0, 2.5, 3.0, 4.0])
    medium = cpm.media.Layered(heights, 1.3 + 0.01 * heights, interpolation="linear-squared")
    rays = cpm.trace(medium, [(0, 4.5, 0)], [(0, -1, 0)], wavelength=550.0, length=5.0)
    assert rays.steps[0] == len(heights) + 1  # above, four layers, below


@pytest.mark.parametrize("method", ["auto", "nystrom", "dopri5", "adams", "euler"])
def test_homogeneous_evaluates_nothing(method):
    """Whatever integrator is asked for; error="global" has nothing to run twice either."""
    rays = rays_of("homogeneous", method=method, error="global")
    assert not (rays.evaluations.any() or rays.error_evaluations.any() or rays.rejected.any() or rays.drift.any())


def test_counters_can_count():
    """The same counters move where an integrator runs."""
    rays = rays_of("parabolic", exclude=("exact",), error="global")
    assert np.all(rays.evaluations >= 9) and np.all(rays.error_evaluations > rays.evaluations)


@pytest.mark.parametrize(("name", "most"), [("linear-squared", 6), ("parabolic", 200), ("fisheye", 500)])
def test_scene_stops_at_length(name, most):
    """In a scene without surfaces a path is followed to its length and no further: not to the end of the scene."""
    case = CASES[name]
    scene = cpm.Scene(medium=case.make(cpm), extent=FAR)
    rays = rays_of(name, scene)
    assert np.all(rays.status == cpm.RayStatus.ARRIVED)
    assert np.all(rays.steps <= most), rays.steps
    np.testing.assert_allclose(rays.position, case.ends().position, rtol=0, atol=1e-9)
    assert not rays.evaluations.any()


def test_scene_integrates_no_further():
    """The same of integrated rays: at most twice the evaluations that the medium alone takes, and room for a last step."""
    medium = cpm.media.Parabolic(1.5, 0.15)
    options = dict(wavelength=550.0, length=3.0, exclude=("exact",), rtol=1e-9)
    alone = cpm.trace(medium, [(0.5, 0, 0)], [(0, 0.2, 1)], **options)
    inside = cpm.trace(cpm.Scene(medium=medium, extent=FAR), [(0.5, 0, 0)], [(0, 0.2, 1)], **options)
    assert inside.evaluations[0] <= 2 * alone.evaluations[0] + 50
    np.testing.assert_allclose(inside.position, alone.position, rtol=0, atol=1e-8)


def test_exact_scene_is_not_run_twice():
    """error="global" has no second run where every medium is exact, and one where some is integrated."""
    once = {"wavelength": 550.0, "length": 3.0, "error": "global"}
    linear = cpm.Scene(medium=cpm.media.LinearSquared(1.69, (0, -0.1, 0)), extent=FAR)
    assert cpm.trace(linear, [(0, 0, 0)], [(1, 0, 0)], **once).error_evaluations[0] == 0
    assert cpm.trace(linear, [(0, 0, 0)], [(1, 0, 0)], exclude=("exact",), **once).error_evaluations[0] > 0


PEAK = """
import re, sys
import numpy as np, cpm
peak = lambda: int(re.search(r"VmHWM:\\s*(\\d+)", open("/proc/self/status").read())[1])  # not a parent's, as ru_maxrss
medium, count, path = cpm.media.LinearSquared(1.69, (0, -0.1, 0)), 2000, int(sys.argv[1])
r, d = np.zeros((count, 3)), np.tile((1.0, 0.2, 0.0), (count, 1))
cpm.trace(medium, r, d, wavelength=550.0, length=3.0, exclude=("exact",), threads=1)
before = peak()
rays = cpm.trace(medium, r, d, wavelength=550.0, length=3.0, exclude=("exact",), threads=1, path=path or False)
print(peak() - before, -1 if rays.paths is None else rays.paths.nbytes)
"""


def grown(path):
    """KiB by which the peak of a process grows, and the bytes of the paths."""
    run = subprocess.run([sys.executable, "-c", PEAK, str(path)], capture_output=True, text=True, check=True)
    return tuple(int(word) for word in run.stdout.split())


def test_no_path_is_stored():
    """Memory that a second call of 2000 rays needs: next to nothing, and 96 MB with 2048 samples of each."""
    without, none = grown(0)
    kept, size = grown(2048)
    assert none == -1 and size == 2000 * 2048 * 24
    assert without < 4 * 1024, "KiB"
    assert kept > 0.9 * size / 1024


def test_one_path_for_all_wavelengths():
    """Without dispersion 16 bins trace what one does, segment by segment; glass that disperses splits its bundles."""
    options = dict(size=(8, 6), photons=4000, nearest=20, seed=1, progress=False)
    bins = np.linspace(400, 700, 16)

    def segments(interior, wavelengths):
        scene = scenes.room(None, scenes.PAINTED)
        scene.add_sphere((-0.8, 0.5, 0.0), 0.4, material=cpm.materials.Dielectric(interior))
        return cpm.render(scene, wavelengths=wavelengths, **options).stats["photon_segments"]

    plain = segments(1.5, bins)
    assert plain == segments(1.5, bins[:1])
    assert segments(cpm.dispersion.Cauchy(1.5, 0.01), bins) > plain


def test_explained_homogeneous():
    """Everything that costs is left out, with zeros to prove it."""
    explained = cpm.explain(cpm.media.Homogeneous(1.5), [(0, 0, 0)], [(1, 0, 0)], length=2.0)
    assert {f.name for f in explained.features if f.needed} == set()
    assert feature(explained, "integrator").counters.startswith("0 evaluations (with: 9.0 evaluations")
    assert feature(explained, "paths").counters.startswith("0 bytes (with: ")
    assert feature(explained, "dispersion").counters.startswith("1 trace(s) for 16 wavelengths (with: 16 ")
    assert all(f.cost is not None and f.cost > 0 for f in explained.features)
    assert "left out" in str(explained) and "×" in str(explained)


def test_explained_counts_are_the_traces():
    """An integrated trace with everything on: its own counters, and each feature in."""
    medium = cpm.media.Parabolic(1.5, 0.15, dispersion="BK7")
    options = dict(length=5.0, exclude=("exact",), path=8, error="global", wavelength=550.0)
    rays = cpm.trace(medium, [(0.5, 0, 0)], [(0, 0.2, 1)], **options)
    explained = cpm.explain(medium, [(0.5, 0, 0)], [(0, 0.2, 1)], **options)
    assert {f.name for f in explained.features if not f.needed} == {"surfaces"}
    assert feature(explained, "integrator").counters.startswith(f"{rays.evaluations[0]:.1f} evaluations")
    assert feature(explained, "global_error").counters.startswith(f"{rays.error_evaluations[0]:.1f} further")
    assert feature(explained, "paths").counters.startswith(f"{len(explained.rays) * 8 * 24:,} bytes")
    assert feature(explained, "dispersion").counters.startswith("16 trace(s) for 16")
    assert explained.rays.evaluations[0] == rays.evaluations[0]


def test_explained_scene():
    """A scene's explanation has its eye rays too: bent, exact, nothing integrated."""
    explained = cpm.explain(scenes.room(scenes.curved_medium(), scenes.PAINTED))
    assert explained.rays is not None
    assert feature(explained.rays, "integrator").counters.startswith("0 evaluations")
    assert feature(explained.rays, "surfaces").needed and "hit" in feature(explained.rays, "surfaces").counters
    assert "Eye rays alone" in str(explained)


def test_nothing_measured():
    """measure=False takes no trial: what is in, and no costs."""
    explained = cpm.explain(cpm.media.Linear(1.3, (0, -0.05, 0)), [(0, 0, 0)], [(1, 0, 0)], length=2.0, measure=False)
    assert all(f.cost is None for f in explained.features)
    assert feature(explained, "curved").needed and not feature(explained, "integrator").needed
    assert "×" not in str(explained)


def test_refused():
    """A medium without rays, rays' options without rays."""
    with pytest.raises(ValueError, match="origins and directions"):
        cpm.explain(cpm.media.Homogeneous(1.5))
    with pytest.raises(ValueError, match="length is given without rays"):
        cpm.explain(scenes.room(None, scenes.PAINTED), length=2.0)
