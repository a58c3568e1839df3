"""Nothing half-written: files are written beside their places, then renamed."""
from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_together(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[Path]]:
    """Names to write to. They take the places of ``paths`` when the block ends well, and vanish when it does not."""
    targets = [Path(path) for path in paths]
    for target in targets:
        if not target.parent.is_dir():
            raise FileNotFoundError(f"{target}: no such folder: {target.parent}")
    # The suffix stays last, so that writers that go by it still know the format.
    beside = [path.with_name(f".{path.stem}.{os.getpid()}-{i}.part{path.suffix}") for i, path in enumerate(targets)]
    try:
        yield beside
        for temporary, target in zip(beside, targets, strict=True):
            os.replace(temporary, target)
    finally:
        for temporary in beside:
            temporary.unlink(missing_ok=True)
