"""Tables shipped with the package, and the kernels' sources: in a wheel beside this file, in a checkout at its top."""
from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

_PACKAGE = Path(__file__).resolve().parent
_CHECKOUT = _PACKAGE.parent.parent


def folder(installed: str, in_checkout: str) -> Path:
    """The folder ``installed`` of the package or, run from a checkout, ``in_checkout`` at its top."""
    for candidate in (_PACKAGE / installed, _CHECKOUT / in_checkout):
        if candidate.is_dir():
            return candidate
    raise FileNotFoundError(f"{_PACKAGE / installed}: not there; the installation of cpm is incomplete")


@cache
def table(name: str) -> dict[str, Any]:
    """A TOML table of ``spectral/data``."""
    with open(folder("data", "spectral/data") / name, "rb") as file:
        return tomllib.load(file)


def checkout() -> Path | None:
    """The top of the source checkout that this package runs from, if it does."""
    return _CHECKOUT if (_CHECKOUT / "pyproject.toml").is_file() and (_CHECKOUT / "libcpm").is_dir() else None
