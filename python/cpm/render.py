"""Pictures by photon mapping along curved rays."""
from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import as_integer, as_number
from ._progress import ProgressLike, reporting
from .devices import device_index
from .image import Image
from .lights import Environment, Sun, light_spectrum
from .photons import Photons
from .scene import Scene
from .settings import MAX_BATCH, resolve
from .status import require_double

__all__ = ["render"]


def render(scene: Scene, size: tuple[int, int] | None = None, photons: int | Photons | None = None,
           nearest: int | None = None, wavelengths: npt.ArrayLike | None = None, samples: int | None = None,
           seed: int | None = None, backend: str = "native", precision: str = "double", *, threads: int = 0,
           batch: int = 0, projection: bool = True, edge_correction: bool = True, max_radius: float | None = None,
           bundle_tolerance: float | None = None,
           photon_map: Photons | None = None, progress: ProgressLike = False) -> Image:
    """Render a scene.

    Arguments left None come from ``scene.render_defaults`` (a scene file's [render]), then from the package.

    Parameters
    ----------
    scene : Scene
        With a camera.
    size : (width, height), optional
        Pixels; default 400 × 300.
    photons : int or Photons, optional
        Paths to emit, default 3 000 000; or photons traced before.
    nearest : int, optional
        Photons of each map in an estimate; default 150.
    wavelengths : array_like, shape (bins,), optional
        Bin centres, nm, or Bins of :mod:`cpm.wavelengths`; default 16 bins of 400–700 nm. With photons traced before: theirs.
    samples : int, optional
        Eye rays a pixel; default 1, through its middle. More cover it evenly: four smooth the stairs on edges.
    seed : int, optional
        Default 0. The picture does not depend on threads or batch.
    backend : str
        "native": the processor's threads. "opencl": the first OpenCL device that serves; "opencl:1" or "opencl:name":
        the one of that number or with that in its name (:func:`cpm.devices`). The same seed gives the same picture, but
        for rounding.
    precision : {"double"}
    threads, batch : int
        0: chosen.
    projection : bool
        Emit only where something may be hit.
    edge_correction : bool
        Divide an estimate by the part of its disc that lies on surface: no dark lines along edges and corners.
    max_radius : float, optional
        Bound on an estimate's disc, metres. Default: chosen for direct light, else the scene's diagonal.
    bundle_tolerance : float, optional
        Where a medium disperses: wavelengths whose eye rays meet a surface, or leave, within so many pixels of each
        other share one ray; and those whose photons meet a surface within so many radii of the circle that ``nearest``
        photons of their light fill there, if nothing focuses them, share one path. Default 0.1; 0: each wavelength goes
        its own way, as always on an OpenCL device. The time it saves and the error it costs: ``cpm bench wavelengths``.
    photon_map : Photons, optional
        Photons traced before; the same as giving them as ``photons``.
    progress : bool or callable
        True: a bar; a callable gets ``(stage, fraction)``.

    Returns
    -------
    Image

    Warns
    -----
    UserWarning
        The picture is black; the message says why.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C, within a second.

    Notes
    -----
    H. W. Jensen's photon maps along curved rays: Gutierrez, Muñoz, Seron, Jimenez, "Global illumination in
    inhomogeneous media based on curved photon mapping" (2004).
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is {scene!r}; a cpm.Scene is needed")
    device = device_index(backend)
    require_double(precision)
    traced, count = _which_photons(photons, photon_map)
    if traced is not None:
        if wavelengths is not None:
            raise ValueError("wavelengths are given with photons traced before; the picture has theirs")
        wavelengths = traced.wavelengths if traced._bins is None else traced._bins
    if max_radius is not None and not as_number(max_radius, "max_radius") > 0:
        raise ValueError(f"max_radius is {max_radius:g}; it must be > 0 (metres)")
    settings = resolve(scene.render_defaults, size=size, photons=count, nearest=nearest, wavelengths=wavelengths,
                       samples=samples, seed=seed, max_radius=max_radius,
                       bundle_tolerance=bundle_tolerance)
    with reporting(progress) as report:
        handle = _core.render(scene=scene._use(), photon_map=None if traced is None else traced._handle,
                              width=settings.width, height=settings.height, photons=settings.photons,
                              seed=settings.seed, wavelengths=settings.wavelengths, nearest=settings.nearest,
                              samples=settings.samples, max_radius=settings.max_radius, projection=bool(projection),
                              edge_correction=bool(edge_correction), bundle_tolerance=settings.bundle_tolerance,
                              batch=as_integer(batch, "batch", 0, MAX_BATCH),
                              threads=as_integer(threads, "threads", 0, 1024), device=device, progress=report)
    image = Image._of(handle, settings.bins)
    if not image.data.any():
        warnings.warn(f"the picture is black: {_why_black(scene, image.stats, settings.wavelengths)}", stacklevel=2)
    return image


def _why_black(scene: Scene, stats: dict[str, Any], wavelengths: Any) -> str:
    """The first thing without which nothing can be seen."""
    if not scene.lights:
        return "the scene has no lights (Scene.add_light, [[lights]])"
    if not any(np.any(light_spectrum(light).at(wavelengths)) for light in scene.lights):
        return "no light emits at these wavelengths"
    if any(isinstance(light, (Sun, Environment)) for light in scene.lights) and not scene.shapes:
        return "no eye ray leaves the scene towards its sun or environment"
    if not scene.shapes:
        return "the scene has no shapes"
    stored = sum(stats[f"photons_stored_{kind}"] for kind in ("direct", "later", "caustic"))
    if not stats["photons_emitted"] and not stored:
        return "no photons were emitted (photons is 0)"
    if not stored:
        return "no photon met a diffuse surface; do the lights point at something?"
    return "photons were stored, but no eye ray meets a surface that they light; is the camera where it should be?"


def _which_photons(photons: Any, photon_map: Photons | None) -> tuple[Photons | None, int | None]:
    """Photons traced before, and a count to trace: at most one of them."""
    if isinstance(photons, Photons):
        if photon_map is not None and photon_map is not photons:
            raise ValueError("photons and photon_map are both given; one of them is allowed")
        return photons, None
    if photon_map is not None and photons is not None:
        raise ValueError(f"photons is {photons!r} and photon_map is given too; one of them is allowed")
    if photon_map is not None and not isinstance(photon_map, Photons):
        raise TypeError(f"photon_map is {photon_map!r}; what cpm.trace_photons returned is needed")
    return photon_map, photons
