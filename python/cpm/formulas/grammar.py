"""The grammar of formulas: numbers, names, + − * / **, calls, parentheses. Nothing else is understood.

    sum      = product {("+" | "-") product}
    product  = sign {("*" | "/") sign}
    sign     = ("+" | "-") sign | power
    power    = atom ["**" sign]                        right to left, binds tighter than a sign before it
    atom     = number | name | name "(" sum {"," sum} ")" | "(" sum ")"
"""
from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

MAX_CHARACTERS = 20_000
MAX_TOKENS = 4_000
MAX_DEPTH = 40
#: How much of a text a message quotes.
_SHOWN = 40

#: Functions and how many arguments they take (least, most).
FUNCTIONS = {name: (1, 1) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "sinh", "cosh", "tanh",
                                       "abs")} | {"atan2": (2, 2), "min": (2, 16), "max": (2, 16)}
#: What a formula is of; no constant may have such a name.
VARIABLES = ("x", "y", "z", "r", "wavelength")

_TOKEN = re.compile(r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[^\W\d]\w*)|(?P<sign>\*\*|[-+*/(),]))",
                    re.ASCII)


@dataclass(frozen=True)
class Number:
    value: float


@dataclass(frozen=True)
class Name:
    name: str
    place: int


@dataclass(frozen=True)
class Call:
    function: str
    arguments: tuple[Node, ...]


@dataclass(frozen=True)
class Sum:
    """±term ± term …"""

    terms: tuple[tuple[int, Node], ...]


@dataclass(frozen=True)
class Product:
    """factor * or / factor …: (1 or −1, factor)."""

    factors: tuple[tuple[int, Node], ...]


@dataclass(frozen=True)
class Power:
    base: Node
    exponent: Node


Node = Number | Name | Call | Sum | Product | Power


def shown(text: str) -> str:
    """A part of a formula as a message quotes it: one line, short."""
    safe = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text[:_SHOWN])
    return f"'{safe}{'...' if len(text) > _SHOWN else ''}'"


def parse(text: str) -> Node:
    """The tree of a formula; ValueError, in one line, where there is none."""
    if not isinstance(text, str):
        raise TypeError(f"text is {type(text).__name__}; a formula is a string")
    if len(text) > MAX_CHARACTERS:
        raise ValueError(f"the formula {shown(text)} has {len(text)} characters; at most {MAX_CHARACTERS} are allowed")
    parser = _Parser(unicodedata.normalize("NFKC", text))
    return parser.whole()


class _Parser:
    """Recursive descent over the tokens; its depth is bounded."""

    def __init__(self, text: str) -> None:
        self.text, self.next, self.depth = text, 0, 0
        self.tokens: list[tuple[str, str, int]] = []
        at, end = 0, len(text.rstrip())
        while at < end:
            match = _TOKEN.match(text, at) or _unicode_name(text, at)
            if match is None:
                place = at + len(text[at:]) - len(text[at:].lstrip())
                raise self.refused(f"{shown(text[place])} is not part of a formula", place)
            self.tokens.append((str(match.lastgroup), match[match.lastgroup or 0], match.start(match.lastgroup or 0)))
            if len(self.tokens) > MAX_TOKENS:
                raise ValueError(f"the formula {shown(text)} has more than {MAX_TOKENS} numbers, names and signs")
            at = match.end()
        self.tokens.append(("end", "", end))

    def refused(self, problem: str, place: int) -> ValueError:
        return ValueError(f"the formula {shown(self.text)}, character {place + 1}: {problem}")

    def take(self, *signs: str) -> str | None:
        kind, token, _ = self.tokens[self.next]
        if kind == "sign" and token in signs:
            self.next += 1
            return token
        return None

    def need(self, sign: str) -> None:
        if self.take(sign) is None:
            self.unexpected(f"'{sign}'")

    def unexpected(self, wanted: str) -> None:
        kind, token, place = self.tokens[self.next]
        found = "it ends" if kind == "end" else f"{shown(token)} stands"
        raise self.refused(f"{found} where {wanted} is needed", place)

    def deeper(self) -> None:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.refused(f"nested more than {MAX_DEPTH} deep", self.tokens[self.next][2])

    def whole(self) -> Node:
        node = self.sum()
        if self.tokens[self.next][0] != "end":
            self.unexpected("an operator")
        return node

    def sum(self) -> Node:
        self.deeper()
        terms = [(1, self.product())]
        while sign := self.take("+", "-"):
            terms.append((1 if sign == "+" else -1, self.product()))
        self.depth -= 1
        return terms[0][1] if len(terms) == 1 else Sum(tuple(terms))

    def product(self) -> Node:
        factors = [(1, self.sign())]
        while sign := self.take("*", "/"):
            factors.append((1 if sign == "*" else -1, self.sign()))
        return factors[0][1] if len(factors) == 1 else Product(tuple(factors))

    def sign(self) -> Node:
        sign = self.take("+", "-")
        if sign is None:
            return self.power()
        self.deeper()
        node = self.sign()
        self.depth -= 1
        return node if sign == "+" else Sum(((-1, node),))

    def power(self) -> Node:
        base = self.atom()
        if self.take("**") is None:
            return base
        self.deeper()
        exponent = self.sign()
        self.depth -= 1
        return Power(base, exponent)

    def atom(self) -> Node:
        kind, token, place = self.tokens[self.next]
        if kind == "number":
            self.next += 1
            value = float(token)
            if value == float("inf"):
                raise self.refused(f"{shown(token)} is too large for a number", place)
            return Number(value)
        if kind == "name":
            self.next += 1
            return self.call(token, place) if self.take("(") else Name(token, place)
        if self.take("("):
            node = self.sum()
            self.need(")")
            return node
        self.unexpected("a number, a name or '('")
        raise AssertionError

    def call(self, name: str, place: int) -> Node:
        if name not in FUNCTIONS:
            raise self.refused(f"unknown function {shown(name)} (allowed: {', '.join(FUNCTIONS)})", place)
        arguments = [self.sum()]
        while self.take(","):
            arguments.append(self.sum())
        self.need(")")
        least, most = FUNCTIONS[name]
        if not least <= len(arguments) <= most:
            needed = f"{least}" if least == most else f"{least} to {most}"
            raise self.refused(f"{name} has {len(arguments)} arguments; it takes {needed}", place)
        return Call(name, tuple(arguments))


_UNICODE_NAME = re.compile(r"\s*(?P<name>[^\W\d]\w*)")


def _unicode_name(text: str, at: int) -> re.Match[str] | None:
    """A name in letters beyond ASCII, as Python's own names may have."""
    match = _UNICODE_NAME.match(text, at)
    return match if match and match["name"].isidentifier() else None
