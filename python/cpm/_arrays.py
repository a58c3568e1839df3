"""Arguments into arrays, with errors that name the argument, its value and what is allowed."""
from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Vector: TypeAlias = tuple[float, float, float]
VectorLike: TypeAlias = Sequence[float] | npt.NDArray[Any]
FloatArray: TypeAlias = npt.NDArray[np.float64]


#: Kinds of dtypes whose own names would say little.
_KINDS = {"U": "text", "S": "text", "O": "objects"}


def as_array(value: Any, name: str) -> FloatArray:
    """``value`` as a float64 array; TypeError where that makes no sense (text, complex numbers, ragged lists)."""
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise TypeError(f"{name} is not an array of numbers: {error}") from None
    if array.dtype.kind not in "fiu" and array.size:
        raise TypeError(f"{name} holds {_KINDS.get(array.dtype.kind, array.dtype.name)}; real numbers are needed")
    return array.astype(np.float64, copy=False)


def as_number(value: Any, name: str) -> float:
    """``value`` as one finite float."""
    array = as_array(value, name)
    if array.ndim != 0:
        raise TypeError(f"{name} has shape {array.shape}; one number is needed")
    if not math.isfinite(array):
        raise ValueError(f"{name} is {float(array)}; a finite number is needed")
    return float(array)


def as_vector(value: Any, name: str) -> Vector:
    """``value`` as three finite floats."""
    array = as_array(value, name)
    if array.shape != (3,):
        raise ValueError(f"{name} has shape {array.shape}; three numbers are needed")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} is {tuple(array.tolist())}; finite numbers are needed")
    return (float(array[0]), float(array[1]), float(array[2]))


def as_points(value: Any, name: str) -> FloatArray:
    """``value`` as a C-contiguous (N, 3) array; one point (3,) becomes (1, 3)."""
    array = as_array(value, name)
    if array.shape == (3,):
        array = array[None]
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} has shape {array.shape}; (N, 3) is needed")
    return np.ascontiguousarray(array)


def per_ray(value: Any, name: str, count: int) -> FloatArray:
    """``value`` as one number for all, shape (1,), or one for each, shape (count,)."""
    array = np.atleast_1d(as_array(value, name))
    if array.ndim != 1 or array.size not in (1, count):
        raise ValueError(f"{name} has shape {array.shape}; a number or ({count},) is needed")
    return np.ascontiguousarray(array)


def as_integer(value: Any, name: str, low: int, high: int) -> int:
    """``value`` as an int in [low, high]; 3e6 counts as one, 0.5 does not."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} is {value}; an integer is needed")
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is {value!r}; an integer is needed") from None
    if not low <= number <= high:
        raise ValueError(f"{name} is {number}; {low} to {high} are allowed")
    return number


def one_of(value: Any, name: str, allowed: Sequence[str]) -> str:
    """``value`` if it is one of the names allowed."""
    if not isinstance(value, str) or value not in allowed:
        raise ValueError(f"{name} is {value!r}; {', '.join(allowed)} are allowed")
    return value


def bin_centers(low: float, high: float, bins: int) -> FloatArray:
    """Centres of equal bins.

    Parameters
    ----------
    low, high : float
        Ends of the range, nm.
    bins : int
        How many bins.

    Returns
    -------
    ndarray, shape (bins,)
        ``low + (i + ½)(high − low)/bins``, nm.
    """
    low, high = as_number(low, "low"), as_number(high, "high")
    bins = as_integer(bins, "bins", 1, 256)
    if not 0 < low < high:
        raise ValueError(f"wavelengths from {low} to {high} nm; 0 < low < high is needed")
    return np.asarray(low + (np.arange(bins) + 0.5) * ((high - low) / bins), dtype=np.float64)
