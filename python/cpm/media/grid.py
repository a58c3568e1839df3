"""n from samples on a regular grid."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _core
from .._arrays import VectorLike, as_array, as_number, as_vector, one_of
from ..bounds import Bounds, Box
from ..dispersion import Dispersion
from ._base import Medium

_ALLOWED = ("linear", "cubic")

#: Gladstone–Dale constant of air in the visible, m³/kg.
AIR_GLADSTONE_DALE = 2.26e-4


class Grid(Medium):
    """Samples (nx, ny, nz); outside, the edge value is held.

    Parameters
    ----------
    values : array_like, shape (nx, ny, nz)
        n, or density in kg/m³ with ``quantity="density"``. Float64 arrays are read where they are, with any strides.
    origin : array_like, shape (3,)
        Position of sample (0, 0, 0), metres.
    spacing : array_like, shape (3,), or float
        Distance between samples, metres, > 0.
    interpolation : {"cubic", "linear"}
        Interpolating C² B-spline (prefiltered), or trilinear n.
    quantity : {"n", "density"}
        What ``values`` are.
    gladstone_dale : float
        K of n = 1 + Kρ, m³/kg; the default is air's.
    dispersion : Dispersion or str, optional
    bounds : Box, Sphere or Shape, optional
        Default in a scene's list: the box of the samples.
    """

    def __init__(self, values: npt.ArrayLike, origin: VectorLike = (0.0, 0.0, 0.0),
                 spacing: VectorLike | float = (1.0, 1.0, 1.0), interpolation: str = "cubic", quantity: str = "n",
                 gladstone_dale: float = AIR_GLADSTONE_DALE, dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        super().__init__(dispersion, bounds)
        samples = as_array(values, "values")
        if samples.ndim != 3 or not samples.size:
            raise ValueError(f"values has shape {samples.shape}; (nx, ny, nz) is needed")
        self.interpolation = one_of(interpolation, "interpolation", _ALLOWED)
        self.quantity = one_of(quantity, "quantity", ("n", "density"))
        if quantity == "density":
            samples = 1.0 + as_number(gladstone_dale, "gladstone_dale") * samples
        self.shape = samples.shape
        self.origin = as_vector(origin, "origin")
        self.spacing = as_vector(np.broadcast_to(spacing, 3) if np.ndim(spacing) == 0 else spacing, "spacing")
        self._handle = _core.grid(samples, self.origin, self.spacing, _core.INTERPOLATION[self.interpolation],
                                  self._dispersion_core())

    @property
    def box(self) -> Box:
        """The box of the samples; ValueError where it is flat (one sample along an axis)."""
        size = (np.array(self.shape) - 1) * self.spacing
        return Box(self.origin, np.add(self.origin, size))

    def _own_bounds(self) -> Box:
        return self.box
