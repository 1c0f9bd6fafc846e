"""Generated Python of two versions, as client and server of each other over the runtime."""

from __future__ import annotations

import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import gecos
from evolving import Lab, Slot
from gecos.errors import CommandFailed, Detail
from gidl.breaking import category_of, compare
from gidl.compile import Compiled, compile_files
from gidl.model import Model
from gidl.targets.emit import render
from gidl.wire import hashes, wire_layout

ROUNDS = 20  # of calls in each direction
Values = dict[str, Any]


@dataclass(frozen=True)
class Struct:
    """A value of a struct, without a class of either version."""

    name: str
    members: Values


@dataclass(frozen=True)
class Literal:
    name: str


@dataclass(frozen=True)
class Picked:
    label: int
    value: object


class Side:
    """Generated Python of one version, loaded, and its servant."""

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
        self.servant = _servant(self)

    @property
    def model(self) -> Model:
        return self.compiled.model

    @property
    def hashes(self) -> tuple[int, ...]:
        """The values of members that both versions have."""
        cart = self.model.interface("lab::Cart")
        (go,) = (each for each in cart.operations if each.name == "go")
        (place,) = cart.attributes
        return hashes.operation_hash(self.model, go), hashes.attribute_hash(self.model, place)

    def made(self, value: Any) -> Any:
        """As classes of this version have it."""
        match value:
            case Struct(name, members):
                return getattr(self.types, name)(**{k: self.made(v) for k, v in members.items()})
            case Literal(name):
                return self.types.Gear[name]
            case Picked(label, held):
                return self.types.Pick(label, held)
            case list():
                return [self.made(each) for each in value]
            case dict():
                return {self.made(key): self.made(each) for key, each in value.items()}
        return value

    def plain(self, value: Any) -> Any:
        """Without classes of this version."""
        kind = type(value).__name__
        match kind:
            case "Goal" | "Inner" | "Refused":
                slots = self.lab.slots(kind)
                return Struct(kind, {s.name: self.plain(getattr(value, s.name)) for s in slots})
            case "Gear":
                return Literal(value.name)
            case "Pick":
                return Picked(value.tag, value.value)
            case "list":
                return [self.plain(each) for each in value]
            case "dict":
                return {self.plain(key): self.plain(each) for key, each in value.items()}
        return value.tolist() if hasattr(value, "tolist") else value


def _load(name: str, code: str) -> types.ModuleType:
    module = types.ModuleType(name)
    sys.modules[name] = module
    exec(compile(code, f"{name}.py", "exec"), module.__dict__)
    return module


def _servant(side: Side) -> Any:
    """Keeps what it was told in `heard`; answers `goal`, or raises `refusal` where there is one."""

    def go(itself: Any, *arguments: object) -> object:
        itself.heard = arguments
        if itself.refusal is not None:
            raise itself.refusal
        return itself.goal

    methods: Values = {name: lambda _: None for name in side.lab.others}
    methods |= {"go": go, "place": lambda itself: itself.goal, "refusal": None}
    return type("CartOfThisVersion", (side.module.CartServant,), methods)()


# ---------------------------------------------------------------------------------------------
# Values, and what the other version has to make of them


def random_struct(name: str, lab: Lab, random: Random) -> Struct:
    return Struct(name, random_values(lab.slots(name), lab, random))


def random_values(slots: list[Slot], lab: Lab, random: Random) -> Values:
    return {
        s.name: None
        if s.mode == "optional" and random.random() < 0.25
        else _random_value(s, lab, random)
        for s in slots
    }


def _random_value(slot: Slot, lab: Lab, random: Random) -> object:
    match slot.type:
        case "Goal" | "Inner":
            return random_struct(slot.type, lab, random)
        case "Gear":
            return Literal(random.choice(list(lab.literals)))
        case "Pick":
            label = random.choice(list(lab.arms))
            return Picked(label, _random_value(Slot("", lab.arms[label]), lab, random))
        case "sequence<Inner>":
            return [random_struct("Inner", lab, random) for _ in range(random.randint(1, 2))]
        case "sequence<long>":
            return [random.randint(1000, 30_000) for _ in range(random.randint(1, 3))]
        case "map<long, Gear>":
            return {random.randrange(99): _random_value(Slot("", "Gear"), lab, random)}
        case "map<Gear, long>":  # with every key, so that two unknown ones would be the same
            return {Literal(name): random.randint(1000, 30_000) for name in lab.literals}
        case "string":
            return "".join(random.choices("abcäöü ", k=random.randint(1, 9)))
        case "boolean":
            return random.random() < 0.5
        case "double":
            return random.uniform(*(slot.range or (-50.0, 50.0)))
        case _:
            return random.randint(1000, 30_000)


class LostError(Exception):
    """The receiver cannot know what was meant."""


def understood(said: Any, sender: Lab, receiver: Lab) -> Any:
    """What a receiver has to read when its sender means `said`."""
    match said:
        case Struct(name, members):
            slots = sender.slots(name), receiver.slots(name)
            return Struct(name, understood_slots(members, *slots, sender, receiver))
        case Literal(name) if name not in receiver.literals:
            if receiver.default_literal is None:
                raise LostError(name)
            return Literal(receiver.default_literal)
        case list():
            return [understood(each, sender, receiver) for each in said]
        case dict():
            read = {
                understood(key, sender, receiver): understood(each, sender, receiver)
                for key, each in said.items()
            }
            if len(read) < len(said):
                raise LostError("two keys are the same")
            return read
    return said


def understood_slots(
    said: Values, senders: list[Slot], receivers: list[Slot], sender: Lab, receiver: Lab
) -> Values:
    known = {slot.name: slot for slot in senders}
    read: Values = {}
    for slot in receivers:
        if slot.name in known:
            units = {slot.unit, known[slot.name].unit}
            if len(units) > 1 and slot.type == "double":
                raise LostError(f"{slot.name} in {slot.unit}")
            read[slot.name] = understood(said[slot.name], sender, receiver)
        elif slot.mode == "required":
            raise LostError(slot.name)
        else:
            read[slot.name] = slot.default()
    return read


# ---------------------------------------------------------------------------------------------
# Calls


class Conversation:
    """Two versions that serve an object each, and call each other's by `medium`."""

    def __init__(self, lab: gecos.Lab, old: Side, new: Side, medium: str) -> None:
        self._sides = old, new
        self._proxies = {
            (client, server): lab.create(client.module.Cart, name, medium=medium)
            for client, server, name in ((old, new, "NEW"), (new, old, "OLD"))
        }

    def agree(self, random: Random) -> bool:
        """Whether each hears from the other what was meant, in requests, replies and errors."""
        return all(
            self._understands(client, server, random)
            for _ in range(ROUNDS)
            for client, server in self._proxies
        )

    def _understands(self, client: Side, server: Side, random: Random) -> bool:
        proxy = self._proxies[client, server]
        said = random_values(client.lab.parameters, client.lab, random)
        goal = random_struct("Goal", server.lab, random)
        refusal = random_struct("Refused", server.lab, random)
        server.servant.goal = server.made(goal)
        arguments = {k: client.made(v) for k, v in said.items()}
        try:
            heard = understood_slots(
                said, client.lab.parameters, server.lab.parameters, client.lab, server.lab
            )
            answer = understood(goal, server.lab, client.lab)
            excuse = understood(refusal, server.lab, client.lab)
            server.servant.refusal = None
            if client.plain(proxy.go(**arguments).result()) != answer:
                return False
            if [server.plain(v) for v in server.servant.heard] != list(heard.values()):
                return False
            if client.plain(proxy.place().result()) != answer:
                return False
            server.servant.refusal = server.made(refusal)
            try:
                proxy.go(**arguments).result()
            except client.module.Refused as caught:
                return bool(client.plain(caught) == excuse)
        except LostError:
            return False
        except CommandFailed as refused:
            assert " at byte " in str(refused), "refused, but not because bytes cannot be read"
            return False
        return False

    def only_new_operations_are_unknown(self) -> bool:
        """What one of them only has is answered as such, and disturbs nothing."""
        return all(
            self._is_unknown(client, server, name) == (name not in server.lab.others)
            for client, server in self._proxies
            for name in client.lab.others
        )

    def _is_unknown(self, client: Side, server: Side, name: str) -> bool:
        try:
            getattr(self._proxies[client, server], name)().result()
        except CommandFailed as refused:
            assert refused.detail is Detail.UNKNOWN_OPERATION, refused
            return True
        return False


@contextmanager
def conversation(old: Side, new: Side, medium: str) -> Iterator[Conversation]:
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        server.add("OLD", old.servant, simulated=True)
        server.add("NEW", new.servant, simulated=True)
        yield Conversation(lab, old, new, medium)


def categories(old: Side, new: Side) -> set[str]:
    """What `gidl breaking` says."""
    return {category_of(f.code) for f in compare(old.model, new.model)}
