"""cpm rays: curved paths drawn in a section of the scene."""
from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .._files import written_together
from ..ray_picture import ray_picture
from ..scene_file import load_scene
from . import options
from .report import print_outputs

#: What matplotlib writes here.
_SUFFIXES = (".png", ".svg", ".pdf")


def rays(scene: options.Scene, output: Annotated[list[Path] | None, typer.Option(
             "--output", "-o", metavar="FILE", help=f"Picture, {', '.join(_SUFFIXES[:-1])} or {_SUFFIXES[-1]}; may "
             "repeat. Default: the scene's name with _rays.png, here.", show_default=False)] = None,
         count: Annotated[int, typer.Option("--rays", metavar="N", help="Rays that each light sends out, in a "
                                                  "fan across its cone (spot) or over the scene (point, area).")] = 25,
         light: Annotated[int | None, typer.Option("--light", metavar="I", show_default="all",
                                                   help="Draw one light only: 0 is the scene's first.")] = None,
         quiet: options.Quiet = False) -> None:
    """Draw where light goes: a section of the scene with rays from its lights.

    The plane is upright, through the first light drawn and what it is aimed at. Each ray is followed along its curve to
    the first surface. The index n is the background where it varies. Where n depends on the wavelength, three
    wavelengths are drawn.
    """
    outputs = options.outputs_or_default(output, scene, "_rays", _SUFFIXES if output else (".png",))
    figure = ray_picture(load_scene(scene), rays=count, light=light, title=scene.stem)
    with written_together(outputs) as beside:
        for path in beside:
            figure.savefig(path, dpi=150)
    if not quiet:
        print_outputs(outputs)
