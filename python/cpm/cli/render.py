"""cpm render: a scene file to spectral pictures."""
from __future__ import annotations

from typing import Any

from ..image import check_shown, save_all
from ..render import render as render_scene
from . import options
from .report import print_stats


def render(scene: options.Scene, output: options.Outputs = None, photons: options.PhotonCount = None,
           nearest: options.Nearest = None, size: options.Size = None, samples: options.Samples = None,
           backend: options.Backend = "native", precision: options.Precision = "double", seed: options.Seed = None,
           bundle_tolerance: options.BundleTolerance = None, threads: options.Threads = 0,
           exposure: options.Exposure = None, white: options.White = None, gamut: options.Gamut = None,
           quiet: options.Quiet = False) -> None:
    """Render a scene to spectral EXR and PNG."""
    outputs = options.outputs_or_default(output, scene)
    shown: dict[str, Any] = {"exposure": exposure, "white": white, "gamut": gamut}
    check_shown(**shown)
    image = render_scene(options.load_for_picture(scene), size=size, photons=photons, nearest=nearest,
                         samples=samples, seed=seed, backend=backend, precision=precision, threads=threads,
                         bundle_tolerance=bundle_tolerance, progress=not quiet)
    save_all(image, outputs, **shown)
    if not quiet:
        print_stats(image.stats, outputs)
