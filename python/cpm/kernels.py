"""The kernels' sources, to run straight from pyopencl."""
from __future__ import annotations

import re
from pathlib import Path

from . import _data

__all__ = ["names", "root", "source"]

_INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"')
_GUARD = re.compile(r"^#ifndef (\w+)\n#define \1$", re.MULTILINE)


def root() -> Path:
    """The folder of the sources, an ``-I`` for your own kernels: ``dialect.h``, ``types``, ``shared``, ``kernels``."""
    return _data.folder("cl", "cl")


def names() -> list[str]:
    """The kernel files that :func:`source` knows."""
    return sorted(path.stem for path in (root() / "kernels").glob("*.cl"))


def source(name: str | None = None) -> str:
    """One self-contained OpenCL C 1.2 text, every include in its place.

    Parameters
    ----------
    name : str, optional
        A kernel file, without ``.cl``; default: all of them.

    Returns
    -------
    str
        For ``pyopencl.Program(context, cpm.kernels.source()).build(options=["-cl-std=CL1.2"])``; ``-DCPM_WIDTH=8``
        traces eight rays side by side, ``-DCPM_SINGLE=1`` in single precision.
    """
    if name is not None and name not in names():
        raise ValueError(f"kernel is {name!r}; {', '.join(names())} are allowed")
    seen: set[Path] = set()
    files = [root() / "kernels" / f"{kernel}.cl" for kernel in ([name] if name else names())]
    return "".join(_expanded(file, seen) for file in files)


def _expanded(path: Path, seen: set[Path]) -> str:
    """A file with its includes in place; those with a guard once, since it would drop the second."""
    text = path.read_text(encoding="utf-8")
    if _GUARD.search(text):
        seen.add(path)
    lines = [f"/* {path.relative_to(root())} */\n"]
    for line in text.splitlines(keepends=True):
        match = _INCLUDE.match(line)
        if match is None:
            lines.append(line)
            continue
        included = next((place for place in ((path.parent / match[1]).resolve(), (root() / match[1]).resolve())
                         if place.is_file()), None)
        if included is None:
            lines.append(line)  # a C header, inside #ifndef __OPENCL_VERSION__
        elif included not in seen:
            lines.append(_expanded(included, seen))
    return "".join(lines)
