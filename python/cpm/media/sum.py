"""Media added up."""
from __future__ import annotations

import numpy as np

from .. import _core
from ..bounds import Bounds, Box
from ._base import Medium


class Sum(Medium):
    """n = 1 + Σ(nᵢ − 1): refractivities add up, each term at its own dispersion. What ``a + b`` makes.

    Parameters
    ----------
    *terms : Medium
        At most 64; sums among them are taken apart. Discrete layers ("step") have no gradient and cannot be a term, nor
        can a medium with bounds: bound the sum.
    bounds : Box, Sphere or Shape, optional
    """

    def __init__(self, *terms: Medium, bounds: Bounds | None = None) -> None:
        super().__init__(None, bounds)
        if not terms:
            raise ValueError("a sum has no terms; at least one is needed")
        flat: list[Medium] = []
        for i, term in enumerate(terms):
            if not isinstance(term, Medium):
                raise TypeError(f"terms[{i}] is {term!r}; a medium is needed")
            if term.bounds is not None:
                raise ValueError(f"terms[{i}] has bounds; terms fill space: give bounds to the sum")
            flat.extend(term.terms if isinstance(term, Sum) else [term])
        self.terms = tuple(flat)
        self._handle = _core.sum([term._handle for term in terms])
        extinctions = [term.extinction for term in flat if getattr(term, "extinction", None) is not None]
        if extinctions:  # of all of it: what is added to air is more or less of it
            from .atmosphere import dim

            dim(self._handle, extinctions[0])

    @property
    def extent(self) -> Box | None:
        """A box around those of the terms; None where none has one."""
        boxes = [term.extent for term in self.terms if term.extent is not None]
        if not boxes:
            return None
        return Box(np.min([box.low for box in boxes], axis=0), np.max([box.high for box in boxes], axis=0))

    def __repr__(self) -> str:
        bounds = "" if self.bounds is None else f", bounds={self.bounds!r}"
        return f"Sum({', '.join(map(repr, self.terms))}{bounds})"
