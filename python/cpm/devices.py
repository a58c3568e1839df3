"""What can run here."""
from __future__ import annotations

import platform
from dataclasses import dataclass

from . import _core

__all__ = ["Device", "devices"]


@dataclass(frozen=True)
class Device:
    """Something that rays can be traced on.

    Attributes
    ----------
    backend : {"native", "opencl"}
    name : str
    units : int
        Threads, or an OpenCL device's compute units.
    detail : str
        What the core was built with, or the platform and version of an OpenCL device.
    usable : bool
        Whether this version runs on it; the kernels of :mod:`cpm.kernels` can be run on any.
    """

    backend: str
    name: str
    units: int
    detail: str
    usable: bool


def devices() -> list[Device]:
    """The processor, and the OpenCL devices that pyopencl (if installed) finds.

    Returns
    -------
    list of Device
    """
    return [_processor(), *_opencl_devices()]


def _processor() -> Device:
    return Device("native", platform.processor() or platform.machine(), _core.threads(), _core.build_info(), True)


def _opencl_devices() -> list[Device]:
    try:
        import pyopencl
    except ImportError:
        return []
    try:
        platforms = pyopencl.get_platforms()
    except pyopencl.Error:  # a loader without a platform
        return []
    return [Device("opencl", device.name.strip(), device.max_compute_units,
                   f"{platform_.name.strip()}, {device.version.strip()}", False)
            for platform_ in platforms for device in platform_.get_devices()]
