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
        Whether rays can be traced on it: not on a device without double precision.
    memory : int
        Bytes; 0 for the processor.
    """

    backend: str
    name: str
    units: int
    detail: str
    usable: bool
    memory: int = 0


def devices() -> list[Device]:
    """The processor, and the OpenCL devices of this machine, in the order of ``backend="opencl:0"``, ``"opencl:1"``, ...

    Returns
    -------
    list of Device
        Without an OpenCL loader or device: the processor alone.
    """
    return [Device("native", platform.processor() or platform.machine(), _core.threads(), _core.build_info(), True),
            *_opencl_devices()]


def device_index(backend: str) -> int:
    """The core's number of a backend: -1 for "native", else an OpenCL device's.

    Parameters
    ----------
    backend : str
        "native", "opencl", "opencl:1", "opencl:part of a name".
    """
    if backend == "native":
        return -1
    kind, _, wanted = backend.partition(":") if isinstance(backend, str) else ("", "", "")
    if kind != "opencl":
        raise ValueError(f"backend is {backend!r}; native, opencl, opencl:NUMBER and opencl:NAME are allowed")
    found = _opencl_devices()
    names = "; ".join(f"{i}: {device.name}" for i, device in enumerate(found))
    if not found:
        raise _core.Error(f"backend is {backend!r}, but no OpenCL device was found; install one (pocl-opencl-icd), or use "
                          "backend='native'")
    if wanted.isdecimal():
        if int(wanted) >= len(found):
            raise ValueError(f"backend is {backend!r}; the OpenCL devices are {names}")
        return int(wanted)
    fitting = [i for i, device in enumerate(found) if wanted.lower() in f"{device.name} {device.detail}".lower()]
    if not fitting:
        raise ValueError(f"backend is {backend!r}; the OpenCL devices are {names}")
    return next((i for i in fitting if found[i].usable), fitting[0])


def _opencl_devices() -> list[Device]:
    return [Device("opencl", name.strip(), units, f"{platform_.strip()}, {version.strip()}", doubles, memory)
            for name, platform_, version, units, doubles, memory in _core.devices()]
