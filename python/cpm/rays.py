"""Curved rays, alone in a medium or in a scene."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._arrays import FloatArray, as_integer, as_number, as_points, as_vector, per_ray
from ._progress import ProgressLike, reporting
from .media import Medium, as_medium
from .scene import Scene
from .devices import device_index
from .status import exclusion_bits, method_code

__all__ = ["Rays", "trace"]

#: ``path=True`` asks for so many samples.
DEFAULT_PATH_SAMPLES = 64


@dataclass(frozen=True, repr=False)
class Rays:
    """Where rays ended; all float64, whatever the precision of the trace.

    Attributes
    ----------
    position : ndarray, shape (N, 3)
        Metres.
    direction : ndarray, shape (N, 3)
        Unit, of travel.
    momentum : ndarray, shape (N, 3)
        Optical momentum p = n dr/dl.
    length, optical_path : ndarray, shape (N,)
        Arc length and ∫n dl, metres.
    drift : ndarray, shape (N,)
        Largest | |p| − n |/n on the way.
    error_estimate : ndarray, shape (N,)
        Metres at the end, floored at rounding.
    evaluations, steps, rejected, error_evaluations : ndarray of int64, shape (N,)
        Evaluations of ∇n², steps taken and refused, and evaluations spent on ``error="global"``.
    status : ndarray of int32, shape (N,)
        :class:`cpm.RayStatus`.
    method : ndarray of str, shape (N,)
        What ran.
    shape : ndarray of int32, shape (N,)
        In a scene, the index of the shape hit; −1 for none.
    paths : ndarray, shape (N, K, 3), or None
        With ``path=K``: samples at equal arc length from start to end, metres.
    """

    position: FloatArray
    direction: FloatArray
    momentum: FloatArray
    length: FloatArray
    optical_path: FloatArray
    drift: FloatArray
    error_estimate: FloatArray
    evaluations: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]
    rejected: npt.NDArray[np.int64]
    error_evaluations: npt.NDArray[np.int64]
    status: npt.NDArray[np.int32]
    method: npt.NDArray[np.str_]
    shape: npt.NDArray[np.int32]
    paths: FloatArray | None

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        return f"Rays({len(self)}, {int(self.evaluations.sum())} evaluations)"


def trace(medium_or_scene: Medium | Scene | Any, origins: npt.ArrayLike, directions: npt.ArrayLike, *,
          wavelength: npt.ArrayLike, length: npt.ArrayLike | None = None, until: Any = None, method: str = "auto",
          exclude: Sequence[str] = (), rtol: float | None = None, atol: float | None = None, step: float | None = None,
          max_step: float | None = None, error: str = "local", max_evaluations: int = 1_000_000,
          backend: str = "native", precision: str = "double", path: bool | int = False, threads: int = 0,
          progress: ProgressLike = False) -> Rays:
    """Trace rays along their curves.

    Parameters
    ----------
    medium_or_scene : Medium or Scene
        In a scene a ray ends at the first surface, crossing bounded media and dielectrics by Snell's law.
    origins, directions : array_like, shape (N, 3) or (3,)
        Metres; directions need not be unit.
    wavelength : float or array_like, shape (N,)
        nm.
    length : float or array_like, shape (N,), optional
        Metres of arc.
    until : (point, normal), optional
        A plane to stop at. In a medium exactly one of ``length`` and ``until`` is given, in a scene at most one.
    method : {"auto", "exact", "euler", "rk4", "dopri5"}
        "auto": exact where it exists, else the cheapest for the tolerance. "euler" is the paper's method.
    exclude : sequence of str
        Methods that "auto" may not choose.
    rtol, atol : float, optional
        Position error ≤ atol (m) + rtol × path length, direction error ≤ rtol. Defaults 1e-6 (1e-2 for "euler") and 0;
        1e-14 ≤ rtol ≤ 1.
    step : float, optional
        Fixed steps, metres of arc.
    max_step : float, optional
        Bound on adaptive steps, metres.
    error : {"local", "global"}
        "local": summed embedded errors, indicative only. "global": difference to a second run at rtol/10.
    max_evaluations : int
        Per ray.
    backend : str
        "native": the processor's threads. "opencl": the first OpenCL device that serves; "opencl:1" or "opencl:name": the one of
        that number or with that in its name (:func:`cpm.devices`). For rays alone in a medium; results do not differ.
    precision : {"double", "single"}
    path : bool or int
        K: sample each path at K points of equal arc length; True: 64.
    threads : int
        0: all.
    progress : bool or callable
        True: a bar; a callable gets ``(stage, fraction)``.

    Returns
    -------
    Rays

    Raises
    ------
    ValueError
        Names the first bad index: NaN or infinity, a direction of no length, a wrong shape, a start where n² ≤ 0.

    Notes
    -----
    Solves dr/dσ = p, dp/dσ = ½∇(n²), dσ = dl/n: Gutierrez et al., eq. 2.4, as a Hamiltonian system.
    """
    starts, aims = as_points(origins, "origins"), as_points(directions, "directions")
    if len(starts) != len(aims):
        if 1 not in (len(starts), len(aims)):
            raise ValueError(f"origins has shape {starts.shape} and directions {aims.shape}; they must agree")
        count = max(len(starts), len(aims))
        starts, aims = (np.ascontiguousarray(np.broadcast_to(rows, (count, 3))) for rows in (starts, aims))
    scene = medium_or_scene if isinstance(medium_or_scene, Scene) else None
    if length is not None and until is not None:
        raise ValueError("both length and until are given; one of them is allowed")
    if length is None and until is None and scene is None:
        raise ValueError("neither length nor until is given; a ray in a medium needs one of them")
    plane = None if until is None else _as_plane(until)
    device = device_index(backend)
    if precision not in ("double", "single"):
        raise ValueError(f"precision is {precision!r}; double, single are allowed")
    if error not in _core.ERROR_MODES:
        raise ValueError(f"error is {error!r}; {', '.join(_core.ERROR_MODES)} are allowed")

    with reporting(progress) as report:
        arrays = _core.trace(
            medium=None if scene is not None else as_medium(medium_or_scene)._handle,
            scene=None if scene is None else scene._use(),
            origins=starts,
            directions=aims,
            wavelengths=per_ray(wavelength, "wavelength", len(starts)),
            lengths=None if length is None else per_ray(length, "length", len(starts)),
            plane_point=None if plane is None else plane[0],
            plane_normal=None if plane is None else plane[1],
            method=method_code(method),
            exclude=exclusion_bits(exclude),
            rtol=_option(rtol, "rtol"),
            atol=_option(atol, "atol"),
            step=_option(step, "step"),
            max_step=_option(max_step, "max_step"),
            max_evaluations=as_integer(max_evaluations, "max_evaluations", 1, 2**63 - 1),
            error_mode=_core.ERROR_MODES[error],
            single_precision=precision == "single",
            path_samples=_path_samples(path),
            threads=as_integer(threads, "threads", 0, 1024),
            device=device,
            progress=report,
        )
    arrays["method"] = _names_of(arrays["method"])
    arrays.setdefault("paths", None)
    return Rays(**arrays)


def _option(value: float | None, name: str) -> float:
    """A number that must be positive where it is given (atol: not negative); 0 stands for the core's default."""
    if value is None:
        return 0.0
    number = as_number(value, name)
    if number < 0 or (number == 0 and name != "atol"):
        raise ValueError(f"{name} is {number:g}; it must be {'>= 0' if name == 'atol' else '> 0'}")
    return number


def _as_plane(until: Any) -> tuple[Any, Any]:
    try:
        point, normal = until
    except (TypeError, ValueError):
        raise ValueError(f"until is {until!r}; (point, normal) is needed") from None
    return as_vector(point, "until point"), as_vector(normal, "until normal")


def _path_samples(path: bool | int) -> int:
    if path is True or path is False or path is None:
        return DEFAULT_PATH_SAMPLES if path else 0
    return as_integer(path, "path", 2, 2**24)


def _names_of(codes: npt.NDArray[np.int32]) -> npt.NDArray[np.str_]:
    names = np.full(max(_core.METHODS.values()) + 1, "", dtype="<U10")
    for name, code in _core.METHODS.items():
        names[code] = name
    return names[codes]
