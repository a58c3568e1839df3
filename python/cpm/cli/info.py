"""cpm info: versions and devices, for bug reports."""
from __future__ import annotations

import platform
from importlib import metadata

from .. import _core
from ..devices import devices

_PACKAGES = ("numpy", "colour-science", "trimesh", "pydantic", "typer", "rich", "matplotlib", "pyopencl")


def info() -> None:
    """Print versions and devices."""
    print(f"cpm {_core.version()} ({_core.build_info()})")
    print(f"python {platform.python_version()}, {platform.platform()}")
    for device in devices():
        note = "" if device.usable else "; no double precision: not for rays"
        print(f"{device.backend}: {device.name}, {device.units} units ({device.detail}){note}")
    print(", ".join(f"{name} {_version(name)}" for name in _PACKAGES))


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "missing"
