"""Trees to SymPy, and what follows: the refractivity without cancellation, and its gradient. Imports SymPy: import late.

Numbers are folded in floating point before SymPy sees them, so that it never meets a power of numbers; its symbols carry no
assumptions, so that it simplifies only what holds everywhere. Functions that SymPy would rewrite into something else are
our own, known to it by their derivatives alone.
"""
from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import sympy
from sympy import Expr, Float, Integer, Rational, Symbol

from .grammar import VARIABLES, Call, Name, Node, Number, Power, Product, Sum, shown

X, Y, Z, R, WAVELENGTH = (Symbol(name) for name in VARIABLES)

#: Largest constant exponent, and largest after SymPy has combined powers of powers.
MAX_EXPONENT, MAX_COMBINED = 100, 1024
#: Bound on the parts of a formula and its derivatives, estimated before they are taken.
MAX_PARTS = 60_000
#: r is never divided by less: at r = 0, where r has no gradient, x/r is 0.
TINY = 1e-30


class Exponential(sympy.Function):  # SymPy's own takes a number out of the exponent: exp(800 - r/8000) would overflow
    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return self


class Less(sympy.Function):  # 1 where a < b, else 0
    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        return Integer(0)


class Sign(sympy.Function):
    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return Integer(0)


class Magnitude(sympy.Function):
    nargs = 1

    def fdiff(self, argindex: int = 1) -> Any:
        return Sign(self.args[0])


class Minimum(sympy.Function):
    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        first = Less(*self.args)
        return first if argindex == 1 else 1 - first


class Maximum(sympy.Function):
    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        second = Less(*self.args)
        return 1 - second if argindex == 1 else second


class Angle(sympy.Function):  # atan2(y, x)
    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:
        y, x = self.args
        return (x if argindex == 1 else -y) / (x**2 + y**2)


_CALLS = {name: getattr(sympy, name) for name in ("sqrt", "log", "sin", "cos", "tan", "asin", "acos", "sinh", "cosh",
                                                  "tanh")} | {"exp": Exponential, "abs": Magnitude, "atan2": Angle, "min": Minimum, "max": Maximum}
_OF_NUMBERS = {name: getattr(math, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "sinh",
                                                      "cosh", "tanh", "atan2")} | {"abs": abs, "min": min, "max": max}


def number(value: float) -> Expr:
    """A float as SymPy's: small whole numbers as such, so that x**2.0 is x**2."""
    return Integer(int(value)) if value == int(value) and abs(value) <= 2**31 else Float(value)


class Reader:
    """A tree as a float (a constant) or an expression."""

    def __init__(self, text: str, constants: Mapping[str, float]) -> None:
        self.text, self.constants = text, constants

    def refused(self, problem: str) -> ValueError:
        return ValueError(f"the formula {shown(self.text)}: {problem}")

    def of_numbers(self, name: str, function: Any, *values: float) -> float:
        try:
            value = function(*values)
        except (ValueError, OverflowError, ZeroDivisionError):
            value = math.nan
        if isinstance(value, complex) or not math.isfinite(value):
            raise self.refused(f"{name} of {', '.join(f'{v:g}' for v in values)} is not a finite real number")
        return float(value)

    def read(self, node: Node) -> float | Expr:
        match node:
            case Number():
                return node.value
            case Name():
                return self.name(node)
            case Sum():
                return self.sum(node)
            case Product():
                return self.product(node)
            case Power():
                return self.power(node)
            case Call():
                return self.call(node)

    def name(self, node: Name) -> float | Expr:
        if node.name in VARIABLES:
            return Symbol(node.name)
        if node.name in self.constants:
            return self.constants[node.name]
        if node.name == "pi":
            return math.pi
        given = f"; given: {', '.join(self.constants)}" if self.constants else ""
        raise self.refused(f"unknown name {shown(node.name)}, character {node.place + 1} (allowed: {', '.join(VARIABLES)}, pi "
                           f"and constants{given})")

    def sum(self, node: Sum) -> float | Expr:
        constant, rest = 0.0, []
        for sign, term in node.terms:
            value = self.read(term)
            if isinstance(value, float):
                constant = self.of_numbers("sum", float.__add__, constant, sign * value)
            else:
                rest.append(value if sign > 0 else -value)
        return sympy.Add(*rest, number(constant)) if rest else constant

    def product(self, node: Product) -> float | Expr:
        constant, rest = 1.0, []
        for sign, factor in node.factors:
            value = self.read(factor)
            if isinstance(value, float):
                combine = float.__mul__ if sign > 0 else float.__truediv__
                constant = self.of_numbers("product" if sign > 0 else "quotient", combine, constant, value)
            else:
                rest.append(value if sign > 0 else 1 / value)
        return sympy.Mul(number(constant), *rest) if rest else constant

    def power(self, node: Power) -> float | Expr:
        base, exponent = self.read(node.base), self.read(node.exponent)
        if isinstance(exponent, float):
            if isinstance(base, float):
                return self.of_numbers("power", pow, base, exponent)
            if abs(exponent) > MAX_EXPONENT:
                raise self.refused(f"the exponent {exponent:g} is beyond ±{MAX_EXPONENT}")
            twice = 2 * exponent
            result = base ** (Rational(int(twice), 2) if twice == int(twice) else Float(exponent))
        elif isinstance(base, float):
            if base <= 0:
                raise self.refused(f"{base:g} to a power that varies; a base that is a number must be > 0")
            result = Exponential(exponent * number(math.log(base)))
        else:
            result = base**exponent
        combined = result.exp if isinstance(result, sympy.Pow) else Integer(0)
        if combined.is_number and not abs(combined) <= MAX_COMBINED:
            raise self.refused(f"powers of powers make an exponent beyond ±{MAX_COMBINED}")
        return result

    def call(self, node: Call) -> float | Expr:
        values = [self.read(argument) for argument in node.arguments]
        if all(isinstance(value, float) for value in values):
            return self.of_numbers(node.function, _OF_NUMBERS[node.function], *values)
        parts = [number(value) if isinstance(value, float) else value for value in values]
        if len(parts) <= 2:
            return _CALLS[node.function](*parts)
        result = parts[0]
        for part in parts[1:]:
            result = _CALLS[node.function](result, part)
        return result


def parts(expression: Expr) -> int:
    """About how many parts an expression and its derivative have, written out; without taking it."""
    sizes: dict[Expr, tuple[int, int]] = {}
    for node in sympy.postorder_traversal(expression):
        if node in sizes:
            continue
        below = [sizes[part] for part in node.args]
        size = 1 + sum(s for s, _ in below)
        own = size * (len(below) if isinstance(node, sympy.Mul) else 1)
        sizes[node] = size, own + sum(d for _, d in below)
    return sum(sizes[expression])


def refractivity(n: Expr) -> Expr:
    """n − 1, with the 1 taken out where it stands, so that small refractivities keep their digits."""
    if isinstance(n, sympy.Pow) and n.exp in (Rational(1, 2), Integer(-1)) and isinstance(n.base, sympy.Add):
        small = refractivity(n.base)
        return small / (1 + n) if n.exp == Rational(1, 2) else -small * n
    if isinstance(n, (Minimum, Maximum)):
        return n.func(*(refractivity(part) for part in n.args))
    return n - 1


def gradient(n: Expr) -> list[Expr]:
    """∂n/∂x, ∂y, ∂z; r is a variable of its own: ∂r/∂x = x/r."""
    radial = n.diff(R)
    per_r = radial / Maximum(R, Float(TINY)) if radial != 0 else Integer(0)
    return [n.diff(axis) + per_r * axis for axis in (X, Y, Z)]


def feature(n: Expr) -> float:
    """Metres over which n may change: 1/|∇u| of the steepest function of a u that is linear in x, y, z; 0: none is."""
    shortest = math.inf
    for node in n.atoms(sympy.Function):
        slopes = [node.args[0].diff(axis) for axis in (X, Y, Z)]
        if all(slope.is_number for slope in slopes):
            steep = math.hypot(*(float(slope) for slope in slopes))
            if steep > 0 and math.isfinite(steep):
                shortest = min(shortest, 1 / steep)
    return shortest if 0 < shortest < math.inf else 0.0
