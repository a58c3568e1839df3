"""cpm photons: the photon map as a picture."""
from __future__ import annotations

from typing import Annotated, Any

import typer

from ..image import check_shown, save_all
from ..photon_picture import photon_picture
from . import options
from .report import print_stats


def photons(scene: options.Scene, output: options.Outputs = None, photons: options.PhotonCount = None,
            size: options.Size = None, dot: Annotated[float | None, typer.Option(
                "--dot", metavar="M", help="Radius of a photon's dot, metres.", show_default="by the scene")] = None,
            backend: options.Backend = "native", seed: options.Seed = None, threads: options.Threads = 0,
            exposure: options.Exposure = None, white: options.White = None,
            gamut: options.Gamut = None, quiet: options.Quiet = False) -> None:
    """Draw the photon map as the scene's camera sees it: each photon a dot of its own spectrum."""
    outputs = options.outputs_or_default(output, scene, "_photons")
    shown: dict[str, Any] = {"exposure": exposure, "white": white, "gamut": gamut}
    check_shown(**shown)
    image = photon_picture(options.load_for_picture(scene), photons=photons, size=size, dot=dot, seed=seed,
                           backend=backend, threads=threads, progress=not quiet)
    save_all(image, outputs, **shown)
    if not quiet:
        print_stats(image.stats, outputs)
