"""Constant n: straight rays, no ODE code runs at all."""
from __future__ import annotations

from typing import Any

from .. import _core
from .._arrays import as_number
from ..bounds import Bounds
from ..dispersion import Dispersion, catalogue, catalogue_names
from ._base import Medium


class Homogeneous(Medium):
    """The same index everywhere.

    Parameters
    ----------
    n : float, str or Dispersion
        The index; a catalogue name ("BK7") or a dispersion gives it for every wavelength.
    dispersion : Dispersion or str, optional
        Of a numeric ``n``, which then holds at 587.5618 nm.
    bounds : Box, Sphere or Shape, optional
    """

    def __init__(self, n: float | str | Dispersion = 1.0, dispersion: Dispersion | str | None = None,
                 bounds: Bounds | None = None) -> None:
        try:
            model = catalogue(n) if isinstance(n, str) else n
        except ValueError:
            raise ValueError(f"n is {n!r}; a number (1 is vacuum), a dispersion or a name from the catalogue "
                             f"({', '.join(catalogue_names())}) is needed") from None
        if isinstance(model, Dispersion):
            if dispersion is not None:
                raise ValueError(f"Homogeneous has n = {n!r} and dispersion = {dispersion!r}; one of them gives n(λ)")
            super().__init__(model, bounds)
            self._handle = _core.dispersive(model._core())
        else:
            super().__init__(dispersion, bounds)
            self.n: Any = as_number(model, "n")
            self._handle = _core.homogeneous(self.n, self._dispersion_core())
