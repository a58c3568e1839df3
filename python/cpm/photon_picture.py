"""The photon map seen by the camera: figures 2 and 4 of the paper."""
from __future__ import annotations

from typing import Any

import numpy as np

from ._progress import ProgressLike
from .image import Image
from .photons import trace_photons
from .render import render
from .scene import Scene
from .shapes import extent_of

__all__ = ["photon_picture"]

#: Dots are told apart at this many photons; more and they run together.
DEFAULT_PHOTONS = 300_000

#: Radius of a dot over the diagonal of what the camera may see.
_DOT = 6e-4

#: More photons than lie in any dot, so that every estimate is the sum over its whole disc.
_ALL = 1_000_000


def photon_picture(scene: Scene, photons: int | None = None, size: tuple[int, int] | None = None,
                   dot: float | None = None, seed: int | None = None, backend: str = "native", threads: int = 0,
                   progress: ProgressLike = False) -> Image:
    """Each photon a small disc on its surface, of its own spectrum.

    An estimate over a disc of fixed, tiny radius: eye rays find photons where the curved paths, mirrors and glass put
    them, and surfaces hide those behind, as in any render.

    Parameters
    ----------
    scene : Scene
        With a camera.
    photons : int, optional
        Paths to emit; default 300 000.
    size : (width, height), optional
        Pixels; default the scene's.
    dot : float, optional
        Radius of a disc, metres; default 6e-4 of the diagonal of the shapes.
    seed, backend, threads, progress
        As in :func:`cpm.render`.

    Returns
    -------
    Image
    """
    if dot is None:
        low, high = extent_of(scene.shapes)
        dot = _DOT * float(np.linalg.norm(high - low))
    options: dict[str, Any] = {"seed": seed, "backend": backend, "threads": threads, "progress": progress}
    traced = trace_photons(scene, DEFAULT_PHOTONS if photons is None else photons, **options)
    return render(scene, size=size, photon_map=traced, nearest=_ALL, max_radius=dot, edge_correction=False,
                  **options)
