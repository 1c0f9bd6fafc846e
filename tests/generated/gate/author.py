"""Writes random valid .gidl files: every kind of declaration, with hard names, ranges and secrets
in every position. Everything follows from the dice.

Every type has a weight, about how many scalars a value of it holds, so that values stay small.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random

from scope import Path, Scope, Scopes

INTEGERS = {
    "int8": (-(1 << 7), (1 << 7) - 1), "uint8": (0, (1 << 8) - 1), "octet": (0, (1 << 8) - 1),
    "short": (-(1 << 15), (1 << 15) - 1), "uint16": (0, (1 << 16) - 1),
    "long": (-(1 << 31), (1 << 31) - 1), "unsigned long": (0, (1 << 32) - 1),
    "int64": (-(1 << 63), (1 << 63) - 1), "unsigned long long": (0, (1 << 64) - 1),
}  # fmt: skip
FLOATING = ("float", "double")
HEAVIEST_MEMBER, HEAVIEST = 16, 40


@dataclass(frozen=True)
class Number:
    """What a range on a type speaks of: the kind of the number, and the range it has already."""

    kind: str
    low: float | int | None = None
    high: float | int | None = None


@dataclass(frozen=True)
class Used:
    """A type as it may be used."""

    text: str
    weight: float
    number: Number | None = None
    is_scalar: bool = False  # a number itself, not an array or sequence of them
    is_string: bool = False
    is_bulk: bool = False


@dataclass(frozen=True)
class Known:
    """A type that was declared."""

    path: Path
    weight: float
    number: Number | None = None
    is_scalar: bool = False
    is_string: bool = False
    is_key: bool = False
    members: frozenset[str] | None = None  # members of a final struct, which may be a base
    literals: tuple[str, ...] = ()  # enumerators of an enum
    bits: int = 0  # width of a bitset, which may be a base
    fields: frozenset[str] = frozenset()


class Types:
    """Uses of types: their text at a place, with or without a range of its own."""

    def __init__(self, dice: Random, scopes: Scopes) -> None:
        self.dice = dice
        self.scopes = scopes
        self.known: list[Known] = []
        self.constants: list[tuple[Path, int]] = []  # small and positive: sizes
        self.interfaces: list[Path] = []

    def once_in(self, chances: float) -> bool:
        return self.dice.random() < 1 / chances

    def use(self, here: Path, depth: int, *more: Scope) -> Used:
        chance = self.dice.random()
        if chance < 0.3:
            kind = self.dice.choice((*INTEGERS, *FLOATING, *FLOATING))
            return Used(kind, 1, Number(kind), True)
        if chance < 0.36:
            return Used(self.dice.choice(("boolean", "char")), 1)
        if chance < 0.44:
            bound = f"<{self.size(here, 12, *more)}>" if self.once_in(2) else ""
            return Used(f"string{bound}", 1, is_string=True)
        if (chance < 0.72 or depth == 0) and self.known:
            return self.named(self.dice.choice(self.known), here, *more)
        if chance < 0.75 and self.interfaces:
            path = self.dice.choice(self.interfaces)
            return Used(self.scopes.written(self.dice, path, here, *more), 2)
        if depth == 0:
            return Used("double", 1, Number("double"), True)
        inner = self.use(here, depth - 1, *more)
        if chance < 0.92:
            bound = f", {self.size(here, 6, *more)}" if self.once_in(3) else ""
            kind = inner.text.split()[-1]
            bulk = inner.is_scalar and kind in (*INTEGERS, *FLOATING)
            return Used(f"sequence<{inner.text}{bound}>", 1 + 2 * inner.weight, inner.number,
                        is_bulk=bulk)  # fmt: skip
        bound = f", {self.size(here, 4, *more)}" if self.once_in(4) else ""
        return Used(
            f"map<{self.key(here, *more)}, {inner.text}{bound}>", 1 + 2 * (1 + inner.weight)
        )

    def named(self, known: Known, here: Path, *more: Scope) -> Used:
        text = self.scopes.written(self.dice, known.path, here, *more)
        return Used(text, known.weight, known.number, known.is_scalar, known.is_string)

    def key(self, here: Path, *more: Scope) -> str:
        keys = [known for known in self.known if known.is_key]
        if keys and self.once_in(2):
            return self.named(self.dice.choice(keys), here, *more).text
        return self.dice.choice(("string", "string<5>", "boolean", "char", *INTEGERS))

    def size(self, here: Path, most: int, *more: Scope) -> str:
        fitting = [path for path, size in self.constants if size <= most]
        if fitting and self.once_in(3):
            return self.scopes.written(self.dice, self.dice.choice(fitting), here, *more)
        return str(self.dice.randint(1, most))

    def dimensions(self) -> tuple[str, int]:
        sizes = [self.dice.randint(1, 3) for _ in range(self.dice.choice((1, 1, 2, 3)))]
        factor = 1
        for size in sizes:
            factor *= size
        return "".join(f"[{size}]" for size in sizes), factor

    def limits(self, number: Number | None, one_in: float = 2.5) -> tuple[str, Number | None]:
        """@range, @min or @max, within what the number has already; a unit, too."""
        if number is None:
            return "", None
        unit = self.dice.choice(("m/s", "rad", "mm", "1"))
        text = f'@unit("{unit}") ' if self.once_in(6) else ""
        if not self.once_in(one_in):
            return text, number
        low, high = self._between(number)
        form = self.dice.randrange(4)
        if form == 0:
            text += f"@min({_literal(low, number.kind)}) "
            return text, replace(number, low=low)
        if form == 1:
            text += f"@max({_literal(high, number.kind)}) "
            return text, replace(number, high=high)
        first, last = _literal(low, number.kind), _literal(high, number.kind)
        if form == 2:
            text += f"@range(min={first}, max={last}) "
        else:
            text += f"@min({first}) @max({last}) "
        return text, replace(number, low=low, high=high)

    def _between(self, number: Number) -> tuple[float | int, float | int]:
        if number.kind in FLOATING:
            low = -3.0 if number.low is None else float(number.low)
            high = max(low, 4.0) if number.high is None else float(number.high)
            if number.high is not None:
                low = min(low, high)
            choices = [low, high, low + (high - low) / 4, low + (high - low) * 0.1,
                       low + (high - low) / 3]  # fmt: skip
            first, last = sorted(self.dice.choice(choices) for _ in range(2))
            return first, last
        least, most = INTEGERS[number.kind]
        low = int(least if number.low is None else number.low)
        high = int(most if number.high is None else number.high)
        if self.once_in(2):
            low, high = max(low, min(-5, high)), min(high, max(100, low))
        first, last = sorted(
            self.dice.choice((low, high, self.dice.randint(low, high))) for _ in range(2)
        )
        return first, last

    def literal(self, number: Number) -> str:
        """A number that the type allows."""
        if number.kind in FLOATING:
            low = number.low if number.low is not None else (number.high or 0.0)
            return _literal(float(low), number.kind)
        least, most = INTEGERS[number.kind]
        low = int(least if number.low is None else number.low)
        high = int(most if number.high is None else number.high)
        return str(min(max(self.dice.randint(-3, 3), low), high))


def _literal(value: float | int, kind: str) -> str:
    if kind in FLOATING:
        return repr(float(value))
    if value == -(1 << 63):
        return "-9223372036854775807 - 1"
    return str(int(value))
