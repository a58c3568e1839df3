"""cpm bench: run a benchmark of the source checkout."""
from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from .. import _data


def bench(name: Annotated[str | None, typer.Argument(help="Which; none: list them.", show_default=False)] = None,
          arguments: Annotated[list[str] | None, typer.Argument(help="For the benchmark, after --.",
                                                                show_default=False)] = None) -> None:
    """Run a benchmark program of the source checkout."""
    folder = bench_folder()
    programs = {path.stem: path for path in sorted(folder.glob("*.py")) if not path.stem.startswith("_")}
    if name is None:
        print("\n".join(programs))
        return
    if name not in programs:
        raise ValueError(f"benchmark is {name!r}; {', '.join(programs) or 'none'} are in {folder}")
    status = subprocess.run([sys.executable, programs[name], *(arguments or [])], check=False).returncode
    raise typer.Exit(status)


def bench_folder() -> Path:
    """``bench/`` of the checkout that this package runs from, or of the one that we stand in."""
    here = Path.cwd()
    for top in (_data.checkout(), here, *here.parents):
        if top is not None and (top / "bench").is_dir() and (top / "libcpm").is_dir():
            return top / "bench"
    raise ValueError("benchmarks are programs of the source checkout: run this inside one")
