"""Random interfaces, and random edits of them."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field
from random import Random

_DEFAULTS = {"long": "7", "double": "2.5", "string": '"d"', "boolean": "TRUE"}
_MODES = ("required", "required", "default", "optional")
_PLAIN = ("long", "short", "double", "string", "boolean")
_KINDS = (
    *_PLAIN, "Gear", "Inner", "Pick", "sequence<long>", "sequence<Inner>", "map<long, Gear>",
    "map<Gear, long>",
)  # fmt: skip
_RANGES = ((0.0, 10.0), (2.0, 20.0))  # of doubles; the default lies in both


@dataclass
class Slot:
    """A member or a parameter."""

    name: str
    type: str  # one of _KINDS, or Goal
    mode: str = "required"
    range: tuple[float, float] | None = None  # of a double
    unit: str = ""  # likewise

    def text(self, end: str, before: str = "") -> str:
        head = {"required": "", "optional": "@optional "}.get(
            self.mode, f"@default({_DEFAULTS.get(self.type, '')}) "
        )
        if self.type == "double":
            head += f"@range(min={self.range[0]}, max={self.range[1]}) " if self.range else ""
            head += f'@unit("{self.unit}") ' if self.unit else ""
        return f"{head}{before}{self.type} {self.name}{end}"

    def default(self) -> object:
        if self.mode == "optional":
            return None
        return {"long": 7, "double": 2.5, "string": "d", "boolean": True}[self.type]


@dataclass
class Lab:
    """An interface of one operation and one attribute, and the types that they use."""

    members: list[Slot] = field(default_factory=list)
    parameters: list[Slot] = field(default_factory=list)
    literals: dict[str, int] = field(default_factory=lambda: {"L0": 0})
    default_literal: str | None = None
    appendable: bool = True  # Goal; Inner and Refused always are
    inner: list[Slot] = field(default_factory=lambda: [Slot("deep", "long")])
    evidence: list[Slot] = field(default_factory=lambda: [Slot("why", "string")])
    arms: dict[int, str] = field(default_factory=lambda: {0: "long"})  # type by label, of Pick
    raises: list[str] = field(default_factory=lambda: ["Refused"])
    others: list[str] = field(default_factory=list)

    @property
    def whole(self) -> list[Slot]:
        """All members of Goal: the first use every type, so that every edit of one matters."""
        always = (Slot("at", "Gear"), Slot("all", "sequence<Inner>"), Slot("one", "Pick"))
        return [*always, *self.members]

    def slots(self, struct: str) -> list[Slot]:
        return {"Goal": self.whole, "Inner": self.inner, "Refused": self.evidence}[struct]

    def text(self) -> str:
        words = ", ".join(
            ("@default_literal " if name == self.default_literal else "") + f"@value({n}) {name}"
            for name, n in self.literals.items()
        )
        kind = "@appendable" if self.appendable else "@final"
        arms = " ".join(f"case {at}: {type_} arm{at};" for at, type_ in self.arms.items())
        members, inner, evidence = (
            " ".join(slot.text(";") for slot in self.slots(struct))
            for struct in ("Goal", "Inner", "Refused")
        )
        parameters = ", ".join(p.text("", "in ") for p in self.parameters)
        others = " ".join(f"@sensor void {name}();" for name in self.others)
        return (
            f"module lab {{ enum Gear {{ {words} }};\n"
            f"@appendable struct Inner {{ {inner} }};\n"
            f"union Pick switch (long) {{ {arms} }};\n"
            f"{kind} struct Goal {{ {members} }};\n"
            f"@appendable exception Refused {{ {evidence} }}; exception Broken {{ long part; }};\n"
            f"interface Cart {{ @sensor readonly attribute Goal place;\n"
            f"@sensor Goal go({parameters}) raises ({', '.join(self.raises)});\n{others} }}; }};\n"
        )


def random_lab(random: Random) -> Lab:
    def slots(prefix: str, least: int) -> list[Slot]:
        count = random.randint(least, 4)
        made = [Slot(f"{prefix}{i}", random.choice(_KINDS)) for i in range(count)]
        for slot in made:
            slot.mode = _mode(random, slot.type)
            slot.range = random.choice((None, *_RANGES))
        return made

    literals = {f"L{i}": i for i in range(random.randint(2, 4))}
    default = random.choice([None, *literals])
    lab = Lab(slots("m", 1), [Slot("to", "Goal"), *slots("p", 0)], literals, default)
    lab.appendable = random.random() < 0.75
    lab.arms = {at: random.choice(("long", "string")) for at in range(random.randint(1, 3))}
    lab.inner.append(Slot("more", "double", _mode(random, "double")))
    return lab


def _mode(random: Random, type_: str) -> str:
    mode = random.choice(_MODES)
    return "required" if mode == "default" and type_ not in _DEFAULTS else mode


# ---------------------------------------------------------------------------------------------
# Edits


def edited(lab: Lab, random: Random) -> tuple[Lab, str]:
    """A copy with one to three edits, and what they were called."""
    new = deepcopy(lab)
    names = []
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        edit = random.choice(EDITS)
        edit(new, random)
        names.append(edit.__name__)
    return new, " and ".join(names)


def _slots(lab: Lab, random: Random) -> list[Slot]:
    return random.choice((lab.members, lab.parameters, lab.inner, lab.evidence))


def _slot(lab: Lab, random: Random) -> Slot:
    return random.choice(_slots(lab, random))


def _new_slot(random: Random, modes: tuple[str, ...] = _MODES) -> Slot:
    type_ = random.choice(list(_DEFAULTS))
    return Slot(f"n{random.randrange(10**6)}", type_, random.choice(modes))


def append(lab: Lab, random: Random) -> None:
    _slots(lab, random).append(_new_slot(random))


def append_what_may_be_missing(lab: Lab, random: Random) -> None:
    _slots(lab, random).append(_new_slot(random, ("default", "optional")))


def insert(lab: Lab, random: Random) -> None:
    slots = _slots(lab, random)
    slots.insert(random.randint(0, len(slots)), _new_slot(random))


def remove(lab: Lab, random: Random) -> None:
    slots = _slots(lab, random)
    if len(slots) > 1:
        slots.pop(random.randrange(len(slots)))


def remove_last(lab: Lab, random: Random) -> None:
    slots = _slots(lab, random)
    if len(slots) > 1:
        slots.pop()


def swap(lab: Lab, random: Random) -> None:
    random.shuffle(_slots(lab, random))


def retype(lab: Lab, random: Random) -> None:
    slot = _slot(lab, random)
    if slot.type != "Goal":
        slot.type = random.choice(_PLAIN)
        if slot.mode == "default" and slot.type not in _DEFAULTS:
            slot.mode = "required"


def remode(lab: Lab, random: Random) -> None:
    slot = _slot(lab, random)
    slot.mode = _mode(random, slot.type)


def rename(lab: Lab, random: Random) -> None:
    _slot(lab, random).name = f"r{random.randrange(10**6)}"


def _number(lab: Lab, random: Random) -> Slot:
    slots = (*lab.members, *lab.parameters, *lab.inner, *lab.evidence)
    return random.choice([slot for slot in slots if slot.type == "double"] or slots)


def other_range(lab: Lab, random: Random) -> None:
    _number(lab, random).range = random.choice((None, *_RANGES))


def other_unit(lab: Lab, random: Random) -> None:
    _number(lab, random).unit = random.choice(("m", "rad"))


def extensibility(lab: Lab, random: Random) -> None:
    lab.appendable = not lab.appendable


def add_literal(lab: Lab, random: Random) -> None:
    lab.literals[f"N{random.randrange(10**6)}"] = max(lab.literals.values()) + 1


def remove_literal(lab: Lab, random: Random) -> None:
    name = random.choice(list(lab.literals))
    if len(lab.literals) > 1 and name != lab.default_literal:
        del lab.literals[name]


def renumber(lab: Lab, random: Random) -> None:
    numbers = list(lab.literals.values())
    random.shuffle(numbers)
    lab.literals = dict(zip(lab.literals, numbers, strict=True))


def rename_literal(lab: Lab, random: Random) -> None:
    old = random.choice(list(lab.literals))
    name = f"R{random.randrange(10**6)}"
    lab.literals = {name if n == old else n: number for n, number in lab.literals.items()}
    lab.default_literal = name if lab.default_literal == old else lab.default_literal


def other_default_literal(lab: Lab, random: Random) -> None:
    lab.default_literal = random.choice([None, *lab.literals])


def add_arm(lab: Lab, random: Random) -> None:
    lab.arms[max(lab.arms) + 1] = random.choice(("long", "string"))


def retype_arm(lab: Lab, random: Random) -> None:
    lab.arms[random.choice(list(lab.arms))] = random.choice(("long", "string"))


def raise_more(lab: Lab, random: Random) -> None:
    lab.raises = ["Refused", "Broken"]


def add_operation(lab: Lab, random: Random) -> None:
    lab.others.append(f"more{random.randrange(10**6)}")


EDITS: tuple[Callable[[Lab, Random], None], ...] = (
    append, append_what_may_be_missing, append_what_may_be_missing, append_what_may_be_missing,
    insert, remove, remove_last, swap, retype, remode, rename, other_range, other_unit,
    extensibility, add_literal, add_literal, remove_literal, renumber, rename_literal,
    other_default_literal, add_arm, retype_arm, raise_more, add_operation, add_operation,
)  # fmt: skip
