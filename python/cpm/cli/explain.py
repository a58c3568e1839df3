"""cpm explain: what is in, what was left out, what each costs."""
from __future__ import annotations

from typing import Annotated

import typer

from ..explain import explain as explain_scene
from ..scene_file import load_scene
from . import options


def explain(scene: options.Scene, measure: Annotated[bool, typer.Option(
        help="Render trials to measure the cost of each.")] = True) -> None:
    """Say what a scene needs and what is left out for it."""
    print(explain_scene(load_scene(scene), measure=measure))
