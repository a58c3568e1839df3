"""cpm explain: what is in, what was left out, what each costs."""
from __future__ import annotations

from typing import Annotated

import typer

from ..explain import explain as explain_scene
from ..explain_device import explain_device
from ..scene_file import load_scene
from . import options


def explain(scene: options.Scene, backend: options.Backend = "native", measure: Annotated[bool, typer.Option(
        help="Render trials to measure the cost of each.")] = True) -> None:
    """Say what a scene needs and what is left out for it."""
    loaded = load_scene(scene)
    print(explain_scene(loaded, measure=measure))
    if backend != "native":
        print(explain_device(loaded, backend))
