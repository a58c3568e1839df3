"""Tables of what was done."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

_STAGES = ("prepare", "project", "trace", "map", "gather", "total")


def print_stats(stats: dict[str, Any], outputs: Sequence[Path]) -> None:
    """Seconds per stage, counts, what was left out, what was written."""
    console = Console()
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(style="dim")
    table.add_column(justify="right")
    for stage in _STAGES:
        table.add_row(f"{stage}, s", f"{stats[f'seconds_{stage}']:.3f}")
    table.add_row("photons emitted", f"{stats['photons_emitted']:,}")
    for kind in ("direct", "later", "caustic"):
        table.add_row(f"photons stored, {kind}", f"{stats[f'photons_stored_{kind}']:,}")
    table.add_row("gradient evaluations", f"{stats['photon_evaluations'] + stats['eye_evaluations']:,}")
    table.add_row("eye rays", f"{stats['eye_rays']:,}")
    table.add_row("photon maps, MiB", f"{(stats['bytes_diffuse'] + stats['bytes_caustic']) / 2**20:.1f}")
    console.print(table)
    console.print(f"left out: {', '.join(stats['left_out']) or 'nothing'}", soft_wrap=True)
    if stats["photons_lost"]:
        console.print(f"photons lost to the integrator: {stats['photons_lost']:,}")
    print_outputs(outputs)


def print_outputs(outputs: Sequence[Path]) -> None:
    """One line a file."""
    for path in outputs:
        print(f"wrote {path}")
