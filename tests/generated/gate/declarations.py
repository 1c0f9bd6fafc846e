"""The declarations of random files, but for interfaces."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from author import HEAVIEST, HEAVIEST_MEMBER, INTEGERS, Known, Number, Types, Used
from scope import Path, Scope, Scopes
from words import comment, comment_behind, written

INTEGER_TAGS = ("int8", "uint8", "short", "uint16", "long", "unsigned long", "int64",
                "unsigned long long", "octet")  # fmt: skip


class Declarations(Types):
    """Each method declares something in the scope `here` and gives its text."""

    def __init__(self, dice: Random, scopes: Scopes) -> None:
        super().__init__(dice, scopes)
        self.exceptions: list[Path] = []

    def any(self, here: Path) -> str:
        makers: tuple[tuple[float, Callable[[Path], str]], ...] = (
            (0.3, self.struct), (0.12, self.enum), (0.07, self.bitmask), (0.07, self.bitset),
            (0.16, self.union), (0.16, self.typedef), (0.07, self.constant), (0.05, self.exception),
        )  # fmt: skip
        chosen = self.dice.choices([m for _, m in makers], [w for w, _ in makers])[0]
        return comment(self.dice) + chosen(here)

    def fresh(self, here: Path, extra: str = "") -> str:
        return self.scopes.at(here).fresh(self.dice, extra)

    def add(self, known: Known) -> None:
        self.known.append(known)

    # -- enumerations --------------------------------------------------------------------------

    def enum(self, here: Path) -> str:
        name = self.fresh(here)
        count = self.dice.randint(1, 5)
        literals = [self.fresh(here) for _ in range(count)]
        numbers = sorted(self.dice.sample(range(-(1 << 31), 1 << 31), count))
        if self.once_in(2):
            numbers = sorted(self.dice.sample(range(-3, 130), count))
        explicit = self.once_in(2)
        default = self.dice.randrange(count) if self.once_in(2) else -1
        lines = [
            ("@default_literal " if i == default else "")
            + (f"@value({numbers[i]}) " if explicit else "")
            + written(literal)
            + ("," if i < count - 1 else "")
            + comment_behind(self.dice)
            for i, literal in enumerate(literals)
        ]
        self.add(Known((*here, name), 1, is_key=True, literals=tuple(literals)))
        body = "".join(f"  {line}\n" for line in lines)
        return f"enum {written(name)} {{\n{body}}};\n"

    def bitmask(self, here: Path) -> str:
        name = self.fresh(here)
        bits = self.dice.choice((8, 16, 31, 32, 33, 64))
        inside = Scope((*here, name))
        count = self.dice.randint(1, min(4, bits))
        flags = [
            f"@position({position}) {written(inside.fresh(self.dice))}"
            for position in self.dice.sample(range(bits), count)
        ]
        self.add(Known((*here, name), 1))
        return f"@bit_bound({bits}) bitmask {written(name)} {{ {', '.join(flags)} }};\n"

    def bitset(self, here: Path) -> str:
        bases = [known for known in self.known if known.bits and known.bits < 40]
        base = self.dice.choice(bases) if bases and self.once_in(3) else None
        above = self.named(base, here).text if base else ""
        name = self.fresh(here)
        inside = Scope((*here, name), {n.lower(): n for n in (base.fields if base else ())})
        room = (64 if self.once_in(3) else 31) - (base.bits if base else 0)
        fields: list[str] = []
        bits = base.bits if base else 0
        while room > 0 and len(fields) < 4:
            width = self.dice.randint(1, min(room, 12))
            if fields and self.once_in(5):
                fields.append(f"bitfield<{width}>;")
            else:
                kinds = [
                    k for k, (low, _) in INTEGERS.items() if _width(k) >= width and k != "octet"
                ]
                kind = f", {self.dice.choice(kinds)}" if self.once_in(2) else ""
                kind = ", boolean" if width == 1 and self.once_in(3) else kind
                fields.append(f"bitfield<{width}{kind}> {written(inside.fresh(self.dice))};")
            room -= width
            bits += width
        self.add(Known((*here, name), 1, bits=bits, fields=frozenset(inside.declared.values())))
        head = f"bitset {written(name)}" + (f" : {above}" if above else "")
        return f"{head} {{ {' '.join(fields)} }};\n"

    # -- structs -------------------------------------------------------------------------------

    def struct(self, here: Path) -> str:
        return self._members("struct", here)

    def exception(self, here: Path) -> str:
        return self._members("exception", here)

    def _members(self, kind: str, here: Path) -> str:
        appendable = self.once_in(4)
        bases = [k for k in self.known if k.members is not None and k.weight < HEAVIEST / 2]
        base = None
        if kind == "struct" and bases and self.once_in(5):
            base = self.dice.choice(bases)
        above = self.named(base, here).text if base else ""
        name = self.fresh(here)
        path = (*here, name)
        inside = Scope(path, {n: n for n in (base.members or ())} if base else {})
        head, itself = "", ""
        if kind == "struct" and self.once_in(12):
            itself = self.fresh(here)
            head = f"struct {written(name)};\n"
            head += f"typedef sequence<{written(name)}, 2> {written(itself)};\n"
            inside.used |= {name.lower(), itself.lower()}
        weight = base.weight if base else 0.0
        lines = []
        for _ in range(self.dice.choice((0, 1, 1, 2, 2, 3, 3, 4, 5, 6))):
            line, more = self._member(here, inside, HEAVIEST - weight)
            lines.append(line)
            weight += more
        if itself:
            lines.append(f"{written(itself)} {written(inside.fresh(self.dice))};")
        extent = "@appendable " if appendable else self.dice.choice(("", "@final "))
        if kind == "struct":
            is_base = not appendable and not itself
            members = frozenset(n.lower() for n in inside.declared) if is_base else None
            self.add(Known(path, 1 + weight * (3 if itself else 1), members=members))
        else:
            self.exceptions.append(path)
        body = "".join(f"  {line}\n" for line in lines)
        after = f" : {above}" if above else ""
        return f"{head}{extent}{kind} {written(name)}{after} {{\n{body}}};\n"

    def _member(self, here: Path, inside: Scope, room: float) -> tuple[str, float]:
        for _ in range(8):
            used = self.use(here, 2, inside)
            sizes, factor = self.dimensions() if self.once_in(5) else ("", 1)
            if used.weight * factor <= min(room, HEAVIEST_MEMBER):
                break
        else:
            used, sizes, factor = Used("long", 1, Number("long"), True), "", 1
        before = self.marks(used, sizes)
        name = written(inside.fresh(self.dice))
        behind = comment_behind(self.dice)
        return (
            f"{comment(self.dice)}{before}{used.text} {name}{sizes};{behind}",
            used.weight * factor,
        )

    def marks(self, used: Used, sizes: str = "", may_default: bool = True) -> str:
        """Annotations of a member: a range, of the elements where they are numbers; a secret."""
        limits, number = self.limits(used.number)
        text = limits
        if used.is_string and not sizes and self.once_in(3):
            text += "@secret "
        if used.is_bulk and not sizes and self.once_in(8):
            text += "@bulk "
        if self.once_in(5):
            return text + "@optional "
        if may_default and used.is_scalar and not sizes and number and self.once_in(4):
            return text + f"@default({self.literal(number)}) "
        return text

    # -- unions --------------------------------------------------------------------------------

    def union(self, here: Path) -> str:
        switch, labels = self._switch(here)
        name = self.fresh(here)
        inside = Scope((*here, name))
        inside.used |= {part.removeprefix("_").lower() for part in switch.split("::")[:1]}
        inside.used |= {label.split("::")[0].removeprefix("_").lower() for label in labels}
        self.dice.shuffle(labels)
        used = labels[: self.dice.randint(0, min(len(labels), 4))]
        cases, heaviest = [], 0.0
        while used:
            count = 2 if len(used) > 1 and self.once_in(4) else 1
            line, weight = self._arm(here, inside)
            cases.append("".join(f"case {label}: " for label in used[:count]) + line)
            heaviest = max(heaviest, weight)
            used = used[count:]
        named = sum(line.count("case ") for line in cases)
        if not cases or (self.once_in(2) and len(labels) > named):
            line, weight = self._arm(here, inside)
            cases.append(f"default: {line}")
            heaviest = max(heaviest, weight)
            self.dice.shuffle(cases)
        extent = self.dice.choice(("", "@final ", "@appendable "))
        self.add(Known((*here, name), 1 + heaviest))
        body = "".join(f"  {line}\n" for line in cases)
        return f"{extent}union {written(name)} switch ({switch}) {{\n{body}}};\n"

    def _arm(self, here: Path, inside: Scope) -> tuple[str, float]:
        for _ in range(8):
            used = self.use(here, 1, inside)
            if used.weight <= HEAVIEST_MEMBER:
                break
        else:
            used = Used("double", 1, Number("double"), True)
        limits, _ = self.limits(used.number)
        secret = "@secret " if used.is_string and self.once_in(2) else ""
        return f"{limits}{secret}{used.text} {written(inside.fresh(self.dice))};", used.weight

    def _switch(self, here: Path) -> tuple[str, list[str]]:
        chance = self.dice.random()
        enums = [known for known in self.known if known.literals]
        if chance < 0.35 and enums:
            enum = self.dice.choice(enums)
            text = self.named(enum, here).text
            around = enum.path[:-1]
            labels = [
                self.scopes.written(self.dice, (*around, each), here) for each in enum.literals
            ]
            return text, labels
        if chance < 0.5:
            return "boolean", ["TRUE", "FALSE"]
        if chance < 0.7:
            letters = [r"'\xff'", "'a'", r"'\n'", r"'\x80'", "'~'", r"'\''", r"'\\'", "'\"'", "' '"]
            return "char", letters
        kind = self.dice.choice(INTEGER_TAGS)
        low, high = INTEGERS[kind]
        numbers = {low, high, 0, 1, low + 1, high - 1, self.dice.randint(low, high)}
        numbers.discard(-(1 << 63))
        return kind, [str(number) for number in sorted(numbers)]

    # -- names for types and values ------------------------------------------------------------

    def typedef(self, here: Path) -> str:
        used = self.use(here, 2)
        sizes, factor = self.dimensions() if self.once_in(3) else ("", 1)
        if used.weight * factor > HEAVIEST_MEMBER:
            used, sizes, factor = Used("float", 1, Number("float"), True), "[2]", 2
        limits, number = self.limits(used.number, 1.5)
        name = self.fresh(here)
        scalar = used.is_scalar and not sizes
        whole = scalar and number is not None and number.kind in INTEGERS
        self.add(
            Known((*here, name), used.weight * factor, number, scalar,
                  used.is_string and not sizes, is_key=whole)
        )  # fmt: skip
        return f"{limits}typedef {used.text} {written(name)}{sizes};\n"

    def constant(self, here: Path) -> str:
        enums = [known for known in self.known if known.literals]
        if self.once_in(3):
            name = self.fresh(here)
            size = self.dice.randint(1, 5)
            self.constants.append(((*here, name), size))
            return f"const long {written(name)} = {size};\n"
        if enums and self.once_in(4):
            enum = self.dice.choice(enums)
            text = self.named(enum, here).text
            literal = (*enum.path[:-1], self.dice.choice(enum.literals))
            value = self.scopes.written(self.dice, literal, here)
            return f"const {text} {written(self.fresh(here))} = {value};\n"
        kind, value = self.dice.choice(CONSTANTS)
        return f"const {kind} {written(self.fresh(here))} = {value};\n"


CONSTANTS = (
    ("boolean", "TRUE"), ("char", r"'\xff'"), ("char", "'\"'"),
    ("char", r"'\\'"), ("string", r'"quo\"tes \\ and \t tabs"'), ("string<8>", '"???/"'),
    ("string", '"Gr\\u00fc\\u00dfe"'), ("octet", "255"), ("int8", "-128"), ("short", "-32768"),
    ("unsigned long", "~0"), ("int64", "-9223372036854775807 - 1"),
    ("unsigned long long", "18446744073709551615"), ("float", "1.5e-3"), ("double", "1e308"),
    ("double", "-0.1"), ("float", "3.4028234663852886e38"),
)  # fmt: skip


def _width(kind: str) -> int:
    low, high = INTEGERS[kind]
    return (high - low).bit_length()
