"""The photon pass and its two maps."""
from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import FloatArray, as_integer, as_number, as_points
from ._progress import ProgressLike, reporting
from .devices import device_index
from .scene import Scene
from .settings import MAX_BATCH, MAX_NEAREST, resolve
from .status import feature_names, require_double
from .wavelengths import Bins

__all__ = ["PhotonMap", "Photons", "trace_photons"]


class PhotonMap:
    """Stored photons: caustic (L S⁺ D) or diffuse (everything else, direct light included).

    Columns are read from the core when they are first asked for. A map that the scene does not need is empty.
    """

    def __init__(self, photons: _core.Photons, name: str) -> None:
        self._photons = photons
        self._name = name

    def __len__(self) -> int:
        return self._photons.count(self._name)

    def __repr__(self) -> str:
        return f"PhotonMap({self._name}, {len(self)} photons)"

    @cached_property
    def position(self) -> npt.NDArray[np.float32]:
        """(N, 3), metres."""
        return self._photons.read(self._name, "position")

    @cached_property
    def direction(self) -> npt.NDArray[np.float32]:
        """(N, 3), unit, of travel."""
        return self._photons.read(self._name, "direction")

    @cached_property
    def power(self) -> npt.NDArray[np.float32]:
        """(N, bins), W/nm; 0 in bins that a photon does not carry (after its bundle split)."""
        return self._photons.read(self._name, "power")

    @cached_property
    def wavelength(self) -> FloatArray:
        """(N, bins), nm."""
        return self._photons.read(self._name, "wavelength")

    @cached_property
    def bounce(self) -> npt.NDArray[np.int32]:
        """(N,); 0 is the first surface."""
        return self._photons.read(self._name, "bounce")

    def irradiance(self, points: npt.ArrayLike, normals: npt.ArrayLike, nearest: int = 150,
                   max_radius: float | None = None, threads: int = 0, progress: ProgressLike = False,
                   backend: str = "native") -> FloatArray:
        """Irradiance estimated from the nearest photons.

        Parameters
        ----------
        points, normals : array_like, shape (N, 3) or (3,)
            Metres; the irradiance is that on the side of the normal, which need not be unit.
        nearest : int
            k ≥ 2. E = Σ(the k − 1 nearer)/(π r_k²); the k-th only sets the radius.
        max_radius : float, optional
            Metres; default the scene's diagonal. With fewer than k inside it, all of them count.
        threads : int
            0: all.
        backend : str
            As :func:`trace_photons` has it: where the photons are searched. The results are equal.

        Returns
        -------
        ndarray, shape (N, bins)
            Actual W·m⁻²·nm⁻¹: direct photons and later ones are searched apart and added.
        """
        where, sides = as_points(points, "points"), as_points(normals, "normals")
        if len(sides) == 1 and len(where) != 1:
            sides = np.ascontiguousarray(np.broadcast_to(sides, where.shape))
        if where.shape != sides.shape:
            raise ValueError(f"points has shape {where.shape} and normals {sides.shape}; they must agree")
        radius = 0.0 if max_radius is None else as_number(max_radius, "max_radius")
        if max_radius is not None and not radius > 0:
            raise ValueError(f"max_radius is {radius:g}; it must be > 0")
        with reporting(progress) as report:
            return self._photons.irradiance(map=self._name, points=where, normals=sides,
                                            nearest=as_integer(nearest, "nearest", 2, MAX_NEAREST), max_radius=radius,
                                            threads=as_integer(threads, "threads", 0, 1024),
                                            device=device_index(backend), progress=report)


class Photons:
    """What :func:`trace_photons` returns.

    Attributes
    ----------
    diffuse, caustic : PhotonMap
    wavelengths : ndarray, shape (bins,)
        Bin centres, nm.
    """

    def __init__(self, handle: _core.Photons, wavelengths: FloatArray, bins: Bins | None = None) -> None:
        self._handle = handle
        self._bins = bins
        self.wavelengths = wavelengths
        self.diffuse = PhotonMap(handle, "diffuse")
        self.caustic = PhotonMap(handle, "caustic")

    @cached_property
    def energy(self) -> dict[str, FloatArray]:
        """The books, each (bins,) in W/nm: emitted + roulette_gain = absorbed + escaped + roulette_loss.

        ``roulette_variance`` is that of gain − loss, (W/nm)².
        """
        return self._handle.energy()

    @cached_property
    def stats(self) -> dict[str, Any]:
        """Seconds per stage, counts and bytes; ``features`` and ``left_out`` name what the scene needed and did not."""
        return named_stats(self._handle.stats())

    def __repr__(self) -> str:
        return f"Photons({len(self.diffuse)} diffuse, {len(self.caustic)} caustic, {len(self.wavelengths)} bins)"


def trace_photons(scene: Scene, photons: int | None = None, *, seed: int | None = None,
                  wavelengths: npt.ArrayLike | None = None, projection: bool = True,
                  bundle_tolerance: float | None = None, threads: int = 0, batch: int = 0, progress: ProgressLike = False,
                  backend: str = "native", precision: str = "double") -> Photons:
    """Emit photons, follow them along their curves, store them.

    Parameters
    ----------
    scene : Scene
    photons : int, optional
        Paths emitted over all lights, not stored. Default: the scene's, else 3 000 000.
    seed : int, optional
        Default: the scene's, else 0. The same seed gives the same photons for any threads and batch.
    wavelengths : array_like, shape (bins,), optional
        Bin centres, nm, or Bins of :mod:`cpm.wavelengths`. Default: the scene's, else 16 bins of 400–700 nm.
    projection : bool
        Emit only where something may be hit (unbiased all the same).
    bundle_tolerance : float, optional
        As in :func:`cpm.render`, for 150 photons. Default: the scene's, else 0.1; 0: each wavelength goes its own way.
    threads, batch : int
        0: chosen.
    progress : bool or callable
        True: a bar; a callable gets ``(stage, fraction)``.
    backend : str
        "native": the processor's threads. "opencl": the first OpenCL device that serves; "opencl:1" or "opencl:name":
        the one of that number or with that in its name (:func:`cpm.devices`). The same seed gives the same photons;
        each wavelength goes its own way there, as with ``bundle_tolerance=0``.
    precision : {"double"}

    Returns
    -------
    Photons

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C, within a second.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is {scene!r}; a cpm.Scene is needed")
    device = device_index(backend)
    require_double(precision)
    settings = resolve(scene.render_defaults, photons=photons, seed=seed, wavelengths=wavelengths,
                       bundle_tolerance=bundle_tolerance)
    with reporting(progress) as report:
        handle = _core.trace_photons(scene=scene._use(), photons=settings.photons, seed=settings.seed,
                                     wavelengths=settings.wavelengths, projection=bool(projection),
                                     bundle_tolerance=settings.bundle_tolerance,
                                     batch=as_integer(batch, "batch", 0, MAX_BATCH),
                                     threads=as_integer(threads, "threads", 0, 1024), device=device, progress=report)
    return Photons(handle, settings.wavelengths, settings.bins)


def named_stats(stats: dict[str, Any]) -> dict[str, Any]:
    """The core's counters with the feature bits as names."""
    needed, left_out = feature_names(stats["features"])
    return {**stats, "features": needed, "left_out": left_out}
