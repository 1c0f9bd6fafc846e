"""Random interfaces, random edits of them, and generated Python of both that really talks."""

from __future__ import annotations

import sys
import types
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from gecos.wire import DecodeError, Decoder
from gidl import hashes, wire_layout
from gidl.breaking import category_of, compare
from gidl.compile import Compiled, compile_files
from gidl.emit import render
from gidl.model import Model, Operation

ROUNDS = 12  # values that each side sends the other
_DEFAULTS = {"long": "7", "double": "2.5", "string": '"d"', "boolean": "TRUE"}
_MODES = ("required", "required", "default", "optional")


@dataclass
class Slot:
    name: str
    type: str  # long, short, double, string, boolean, Gear, Inner or sequence<long>
    mode: str = "required"

    def text(self, end: str, before: str = "") -> str:
        head = {"required": "", "optional": "@optional "}.get(
            self.mode, f"@default({_DEFAULTS.get(self.type, '')}) "
        )
        return f"{head}{before}{self.type} {self.name}{end}"

    def default(self) -> object:
        if self.mode == "optional":
            return None
        return {"long": 7, "double": 2.5, "string": "d", "boolean": True}[self.type]


@dataclass
class Lab:
    """An interface of one operation, its struct, and its enum."""

    members: list[Slot] = field(default_factory=list)
    parameters: list[Slot] = field(default_factory=list)
    literals: dict[str, int] = field(default_factory=dict)
    default_literal: str | None = None
    appendable: bool = True
    others: list[str] = field(default_factory=list)
    bound: int | None = None

    @property
    def whole(self) -> list[Slot]:
        """All members: the first uses the enum, so that every edit of it matters."""
        return [Slot("always", "Gear"), *self.members]

    def text(self) -> str:
        words = ", ".join(
            ("@default_literal " if name == self.default_literal else "") + f"@value({n}) {name}"
            for name, n in self.literals.items()
        )
        kind = "@appendable" if self.appendable else "@final"
        members = " ".join(m.text(";") for m in self.whole)
        parameters = ", ".join(p.text("", "in ") for p in self.parameters)
        others = " ".join(f"@sensor void {name}();" for name in self.others)
        return (
            f"module lab {{ enum Gear {{ {words} }};\n"
            f"@appendable struct Inner {{ long deep; }};\n"
            f"{kind} struct Goal {{ {members} }};\n"
            f"interface Cart {{ @sensor Goal go({parameters}); {others} }}; }};\n"
        )


def random_lab(random: Random) -> Lab:
    kinds = ["long", "short", "double", "string", "boolean", "Gear", "Inner", "sequence<long>"]

    def slots(prefix: str, least: int) -> list[Slot]:
        made = [Slot(f"{prefix}{i}", random.choice(kinds)) for i in range(random.randint(least, 4))]
        for slot in made:
            slot.mode = _mode(random, slot.type)
        return made

    literals = {f"L{i}": i for i in range(random.randint(2, 4))}
    default = random.choice([None, *literals])
    parameters = [Slot("to", "Goal"), *slots("p", 0)]
    return Lab(slots("m", 1), parameters, literals, default, random.random() < 0.75)


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
        edit = random.choice(_EDITS)
        edit(new, random)
        names.append(edit.__name__)
    return new, " and ".join(names)


def _slots(lab: Lab, random: Random) -> list[Slot]:
    return random.choice((lab.members, lab.parameters))


def _new_slot(random: Random) -> Slot:
    type_ = random.choice(["long", "double", "string", "boolean", "Gear"])
    return Slot(f"n{random.randrange(10**6)}", type_, _mode(random, type_))


def append(lab: Lab, random: Random) -> None:
    _slots(lab, random).append(_new_slot(random))


def append_what_may_be_missing(lab: Lab, random: Random) -> None:
    type_ = random.choice(list(_DEFAULTS))
    mode = random.choice(("default", "optional"))
    _slots(lab, random).append(Slot(f"n{random.randrange(10**6)}", type_, mode))


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
    slot = random.choice(_slots(lab, random))
    if slot.type != "Goal":
        slot.type = random.choice(["long", "short", "double", "string", "boolean"])
        if slot.mode == "default" and slot.type not in _DEFAULTS:
            slot.mode = "required"


def remode(lab: Lab, random: Random) -> None:
    slot = random.choice(_slots(lab, random))
    slot.mode = _mode(random, slot.type)


def rename(lab: Lab, random: Random) -> None:
    random.choice(_slots(lab, random)).name = f"r{random.randrange(10**6)}"


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


def add_operation(lab: Lab, random: Random) -> None:
    lab.others.append(f"more{random.randrange(10**6)}")


_EDITS = (
    append, append_what_may_be_missing, append_what_may_be_missing, insert, remove, remove_last,
    swap, retype, remode, rename, extensibility, add_literal, add_literal, remove_literal,
    renumber, rename_literal, other_default_literal, add_operation,
)  # fmt: skip


# ---------------------------------------------------------------------------------------------
# Both sides at work


class Side:
    """Generated Python of one version, loaded."""

    def __init__(self, lab: Lab, folder: Path, name: str) -> None:
        place = folder / name / "lab.gidl"
        place.parent.mkdir(exist_ok=True)
        place.write_text(lab.text())
        self.lab = lab
        self.compiled: Compiled = compile_files([str(place)], [str(place.parent)])
        assert not self.compiled.has_errors, (lab.text(), self.compiled.findings)
        texts = render(self.model, wire_layout.build(self.model), ["python"])
        self.types = _load(f"{name}_types", texts["python/lab_types.py"])
        code = texts["python/lab.py"].replace("from lab_types import", f"from {name}_types import")
        self.module = _load(name, code)

    @property
    def model(self) -> Model:
        return self.compiled.model

    @property
    def operation(self) -> Operation:
        return next(m for m in self.model.interface("lab::Cart").operations if m.name == "go")

    def request(self, values: dict[str, object]) -> bytes:
        """What a client of this version sends."""
        sent: list[bytes] = []
        proxy_type = type(
            "Proxy",
            (self.module.Cart,),
            {
                "__init__": lambda _: None,
                "_gecos_call": lambda _, __, out: sent.append(b"".join(out)),
            },
        )
        proxy_type().go(**{k: self.made(k, v) for k, v in values.items()})
        return sent[0]

    def arguments(self, body: bytes) -> dict[str, object]:
        """What a server of this version reads from it."""
        (handler,) = (
            h for h in self.module.CartServant._gecos_handlers.values() if h.method == "go"
        )
        return dict(
            zip(
                (p.name for p in self.lab.parameters), handler.arguments(Decoder(body)), strict=True
            )
        )

    def reply(self, goal: dict[str, object]) -> bytes:
        (handler,) = (
            h for h in self.module.CartServant._gecos_handlers.values() if h.method == "go"
        )
        return b"".join(handler.result(self.goal(goal)))

    def result(self, body: bytes) -> dict[str, object]:
        methods: list[Any] = []
        proxy_type = type(
            "Proxy",
            (self.module.Cart,),
            {"__init__": lambda _: None, "_gecos_call": lambda _, how, __: methods.append(how)},
        )
        values = random_values(self.lab.parameters, self.lab, Random(1))
        proxy_type().go(**{k: self.made(k, v) for k, v in values.items()})
        return self.plain(methods[0].result(Decoder(body)))

    def goal(self, values: dict[str, object]) -> object:
        return self.types.Goal(**{k: self.made(k, v) for k, v in values.items()})

    def made(self, name: str, value: object) -> object:
        if isinstance(value, dict):
            return self.types.Inner(**value) if "deep" in value else self.goal(value)
        if isinstance(value, Literal):
            return self.types.Gear[value.name]
        return value

    def plain(self, value: Any) -> Any:
        """Without classes of this version."""
        if type(value).__name__ == "Goal":
            return {m.name: self.plain(getattr(value, m.name)) for m in self.lab.whole}
        if type(value).__name__ == "Inner":
            return {"deep": value.deep}
        if type(value).__name__ == "Gear":
            return Literal(value.name)
        return value.tolist() if hasattr(value, "tolist") else value


@dataclass(frozen=True)
class Literal:
    name: str


def _load(name: str, code: str) -> types.ModuleType:
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(code, f"{name}.py", "exec"), module.__dict__)
    return module


def random_values(slots: list[Slot], lab: Lab, random: Random) -> dict[str, object]:
    return {
        s.name: None
        if s.mode == "optional" and random.random() < 0.25
        else _random_value(s.type, lab, random)
        for s in slots
    }


def _random_value(type_: str, lab: Lab, random: Random) -> object:
    match type_:
        case "Goal":
            return random_values(lab.whole, lab, random)
        case "Inner":
            return {"deep": random.randint(1000, 30_000)}
        case "Gear":
            return Literal(random.choice(list(lab.literals)))
        case "sequence<long>":
            return [random.randint(1000, 30_000) for _ in range(random.randint(1, 3))]
        case "string":
            return "".join(random.choices("abcäöü ", k=random.randint(1, 9)))
        case "boolean":
            return random.random() < 0.5
        case "double":
            return random.uniform(1.0, 9.0)
        case _:
            return random.randint(1000, 30_000)


class LostError(Exception):
    """The receiver cannot know what was meant."""


def understood(
    sent: dict[str, object], senders: list[Slot], receivers: list[Slot], lab: Lab
) -> dict[str, object]:
    """What a receiver with these slots has to read when its sender says `sent`."""
    modes = {s.name: s for s in senders}
    read: dict[str, object] = {}
    for slot in receivers:
        if slot.name not in modes:
            if slot.mode == "required":
                raise LostError(slot.name)
            read[slot.name] = slot.default()
            continue
        value = sent[slot.name]
        if isinstance(value, Literal) and value.name not in lab.literals:
            if lab.default_literal is None:
                raise LostError(value.name)
            value = Literal(lab.default_literal)
        read[slot.name] = value
    return read


def understand_each_other(old: Side, new: Side, random: Random) -> bool:
    """Whether the hashes agree and each reads, in requests and replies, what the other says."""
    if hashes.operation_hash(old.model, old.operation) != hashes.operation_hash(
        new.model, new.operation
    ):
        return False
    return all(
        _understands(sender, receiver, random)
        for sender, receiver in ((old, new), (new, old))
        for _ in range(ROUNDS)
    )


def _understands(sender: Side, receiver: Side, random: Random) -> bool:
    said = random_values(sender.lab.parameters, sender.lab, random)
    goal = random_values(sender.lab.whole, sender.lab, random)
    try:
        wanted = understood(said, sender.lab.parameters, receiver.lab.parameters, receiver.lab)
        whole = understood(goal, sender.lab.whole, receiver.lab.whole, receiver.lab)
        for name, value in wanted.items():
            if isinstance(value, dict) and "deep" not in value:
                wanted[name] = understood(value, sender.lab.whole, receiver.lab.whole, receiver.lab)
        read = {k: receiver.plain(v) for k, v in receiver.arguments(sender.request(said)).items()}
        return read == wanted and receiver.result(sender.reply(goal)) == whole
    except (LostError, DecodeError):
        return False


def categories(old: Side, new: Side) -> set[str]:
    """What `gidl breaking` says."""
    return {category_of(f.code) for f in compare(old.model, new.model)}
