"""Ctrl-C within a second whatever the settings (DESIGN section 8): long work asks the caller often, and ends when told.

The bound is the contract's own; what it guards took from one second to tens of them in a piece.
"""

import time
from pathlib import Path

import numpy as np
import pytest

import cpm

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WITHIN = 1.0  # s


class StopError(Exception):
    pass


class Caller:
    """Stops at the third report after `wait` seconds in the stage that is meant; notes the longest silence in it."""

    def __init__(self, stage, wait=0.3):
        self.stage, self.wait, self.since, self.last, self.silence, self.reports = stage, wait, None, None, 0.0, 0
        self.stopped = None

    def __call__(self, stage, fraction):
        now = time.perf_counter()
        if stage != self.stage:
            return
        if self.since is None:
            self.since = self.last = now
        self.silence, self.last = max(self.silence, now - self.last), now
        self.reports += now - self.since > self.wait
        if self.reports >= 3:
            self.stopped = time.perf_counter()
            raise StopError


def assert_stops(call, caller):
    with pytest.raises(StopError):
        call(caller)
    took = time.perf_counter() - caller.stopped
    assert took < WITHIN, f"went on for {took:.2f} s"
    assert caller.silence < WITHIN, f"did not ask for {caller.silence:.2f} s"


def room():
    return cpm.load_scene(EXAMPLES / "cross_room_curved.toml")


@pytest.mark.parametrize("options", [
    dict(samples=5_000, size=(16, 16)),                     # one tile: all of its samples are one thread's
    dict(nearest=1_000_000, photons=1_000_000, size=(64, 48)),
    dict(samples=400, wavelengths=np.linspace(400, 700, 64)),
], ids=["samples", "nearest", "bins"])
def test_gather(options):
    options = dict(photons=20_000, nearest=150, size=(64, 48)) | options
    assert_stops(lambda caller: cpm.render(room(), progress=caller, **options), Caller("gather"))


def test_integrated_photons():
    scene = room().copy(exclude=("exact",), rtol=1e-13)
    assert_stops(lambda caller: cpm.trace_photons(scene, progress=caller), Caller("trace"))


def noisy():
    values = 1.0 + 0.3 * np.random.default_rng(0).random((20, 20, 20))
    return cpm.media.Grid(values, (-10, -10, -10), 1.0)


RAYS = dict(origins=np.zeros((200_000, 3)), directions=np.random.default_rng(1).normal(size=(200_000, 3)))


def test_rays_in_a_medium():
    assert_stops(lambda caller: cpm.trace(noisy(), **RAYS, wavelength=550.0, length=1000.0, rtol=1e-12,
                                          progress=caller), Caller("trace"))


def test_rays_in_a_scene():
    scene = cpm.Scene(noisy())
    scene.add_sphere((0, 0, 0), 9.0, cpm.materials.Black())
    assert_stops(lambda caller: cpm.trace(scene, **RAYS, wavelength=550.0, rtol=1e-13, progress=caller),
                 Caller("trace"))


def test_irradiance():
    photons = cpm.trace_photons(room(), 200_000)
    points = np.random.default_rng(2).uniform(-1, 1, (200_000, 3)) + (0, 1, 0)
    assert_stops(lambda caller: photons.diffuse.irradiance(points, (0, 1, 0), nearest=1000, progress=caller),
                 Caller("gather"))
