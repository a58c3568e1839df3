"""n by a formula."""
from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from .._arrays import as_number
from ..bounds import Bounds
from ..dispersion import Dispersion
from ..formulas import compile_formula
from ..formulas.grammar import VARIABLES
from ._base import Medium


class Expression(Medium):
    """n = any formula in x, y, z, r (metres) and wavelength (nm).

    Parameters
    ----------
    text : str
        Of numbers, names, + − * / ** and sqrt, exp, log, sin, cos, tan, asin, acos, atan2, sinh, cosh, tanh, abs, min, max,
        pi; r = √(x² + y² + z²). Parsed by a grammar of its own, never evaluated as code; its gradient is derived
        symbolically. ``1 + small`` keeps the digits of ``small``.
    dispersion : Dispersion or str, optional
        Not for a formula of the wavelength, which disperses by itself.
    bounds : Box, Sphere or Shape, optional
    **constants : float
        Names in the formula; any but x, y, z, r, wavelength (and the two options above).

    Notes
    -----
    Where a value is NaN or infinite, or n not positive, a ray ends with status CUTOFF. At r = 0 the gradient of what
    depends on r is 0. A power with an exponent that is neither whole nor half is taken of bases ≥ 0. Sines of more than
    1e6 are refused as NaN.
    In single precision x, y and z are floats: a formula in r − R at the scale of the Earth is no good there (``cpm.trace``
    warns); spherical ``Layered`` is.

    Examples
    --------
    >>> Expression("1 + N*(1 + e*exp(-y/d))", N=2.77e-4, e=-0.05, d=0.02)   # a hot road
    """

    def __init__(self, text: str, /, *, dispersion: Dispersion | str | None = None, bounds: Bounds | None = None,
                 **constants: float) -> None:
        super().__init__(dispersion, bounds)
        for name in constants:
            if name in VARIABLES:
                raise ValueError(f"a constant is named {name!r}; {', '.join(VARIABLES)} are the formula's own")
        self.text = text
        self.constants = {name: as_number(value, f"constant {name}") for name, value in constants.items()}
        program = compile_formula(text, self.constants)
        self._names = program.names
        self._handle = _core.expression(np.array(program.codes, np.int32), np.array(program.constants, np.float64),
                                        program.results, program.feature, self._dispersion_core())

    def __repr__(self) -> str:
        given: dict[str, Any] = dict(self.constants)
        if self.dispersion is not None:
            given["dispersion"] = self.dispersion
        if self.bounds is not None:
            given["bounds"] = self.bounds
        return f"Expression({', '.join([repr(self.text), *(f'{name}={value!r}' for name, value in given.items())])})"
