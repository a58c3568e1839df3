"""Nothing half-written: files are written beside their places, then renamed."""
from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def written_together(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[Path]]:
    """Names to write to. They take the places of ``paths`` when the block ends well, and vanish when it does not."""
    targets = [Path(path) for path in paths]
    for target in targets:
        if not target.parent.is_dir():
            raise FileNotFoundError(f"{target}: no such folder: {target.parent}")
    beside = [_beside(path, i) for i, path in enumerate(targets)]
    try:
        yield beside
        for temporary, target in zip(beside, targets, strict=True):
            os.replace(temporary, target)
    except OSError as error:
        # The caller's own name, not that of the file beside it.
        meant = dict(zip(map(os.fspath, beside), targets, strict=True)).get(os.fsdecode(error.filename or ""))
        if meant is None:
            raise
        raise type(error)(error.errno, error.strerror, os.fspath(meant)) from None
    finally:
        for temporary in beside:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


def refuse_unwritable(path: str | os.PathLike[str]) -> None:
    """ValueError that names ``path`` if no file can be made there: by trying, since permissions do not tell all."""
    target = Path(path)
    if not target.parent.is_dir():
        raise ValueError(f"{target}: no such folder: {target.parent}")
    if target.is_dir():
        raise ValueError(f"{target}: is a folder")
    probe = _beside(target, 0)
    try:
        probe.open("xb").close()
        probe.unlink()
    except OSError as error:
        raise ValueError(f"{target}: cannot be written: {(error.strerror or str(error)).lower()}") from None


def _beside(path: Path, number: int) -> Path:
    """The suffix stays last, so that writers that go by it still know the format."""
    return path.with_name(f".{path.stem}.{os.getpid()}-{number}.part{path.suffix}")
