"""What is wrong in a scene file, in one line."""
from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

#: Longer values are shortened in messages.
_SHOWN = 60


def printable(text: str) -> str:
    """What a file holds may hold line ends and worse: they are shown, not obeyed."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


class SceneFileError(ValueError):
    """One line naming file, key, value and what is allowed."""

    def __init__(self, path: str | os.PathLike[str], key: str, problem: str) -> None:
        line = ": ".join(part for part in (os.fspath(path), key, problem) if part)
        super().__init__(printable(line))


def key_of(location: Sequence[str | int]) -> str:
    """("lights", 0, "cutoff") as lights[0].cutoff."""
    text = ""
    for part in location:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return printable(text)


def shown(value: Any) -> str:
    """A value as a message shows it."""
    text = printable(f"'{value}'" if isinstance(value, str) else repr(value))
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


def listed(names: Any) -> str:
    """Names as a message lists them."""
    names = list(names)
    return ", ".join(printable(str(name)) for name in names) if names else "none is defined"
