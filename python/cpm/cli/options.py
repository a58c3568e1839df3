"""Options that several commands take."""
from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .._files import refuse_unwritable
from ..colorimetry import GAMUTS
from ..image import SUFFIXES
from ..scene import Scene as SceneType
from ..scene_file import load_scene


def _size(text: str) -> Any:
    """400x300 as (400, 300)."""
    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise typer.BadParameter(f"'{text}' is not a size such as 400x300")
    return int(width), int(height)


def _count(text: str) -> Any:
    """3000000, 3_000_000 or 3e6."""
    try:
        number = float(text)
        return int(text) if text.replace("_", "").isdigit() else _whole(number)
    except (ValueError, OverflowError):
        raise typer.BadParameter(f"'{text}' is not a whole number from 0 to 4294967295") from None


def _whole(number: float) -> int:
    if not number.is_integer() or number < 0:
        raise ValueError(number)
    return int(number)


Scene = Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (TOML).", show_default=False)]
Outputs = Annotated[list[Path] | None, typer.Option(
    "--output", "-o", metavar="FILE", help=f"Output, {' or '.join(SUFFIXES)}; may repeat. Default: the scene's name "
    "with both, here.", show_default=False)]
Size = Annotated[Any, typer.Option("--size", metavar="WxH", parser=_size, help="Pixels, as 400x300.",
                                   show_default="the scene's")]
PhotonCount = Annotated[Any, typer.Option("--photons", metavar="N", parser=_count, help="Photon paths to emit.",
                                          show_default="the scene's")]
Nearest = Annotated[int | None, typer.Option("--nearest", metavar="K", help="Photons in an estimate.",
                                             show_default="the scene's")]
Samples = Annotated[int | None, typer.Option("--samples", metavar="N", help="Eye rays a pixel.",
                                             show_default="the scene's")]
BundleTolerance = Annotated[float | None, typer.Option(
    "--bundle-tolerance", metavar="F", show_default="the scene's", help="Pixels, and radii of an estimate: where a medium "
    "disperses, wavelengths nearer than that share one path. 0: none do.")]
Backend = Annotated[str, typer.Option("--backend", metavar="NAME", help="native, opencl, opencl:NUMBER or opencl:NAME (cpm info lists devices).")]
Precision = Annotated[str, typer.Option("--precision", metavar="NAME", help="double.")]
Seed = Annotated[int | None, typer.Option("--seed", metavar="N", help="Of the random numbers.",
                                          show_default="the scene's")]
Threads = Annotated[int, typer.Option("--threads", metavar="N", help="0: all.")]
Exposure = Annotated[float | None, typer.Option("--exposure", metavar="F", show_default="automatic",
                                                help="PNG: factor on luminance in cd/m2.")]
White = Annotated[str | None, typer.Option("--white", metavar="NAME", show_default="none",
                                           help="PNG: illuminant that looks neutral, as E or D65.")]
Gamut = Annotated[str | None, typer.Option("--gamut", metavar="NAME", show_default="clip",
                                           help=f"PNG: what becomes of colours that cannot be shown: "
                                           f"{', '.join(GAMUTS)}.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no table.")]


def outputs_or_default(outputs: list[Path] | None, scene: Path, ending: str = "",
                       suffixes: tuple[str, ...] = SUFFIXES) -> list[Path]:
    """Where to write; refused before the work is done rather than after."""
    chosen = outputs or [Path(f"{scene.stem}{ending}{suffix}") for suffix in suffixes]
    for path in chosen:
        if path.suffix.lower() not in suffixes:
            raise ValueError(f"{path}: suffix '{path.suffix}'; {', '.join(suffixes)} are allowed")
        refuse_unwritable(path)
    if len({path.resolve() for path in chosen}) != len(chosen):
        raise ValueError(f"the same output is given twice: {', '.join(map(str, chosen))}")
    return chosen


def load_for_picture(path: Path) -> SceneType:
    """The scene of a file that must have a camera; the message names the file."""
    scene = load_scene(path)
    if scene.camera is None:
        raise ValueError(f"{path}: camera: missing; a picture needs [camera] with origin, target, up and fov")
    return scene
