"""What all media share: dispersion, bounds, evaluation."""
from __future__ import annotations

from typing import Any

import numpy.typing as npt

from .. import _core
from .._arrays import FloatArray, as_number, as_points
from ..bounds import Bounds, Box
from ..dispersion import Dispersion, as_dispersion

#: Where a varying medium's own numbers hold, nm.
D_LINE = 587.5618


class Medium:
    """A refractive index field; immutable.

    Attributes
    ----------
    dispersion : Dispersion or None
        A varying medium's own numbers hold at the d line, 587.5618 nm. One defined by n scales n − 1 by
        (D(λ) − 1)/(D(d) − 1); one defined by n² scales n² − 1 by (D(λ)² − 1)/(D(d)² − 1), so that its exact paths stay
        exact.
    bounds : Box, Sphere, Shape or None
        Where it is, once added to a scene with :meth:`cpm.Scene.add_medium`.
    """

    _handle: _core.Medium

    def __init__(self, dispersion: Any, bounds: Bounds | None) -> None:
        self.dispersion: Dispersion | None = None if dispersion is None else as_dispersion(dispersion)
        self.bounds = bounds

    @property
    def extent(self) -> Box | None:
        """Where it ends when it fills a scene; None where it has no end of its own."""
        return None

    def _dispersion_core(self) -> _core.Dispersion | None:
        return None if self.dispersion is None else self.dispersion._core()

    def evaluate(self, points: npt.ArrayLike, wavelength: float = D_LINE) -> tuple[FloatArray, FloatArray]:
        """Refractive index and its gradient.

        Parameters
        ----------
        points : array_like, shape (N, 3) or (3,)
            Metres.
        wavelength : float
            nm.

        Returns
        -------
        n : ndarray, shape (N,)
        gradient : ndarray, shape (N, 3)
            ∇n, 1/m.
        """
        return self._handle.evaluate(as_points(points, "points"), as_number(wavelength, "wavelength"))

    def __add__(self, other: Any) -> Medium:
        """Refractivities added: :class:`cpm.media.Sum`."""
        if not isinstance(other, Medium):
            return NotImplemented
        from .sum import Sum

        return Sum(self, other)

    def __radd__(self, other: Any) -> Medium:
        """``sum(media)`` starts at 0."""
        return self if isinstance(other, int) and other == 0 else NotImplemented

    def _own_bounds(self) -> Bounds | None:
        """Where it is in a scene's list if it was given no bounds; None: it must be given some."""
        return None

    def __repr__(self) -> str:
        shown = [f"{name}={value!r}" for name, value in vars(self).items()
                 if not name.startswith("_") and value is not None and not hasattr(value, "shape")]
        return f"{type(self).__name__}({', '.join(shown)})"


def as_medium(value: Any) -> Medium:
    """A medium from itself, a number, a catalogue name or a dispersion."""
    if isinstance(value, Medium):
        return value
    from .homogeneous import Homogeneous

    return Homogeneous(value)
