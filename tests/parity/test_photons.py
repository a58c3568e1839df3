"""Photons traced by OpenCL's kernels against the native ones: the same seed gives the same photons.

Both map's columns are compared as bits, sorted, because where a photon is stored depends on who stored it. An oracle that
shares no code stands behind either side in tests/python and tests/kernels; here a difference means that one of two
compilers, or of two ways of asking for hits, has gone its own way.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.parity_scenes import BINS, columns, lit, box_room, scenes

import cpm

SCENES = scenes()
PATHS = 20_000
#: Embree's float may take another triangle than the tree's double where a ray runs through an edge: one path in 1e5.
DIVERGENT = 1e-5

pytestmark = pytest.mark.skipif(not [d for d in cpm.devices() if d.backend == "opencl" and d.usable],
                                reason="no OpenCL device with double precision")


def trace(scene, backend="opencl", photons=PATHS, **options):
    return cpm.trace_photons(scene, photons, seed=3, wavelengths=BINS, backend=backend, bundle_tolerance=0, **options)


def unequal(a, b):
    """Rows of either table that the other lacks."""
    if a.shape == b.shape and np.array_equal(a, b):
        return 0
    rows = [set(map(bytes, np.ascontiguousarray(t))) for t in (a, b)]
    return len(rows[0] ^ rows[1])


@pytest.mark.parametrize("name", SCENES)
def test_the_same_photons(name):
    """To the last bit, every column of both maps: also where exp, log or sin are needed (cl/shared/elementary.h)."""
    make, _ = SCENES[name]
    native, device = trace(make(), "native"), trace(make())
    stored = len(native.diffuse) + len(native.caustic)
    assert stored > PATHS
    differ = sum(unequal(a, b) for a, b in zip(columns(native), columns(device), strict=True))
    assert differ <= 2 * DIVERGENT * stored
    assert abs(len(device.diffuse) + len(device.caustic) - stored) <= DIVERGENT * stored
    for row, values in native.energy.items():
        np.testing.assert_allclose(device.energy[row], values, rtol=1e-9, atol=1e-9 * native.energy["emitted"].max(), err_msg=row)
    for count in ("photons_emitted", "photon_segments", "photons_lost", "photon_evaluations"):
        assert device.stats[count] == pytest.approx(native.stats[count], rel=DIVERGENT if differ else 0), count


@pytest.mark.parametrize("name", ["homogeneous", "linear_squared", "bounded_three", "glass", "dispersive_air"])
@pytest.mark.parametrize("batch", [1, 7, 256, 100_000])
def test_batches_do_not_change_photons(name, batch):
    """From one flight on the device at a time to more than there are paths."""
    make, _ = SCENES[name]
    few = 300 if batch < 10 else 3000
    native, device = trace(make(), "native", few), trace(make(), photons=few, batch=batch)
    assert [unequal(a, b) for a, b in zip(columns(native), columns(device), strict=True)] == [0, 0]


@pytest.mark.parametrize("method", ["adams", "nystrom", "dopri5"])
def test_steps_do_not_depend_on_what_runs_beside(method):
    """Lanes are rays: evaluations are the same whichever rays share a packet, here by the native batches' length."""
    scene = lit(box_room(cpm.media.LinearSquared(1.69, (0.05, -0.2, 0.02)), method=method))
    counts = {trace(scene, "native", batch=batch).stats["photon_evaluations"] for batch in (16, 64, 2048)}
    assert len(counts) == 1


def test_energy_is_kept():
    """emitted + gain = absorbed + escaped + loss, as on the processor: nothing is lost between two segments."""
    e = trace(SCENES["mirrors_curved"][0]()).energy
    np.testing.assert_allclose(e["emitted"] + e["roulette_gain"], e["absorbed"] + e["escaped"] + e["roulette_loss"], rtol=1e-10)


def test_another_seed_gives_other_photons():
    """The comparison above can fail."""
    scene = SCENES["homogeneous"][0]()
    a, b = trace(scene), cpm.trace_photons(scene, PATHS, seed=4, wavelengths=BINS, backend="opencl", bundle_tolerance=0)
    assert unequal(columns(a)[0], columns(b)[0]) > PATHS


@pytest.mark.parametrize("paths", [0, 1, 33])
def test_few_paths(paths):
    scene = SCENES["homogeneous"][0]()
    a, b = trace(scene, "native", paths), trace(scene, photons=paths)
    assert [unequal(x, y) for x, y in zip(columns(a), columns(b), strict=True)] == [0, 0]
    assert b.stats["photons_emitted"] == paths


def test_a_scene_without_surfaces_or_light():
    empty = cpm.Scene(medium=cpm.media.LinearSquared(1.5, (0, -0.1, 0)))
    assert len(trace(empty).diffuse) == 0
    dark = box_room()
    assert len(trace(dark).diffuse) == 0
    assert len(trace(lit(cpm.Scene())).diffuse) == 0


def test_several_lights_and_bins():
    for bins in (1, 2, 17):
        scene = lit(lit(lit(box_room(cpm.media.LinearSquared(1.69, (0, -0.2, 0))), "area"), "point", (0.3, 0.2, 0.1)))
        wavelengths = np.linspace(400.0, 700.0, bins) if bins > 1 else [550.0]
        a, b = (cpm.trace_photons(scene, 3000, seed=5, wavelengths=wavelengths, backend=where, bundle_tolerance=0) for where in ("native", "opencl"))
        assert [unequal(x, y) for x, y in zip(columns(a), columns(b), strict=True)] == [0, 0]


def test_progress_and_cancelling():
    """A callable is told how far it is; what it raises ends the pass."""
    told = []
    scene = SCENES["linear_squared"][0]()
    trace(scene, progress=lambda stage, fraction: told.append((stage, fraction)))
    fractions = [f for s, f in told if s == "trace"]
    assert fractions == sorted(fractions) and fractions[-1] == 1.0

    def stop(stage, fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        trace(scene, photons=2_000_000, progress=stop)


def test_nothing_is_left_behind():
    """A hundred passes leave no memory behind."""
    import resource

    scene = SCENES["bounded_parabola"][0]()
    for _ in range(10):
        trace(scene, photons=500)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(60):
        trace(scene, photons=500)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 40_000  # kB; one pass's buffers are 15 MB
