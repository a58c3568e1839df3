"""cpm rays: curved paths drawn in a section of the scene."""
from __future__ import annotations

from typing import Annotated

import typer

from .._files import written_together
from ..ray_picture import ray_picture
from ..scene_file import load_scene
from . import options
from .report import print_outputs

#: What matplotlib writes here.
_SUFFIXES = (".png", ".svg", ".pdf")


def rays(scene: options.Scene, output: options.Outputs = None,
         count: Annotated[int, typer.Option("--rays", metavar="N", help="Rays from each light.")] = 25,
         light: Annotated[int | None, typer.Option("--light", metavar="I", show_default="all",
                                                   help="Only this light, counted from 0.")] = None,
         quiet: options.Quiet = False) -> None:
    """Draw curved paths from the lights in a section of the scene (.png, .svg or .pdf)."""
    outputs = options.outputs_or_default(output, scene, "_rays", _SUFFIXES if output else (".png",))
    figure = ray_picture(load_scene(scene), rays=count, light=light)
    with written_together(outputs) as beside:
        for path in beside:
            figure.savefig(path, dpi=150)
    if not quiet:
        print_outputs(outputs)
