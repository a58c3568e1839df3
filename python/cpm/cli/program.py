"""The commands together, and what their exceptions mean to a shell."""
from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from .. import Error, __version__
from . import bench, explain, info, photons, rays, render

FAILURE, BAD_INPUT, INTERRUPTED = 1, 2, 130

app = typer.Typer(name="cpm", help="Spectral global illumination where light bends.",
                  add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


def _print_version(asked: bool) -> None:
    if asked:
        print(f"cpm {__version__}")
        raise typer.Exit


@app.callback()
def _options(version: Annotated[bool, typer.Option("--version", is_eager=True, callback=_print_version,
                                                   help="Print the version and leave.")] = False) -> None:
    pass


for command in (render.render, photons.photons, rays.rays, explain.explain, bench.bench, info.info):
    app.command()(command)

#: What the command line parser raises for wrong usage; its home differs between versions of typer.
_UsageError: type[Exception] = typer.BadParameter.__bases__[0]


def run(arguments: Sequence[str]) -> int:
    """Run one command; returns the exit status. Errors are one line on stderr."""
    warnings.showwarning = _warn
    try:
        status = app(list(arguments) or ["--help"], prog_name="cpm", standalone_mode=False)
        # Some versions of typer hand back the status of an interrupt rather than raise it.
        return _say("interrupted", INTERRUPTED) if status == INTERRUPTED else status if isinstance(status, int) else 0
    except typer.Exit as leave:
        return leave.exit_code
    except (KeyboardInterrupt, typer.Abort):
        return _say("interrupted", INTERRUPTED)
    except _UsageError as error:
        message: str = error.format_message()  # type: ignore[attr-defined]
        return _say(message, BAD_INPUT) if message else BAD_INPUT
    except (ValueError, TypeError, FileNotFoundError, IsADirectoryError) as error:
        return _say(_one_line(error), BAD_INPUT)
    except (Error, OSError, MemoryError) as error:
        return _say(_one_line(error), FAILURE)


def _one_line(error: BaseException) -> str:
    if isinstance(error, FileNotFoundError) and error.filename:
        return f"{error.filename}: no such file"
    if isinstance(error, IsADirectoryError) and error.filename:
        return f"{error.filename}: is a folder"
    return " ".join(str(error).split()) or type(error).__name__


def _warn(message: Any, category: Any, *_: Any) -> None:
    text = " ".join(str(message).split())
    print(f"cpm: warning: {text}" if issubclass(category, UserWarning) else f"{category.__name__}: {text}",
          file=sys.stderr)


def _say(message: str, status: int) -> int:
    print(f"cpm: {message}", file=sys.stderr)
    return status
