"""The command line; typer and rich are imported by ``main``."""
from __future__ import annotations

import sys


def main() -> None:
    """Run the program and leave with its status: 0, 1 failure, 2 bad input, 130 Ctrl-C."""
    from .program import run

    sys.exit(run(sys.argv[1:]))
