"""Expressions to programs of cpm_medium_create_expression: common parts once, constants folded, registers shared."""
from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import grammar
from .grammar import VARIABLES, shown

if TYPE_CHECKING:
    from sympy import Expr

MAX_INSTRUCTIONS, REGISTERS = 4096, 128
#: Operation numbers of cpm/medium.h.
OPERATIONS = {"constant": 1, "add": 2, "subtract": 3, "multiply": 4, "divide": 5, "scale": 6, "affine": 7, "multiply-add": 8,
              "invert": 9, "sqrt": 20, "Exponential": 21, "log": 22, "sin": 23, "cos": 24, "tan": 25, "asin": 26, "acos": 27,
              "Angle": 28, "sinh": 29, "cosh": 30, "tanh": 31, "Magnitude": 32, "Minimum": 33, "Maximum": 34, "Sign": 35,
              "Less": 36, "power": 37}


@dataclass(frozen=True)
class Program:
    """What the C core runs.

    Attributes
    ----------
    codes : tuple of (operation, target, a, b, c)
    constants : tuple of (k, l)
    results : tuple of int
        Registers of N, ∂N/∂x, ∂N/∂y, ∂N/∂z.
    feature : float
        Metres over which n may change its shape; 0: unknown.
    names : frozenset of str
        The variables that the formula depends on.
    """

    codes: tuple[tuple[int, int, int, int, int], ...]
    constants: tuple[tuple[float, float], ...]
    results: tuple[int, int, int, int]
    feature: float
    names: frozenset[str]


def compile_formula(text: str, constants: Mapping[str, float]) -> Program:
    """The program of a formula for n; ValueError in one line where it has none."""
    tree = grammar.parse(text)
    from . import symbolic as s  # SymPy takes 0.3 s: not before it is needed

    reader = s.Reader(text, constants)
    try:
        value = reader.read(tree)
        n = s.number(value) if isinstance(value, float) else value
        if value == value and isinstance(value, float) and not value > 0:
            raise reader.refused(f"n is {value:g} everywhere; it must be > 0")
        if n.has(s.sympy.I, s.sympy.zoo, s.sympy.oo, s.sympy.nan):
            raise reader.refused("a part of it has no finite real value")
        size = s.parts(n)
        if size > s.MAX_PARTS:
            raise reader.refused(f"with its derivatives it has about {size} parts; at most {s.MAX_PARTS} are allowed")
        writer = _Writer(reader)
        results = [writer.register(writer.write(part)) for part in (s.refractivity(n), *s.gradient(n))]
        names = frozenset(str(symbol) for symbol in n.free_symbols)
        return writer.program(results, s.feature(n), names)
    except RecursionError:
        raise reader.refused("too deeply nested") from None


class _Writer:
    """Value numbering: an instruction that was written before is not written again."""

    def __init__(self, reader: Any) -> None:
        self.reader = reader
        self.instructions: list[tuple[str, tuple[int, ...], float, float]] = []  # operation, operands, k, l
        self.known: dict[tuple[str, tuple[int, ...], float, float], int] = {}
        self.written: dict[Expr, int | float] = {}

    # Values are numbers (float) or the index of what gives them: 0 to 4 variables, from 5 on instructions.

    def emit(self, operation: str, *operands: int, k: float = 0.0, l: float = 0.0) -> int:  # noqa: E741
        if not (math.isfinite(k) and math.isfinite(l)):
            raise self.reader.refused("a number in it is not finite")
        key = operation, operands, k, l
        if key not in self.known:
            if len(self.instructions) == MAX_INSTRUCTIONS:
                raise self.reader.refused(f"it takes more than {MAX_INSTRUCTIONS} instructions")
            self.known[key] = len(VARIABLES) + len(self.instructions)
            self.instructions.append(key)
        return self.known[key]

    def register(self, value: int | float) -> int:
        return self.emit("constant", k=value) if isinstance(value, float) else value

    def write(self, node: Expr) -> int | float:
        if node not in self.written:
            self.written[node] = self.anew(node)
        return self.written[node]

    def anew(self, node: Expr) -> int | float:
        if node.is_Symbol:
            return VARIABLES.index(str(node))
        if node.is_number:
            try:
                return float(node)
            except TypeError:
                raise self.reader.refused(f"{shown(str(node))} in it is not a real number") from None
        if node.is_Add:
            return self.sum(node)
        if node.is_Mul:
            return self.product(node)
        if node.is_Pow:
            return self.power(node.base, node.exp)
        name = type(node).__name__
        if name not in OPERATIONS:
            raise self.reader.refused(f"its derivative holds {name}, which is not known here")
        return self.emit(name, *(self.register(self.write(part)) for part in node.args))

    def scaled(self, k: float, value: int, plus: float = 0.0) -> int:
        """k value + plus."""
        if plus != 0.0:
            return self.emit("affine", value, k=k, l=plus)
        return value if k == 1.0 else self.emit("scale", value, k=k)

    def sum(self, node: Any) -> int:
        """The constant goes with the first term."""
        constant, total = 0.0, None
        split = [part.as_coeff_Mul() for part in node.args]
        for factor, rest in split:
            if rest.is_number:
                constant += float(factor * rest)
        for factor, rest in split:
            if rest.is_number:
                continue
            k, value = float(factor), self.register(self.write(rest))
            if total is None:
                total = self.scaled(k, value, constant)
            elif abs(k) == 1.0:
                total = self.emit("add" if k > 0 else "subtract", total, value)
            else:
                total = self.emit("add", total, self.scaled(k, value))
        assert total is not None
        return total

    def product(self, node: Any) -> int | float:
        k, over, under = 1.0, None, None
        for part in node.args:
            below = part.is_Pow and part.exp.is_number and part.exp.is_negative
            value = self.power(part.base, -part.exp) if below else self.write(part)
            if isinstance(value, float):
                k = k / value if below else k * value
            elif below:
                under = value if under is None else self.emit("multiply", under, value)
            else:
                over = value if over is None else self.emit("multiply", over, value)
        if under is None:
            return k if over is None else self.scaled(k, over)
        if over is None:
            return self.emit("invert", under, k=k)
        return self.scaled(k, self.emit("divide", over, under))

    def power(self, base: Any, exponent: Any) -> int | float:
        value = self.write(base)
        if not exponent.is_number:
            return self.emit("power", self.register(value), self.register(self.write(exponent)))
        size = abs(exponent)
        at = self.register(value)
        if size.is_Integer:
            result = self.whole_power(at, int(size))
        elif size.is_Rational and size.q == 2:
            result = self.emit("sqrt", at)
            if size.p > 1:
                result = self.emit("multiply", result, self.whole_power(at, int(size.p) // 2))
        else:
            return self.emit("power", at, self.register(float(exponent)))
        return self.emit("invert", result, k=1.0) if exponent.is_negative else result

    def whole_power(self, at: int, exponent: int) -> int:
        """By squaring; 1 and up."""
        if exponent == 1:
            return at
        if exponent % 2:
            return self.emit("multiply", self.whole_power(at, exponent - 1), at)
        root = self.whole_power(at, exponent // 2)
        return self.emit("multiply", root, root)

    def program(self, results: list[int], feature: float, names: frozenset[str]) -> Program:
        """Registers: each value has one from where it is written to where it is last read."""
        first = len(VARIABLES)
        needed = set(results)
        for i in range(len(self.instructions) - 1, -1, -1):
            if first + i in needed:
                needed.update(self.instructions[i][1])
        last = dict.fromkeys(results, len(self.instructions))
        for i in range(len(self.instructions) - 1, -1, -1):
            if first + i in needed:
                for operand in self.instructions[i][1]:
                    last.setdefault(operand, i)
        place = {i: i for i in range(first)}
        free = list(range(REGISTERS - 1, first - 1, -1))
        codes, constants = [], []
        for i, (operation, operands, k, l) in enumerate(self.instructions):  # noqa: E741
            if first + i not in needed:
                continue
            read = [place[operand] for operand in operands]
            for operand in set(operands):
                if operand >= first and last[operand] == i:
                    free.append(place[operand])
            if not free:
                raise self.reader.refused(f"it needs more than {REGISTERS - first} values at once")
            place[first + i] = free.pop()
            a, b, c = (read + [0, 0, 0])[:3]
            codes.append((OPERATIONS[operation], place[first + i], a, b, c))
            constants.append((k, l))
        if not codes:  # N is a variable itself
            codes, constants = [(OPERATIONS["constant"], free[-1], 0, 0, 0)], [(0.0, 0.0)]
        a, b, c, d = (place[result] for result in results)
        return Program(tuple(codes), tuple(constants), (a, b, c, d), feature, names)
