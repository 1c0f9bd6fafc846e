"""Writes random .gidl modules: types of every kind that can lie on the wire, from a seed.

Sizes stay small: every type has a weight, about how many scalars a random value of it holds, and a
member whose type would make its struct too heavy gets a lighter one.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

INTEGERS = {
    "int8": (-(1 << 7), (1 << 7) - 1), "uint8": (0, (1 << 8) - 1),
    "int16": (-(1 << 15), (1 << 15) - 1), "uint16": (0, (1 << 16) - 1),
    "int32": (-(1 << 31), (1 << 31) - 1), "uint32": (0, (1 << 32) - 1),
    "int64": (-(1 << 63), (1 << 63) - 1), "uint64": (0, (1 << 64) - 1),
}  # fmt: skip
FLOATING = ("float", "double")
SCALARS = ("boolean", "octet", "char", *INTEGERS, *FLOATING)
KEYS = ("string", "boolean", "char", "octet", *INTEGERS)

# Plain names, names that counts and sizes want, and words of C++, Python, LCM and of the output.
NAMES = (
    "x", "x_n", "x_n_", "x_size", "y", "y_n", "y_size", "value", "value_n", "entry", "item", "tag",
    "tag_", "size", "to", "_out", "source", "data", "class", "def", "self", "cls", "lambda", "this",
    "delete", "auto", "encode", "decode", "fingerprint", "type_name", "package", "byte", "int8_t",
    "pos", "buf", "offset", "maxlen", "tlen", "hash", "wire", "np", "begin", "end", "count",
    "from_", "std", "gecos", "index", "key", "none", "new", "temperature", "path", "a", "b", "n",
)  # fmt: skip

HEAVIEST_MEMBER = 24
HEAVIEST = 60


@dataclass(frozen=True)
class Known:
    """A type that was declared already."""

    name: str
    weight: float
    is_base: bool = False  # a final struct
    is_key: bool = False  # an enum


class Author:
    def __init__(self, dice: Random) -> None:
        self._dice = dice
        self._known: list[Known] = []
        self._lines: list[str] = []
        self._made = 0
        self._members_of: dict[str, set[str]] = {}

    def module(self, name: str, structs: int) -> str:
        """The text of a file with `structs` structs and the types that they need."""
        for _ in range(2):
            self._enum()
        self._bitmask()
        self._bitset()
        for _ in range(structs):
            chance = self._dice.random()
            if chance < 0.2:
                self._typedef()
            elif chance < 0.35:
                self._union()
            elif chance < 0.4:
                self._enum()
            elif chance < 0.45:
                self._bitmask()
            elif chance < 0.5:
                self._bitset()
            self._struct()
        body = "".join(f"  {line}\n" for line in self._lines)
        return f"#pragma once\n\nmodule {name} {{\n{body}}};\n"

    def _name(self, kind: str) -> str:
        self._made += 1
        return f"{kind}{self._made}"

    # -- declarations --------------------------------------------------------------------------

    def _enum(self) -> None:
        name = self._name("Kind")
        numbers = sorted(self._dice.sample(range(-(1 << 31), 1 << 31), 4))
        explicit = self._dice.random() < 0.5
        literals = [
            (f"@value({number}) " if explicit else "") + f"{name.upper()}_{letter}"
            for letter, number in zip("ABCD", numbers, strict=True)
        ]
        if self._dice.random() < 0.5:
            literals[2] = f"@default_literal {literals[2]}"
        self._lines.append(f"enum {name} {{ {', '.join(literals)} }};")
        self._known.append(Known(name, 1, is_key=True))

    def _bitmask(self) -> None:
        name = self._name("Mask")
        bits = self._dice.choice((5, 8, 12, 32, 33, 64))
        places = sorted({0, bits - 1, self._dice.randrange(bits)})
        flags = ", ".join(f"@position({at}) {name.upper()}_{at}" for at in places)
        self._lines.append(f"@bit_bound({bits}) bitmask {name} {{ {flags} }};")
        self._known.append(Known(name, 1))

    def _bitset(self) -> None:
        name = self._name("Bits")
        widths = [self._dice.randint(1, 13) for _ in range(self._dice.randint(1, 4))]
        typed = (", int16", "", "")
        fields = " ".join(
            f"bitfield<{width}{self._dice.choice(typed)}> f{i};" for i, width in enumerate(widths)
        )
        self._lines.append(f"bitset {name} {{ {fields} }};")
        self._known.append(Known(name, 1))

    def _typedef(self) -> None:
        name = self._name("Alias")
        used, weight = self._type(1)
        dimensions, factor = self._dimensions() if self._dice.random() < 0.5 else ("", 1)
        limits = "" if dimensions else self._range(used)
        self._lines.append(f"{limits}typedef {used} {name}{dimensions};")
        self._known.append(Known(name, weight * factor))

    def _union(self) -> None:
        name = self._name("Choice")
        labels: list[str]
        match self._dice.randrange(4):
            case 0:
                switch, labels = "boolean", ["TRUE", "FALSE"]
            case 1:
                enum = self._dice.choice([k.name for k in self._known if k.is_key])
                switch, labels = enum, [f"{enum.upper()}_{letter}" for letter in "ABC"]
            case 2:
                switch, labels = "char", ["'a'", "'z'", "'0'"]
            case _:
                switch = self._dice.choice(tuple(INTEGERS))
                low, high = INTEGERS[switch]
                labels = [str(high), str(low + 1 if low else 0), "7"]
        names = self._dice.sample(NAMES, len(labels) + 1)
        arms = []
        heaviest = 0.0
        for label, member in zip(labels, names, strict=False):
            used, weight = self._type(1)
            heaviest = max(heaviest, weight)
            arms.append(f"case {label}: {used} {member};")
        if switch != "boolean" and self._dice.random() < 0.5:
            arms.append(f"default: {self._type(0)[0]} {names[-1]};")
        grows = "@appendable " if self._dice.random() < 0.2 else ""
        self._lines.append(f"{grows}union {name} switch ({switch}) {{ {' '.join(arms)} }};")
        self._known.append(Known(name, 1 + heaviest))

    def _struct(self) -> None:
        name = self._name("Part")
        appendable = self._dice.random() < 0.2
        itself = f"{name}s" if self._dice.random() < 0.06 else ""
        if itself:
            self._lines += [f"struct {name};", f"typedef sequence<{name}, 2> {itself};"]
        bases = [k for k in self._known if k.is_base and k.weight < HEAVIEST / 2]
        base = self._dice.choice(bases) if bases and self._dice.random() < 0.15 else None
        taken = self._members_of[base.name] if base else set()
        weight = base.weight if base else 0.0
        members: list[str] = []
        names = [n for n in NAMES if n not in taken]
        names = self._dice.sample(names, self._dice.choice((0, 1, 1, 2, 3, 4, 5, 6, 8, 10)))
        for member in names:
            text, more = self._member(member, HEAVIEST - weight)
            weight += more
            members.append(text)
        if itself:
            members.append(f"{itself} below;")
        head = "@appendable struct" if appendable else "struct"
        after = f" : {base.name}" if base else ""
        self._lines.append(f"{head} {name}{after} {{")
        self._lines += [f"  {member}" for member in members]
        self._lines.append("};")
        self._members_of[name] = {*taken, *names}
        is_base = not appendable and not itself
        self._known.append(Known(name, 1 + weight * (3 if itself else 1), is_base))

    def _member(self, name: str, room: float) -> tuple[str, float]:
        optional = "@optional " if self._dice.random() < 0.2 else ""
        for _ in range(8):
            used, weight = self._type(2)
            dimensions, factor = self._dimensions() if self._dice.random() < 0.2 else ("", 1)
            if weight * factor <= min(room, HEAVIEST_MEMBER):
                limits = "" if dimensions else self._range(used)
                return f"{optional}{limits}{used} {name}{dimensions};", weight * factor
        return f"int32 {name};", 1

    # -- types ---------------------------------------------------------------------------------

    def _type(self, depth: int) -> tuple[str, float]:
        chance = self._dice.random()
        if chance < 0.4:
            return self._dice.choice(SCALARS), 1
        if chance < 0.5:
            return self._string(), 1
        if chance < 0.75 or depth == 0:
            known = self._dice.choice(self._known)
            return known.name, known.weight
        if chance < 0.93:
            element, weight = self._type(depth - 1)
            bound = f", {self._dice.randint(1, 9)}" if self._dice.random() < 0.3 else ""
            return f"sequence<{element}{bound}>", 1 + 2 * weight
        keys = [*KEYS, *(known.name for known in self._known if known.is_key)]
        value, weight = self._type(depth - 1)
        return f"map<{self._dice.choice(keys)}, {value}>", 1 + 2 * (1 + weight)

    def _string(self) -> str:
        return f"string<{self._dice.randint(1, 12)}>" if self._dice.random() < 0.3 else "string"

    def _dimensions(self) -> tuple[str, int]:
        sizes = [self._dice.randint(1, 4) for _ in range(self._dice.choice((1, 1, 2, 3)))]
        factor = 1
        for size in sizes:
            factor *= size
        return "".join(f"[{size}]" for size in sizes), factor

    def _range(self, used: str) -> str:
        if self._dice.random() < 0.7:
            return ""
        if used in FLOATING:
            return "@range(min=-1.5, max=1024.0) "
        if used in INTEGERS:
            low, high = INTEGERS[used]
            first, last = sorted(self._dice.randint(low, high) for _ in range(2))
            return f"@range(min={first}, max={last}) "
        return ""
