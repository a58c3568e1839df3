"""What a scene compiles for an OpenCL device: which kernels are in, how much source, how long it takes."""
from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

from . import kernels
from .render import render
from .scene import Scene

__all__ = ["explain_device"]

_SIZE = {"size": (2, 2), "photons": 64, "nearest": 4, "samples": 1, "seed": 0}


@contextmanager
def _caches_in(folder: str) -> Iterator[None]:
    """The library's programs and PoCL's are kept there meanwhile."""
    names = ("CPM_CACHE_DIR", "POCL_CACHE_DIR")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, folder))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def explain_device(scene: Scene, backend: str = "opencl") -> str:
    """Text: programs and bytes of source that a render of the scene gives to a device's compiler, and seconds of it.

    Parameters
    ----------
    scene : Scene
        With a camera. Something tiny is rendered three times: from empty caches, and from full ones.
    backend : str
        As :func:`cpm.render` has it.

    Raises
    ------
    ValueError, cpm.Error
        As :func:`cpm.render`.
    """
    with tempfile.TemporaryDirectory() as folder, _caches_in(folder):
        cold = render(scene, backend=backend, **_SIZE).stats
        warm = min((render(scene, backend=backend, **_SIZE).stats for _ in range(2)),
                   key=lambda stats: stats["device_seconds_build"])
    every = sum(len(kernels.source(name).encode()) for name in kernels.names())
    given = cold["device_source_bytes"]
    return (f"on {backend}:\n"
            f"  compiled in   {', '.join(cold['features']) or 'nothing'}\n"
            f"  left out      {', '.join(cold['left_out']) or 'nothing'}\n"
            f"  programs      {cold['device_programs_compiled']}, {given:,} bytes of source: {given / every:.0%} of all kernels'\n"
            f"  built         {cold['device_seconds_build']:.2f} s cold, {warm['device_seconds_build']:.3f} s from the caches")
