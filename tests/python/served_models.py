"""Served models of interfaces in .gidl files, and random plain data for their values."""

from __future__ import annotations

import struct
import sys
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any

TREE = Path(__file__).resolve().parents[2]
for folder in ("codegen", "tests/generated", "tests/generated/gate"):
    if str(TREE / folder) not in sys.path:
        sys.path.append(str(TREE / folder))

from generating import generate as generate  # noqa: E402  (found by the lines above)
from gidl.compile import compile_files  # noqa: E402
from gidl.files.names import python_module as python_module  # noqa: E402
from gidl.model import (  # noqa: E402
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    Interface,
    MapType,
    Model,
    NamedType,
    Operation,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Union,
)
from gidl.targets.python import names as names  # noqa: E402
from gidl.targets.served_model import served_model  # noqa: E402
from gidl.wire.events import events_as_streams  # noqa: E402
from gidl.wire.wire_layout import CallKind as CallKind  # noqa: E402
from gidl.wire.wire_layout import CallLayout, Layout, build  # noqa: E402
from making import Making  # noqa: E402
from neutral import Slot, arms, chosen, element, members, named_fields, settled  # noqa: E402
from opinion import rounded  # noqa: E402

FILES = [
    *sorted((TREE / "idl").rglob("*.gidl")),
    TREE / "tests/idl/everything.gidl",
    *sorted((TREE / "tests/idl/corners").glob("*.gidl")),
    TREE / "tests/idl/workshop/workshop.gidl",
]

REFERENCE_NAMES = ("name", "interface_hash", "boot", "where")


def load() -> tuple[Model, Layout]:
    search = [str(TREE / "idl"), str(TREE / "tests/idl")]
    compiled = compile_files(map(str, FILES), search)
    assert not compiled.has_errors, compiled.findings
    model = events_as_streams(compiled.model)
    return model, build(model)


# -- the texts that a server serves ----------------------------------------------------------------


def served(model: Model, layout: Layout, name: str) -> list[str]:
    """The texts of an interface and of its bases."""
    interface = model.interface(name)
    every = [interface, *(model.interface(base) for base in interface.all_bases)]
    return [served_model(model, layout, each) for each in every]


# -- random values ---------------------------------------------------------------------------------


def inputs(model: Model, call: CallLayout) -> list[tuple[str, Slot]]:
    member = _member(model, call)
    if isinstance(member, Operation):
        return [(p.name, Slot(p.type, p.range, p.optional, p.secret)) for p in member.inputs]
    value = Slot(member.type, member.range, member.optional, member.secret)
    return [("value", value)] if call.kind is CallKind.SETTER else []


def outputs(model: Model, call: CallLayout) -> list[tuple[str, Slot]]:
    member = _member(model, call)
    if not isinstance(member, Operation):
        if call.kind is CallKind.SETTER:
            return []
        return [("value", Slot(member.type, member.range, member.optional, member.secret))]
    found = [(p.name, Slot(p.type, p.range, p.optional, p.secret)) for p in member.outputs]
    if member.result is not None:
        result = Slot(
            member.result, member.result_range, member.result_optional, member.result_secret
        )
        found.insert(0, (call.reply[0].name, result))
    return found


def _member(model: Model, call: CallLayout) -> Any:
    owner, _, name = call.name.removesuffix("=").rpartition("::")
    return next(m for m in model.interface(owner).members if m.name == name)


class Unsayable(Exception):
    """Plain data cannot express the value."""


class Plain:
    """Random values as plain data."""

    def __init__(self, model: Model, seed: int) -> None:
        self._model = model
        self._making = Making(model, Random(seed))

    def values(self, slots: Sequence[Slot], spoiled: bool) -> list[Any]:
        made = self._making.values(list(slots), spoiled)
        return [self.plain(slot, value) for slot, value in zip(slots, made, strict=True)]

    def plain(self, slot: Slot, value: Any) -> Any:
        slot = settled(self._model, slot)
        if slot.optional:
            return self.plain(Slot(slot.type, slot.range), value[0]) if value else None
        match slot.type:
            case PrimitiveType(kind):
                return _plain_number(kind, value)
            case StringType():
                return value.decode("utf-8", "surrogateescape")
            case SequenceType() | ArrayType():
                return [self.plain(element(slot), each) for each in value]
            case MapType(key, item):
                return [[self.plain(Slot(key), k), self.plain(Slot(item), v)] for k, v in value]
            case NamedType(name):
                return self._named(name, value)

    def _named(self, name: str, value: Any) -> Any:
        declared = self._model.find(name)
        match declared:
            case Interface():
                return dict(zip(REFERENCE_NAMES, _texts(value), strict=True))
            case EnumDeclaration():
                return next(e.name for e in declared.enumerators if e.number == value)
            case Bitmask():
                return [f.name for f in declared.flags if value >> f.position & 1]
            case Bitset():
                fields = zip(named_fields(self._model, declared), value, strict=True)
                return {f.name: _plain_number(f.type.kind, number) for f, number in fields}
            case Struct() if declared.maps_to is not None:
                x, y, z, w, *turn = struct.unpack(">7d", value)
                position = {"x": x, "y": y, "z": z}
                return {
                    "position": position,
                    "orientation": dict(zip("wxyz", (w, *turn), strict=True)),
                }
            case Struct():
                slots = members(self._model, declared)
                names = [m.name for m in self._model.all_members(declared)]
                values = (self.plain(s, v) for s, v in zip(slots, value, strict=True))
                return dict(zip(names, values, strict=True))
            case Union():
                tag, index, held = value
                if index != chosen(self._model, declared, tag):
                    raise Unsayable
                data = {"tag": self.plain(Slot(declared.discriminator), tag)}
                if index:
                    data["value"] = self.plain(arms(declared)[index - 1], held[0])
                return data
        raise AssertionError(name)


def shown(model: Model, slot: Slot, data: Any) -> Any:
    """Plain data as received: secrets replaced, flags and maps in order."""
    slot = settled(model, slot)
    if slot.secret:
        return "***"
    if data is None:
        return None
    match slot.type:
        case SequenceType() | ArrayType():
            return [shown(model, element(slot), each) for each in data]
        case MapType(key, item):
            pairs = [[shown(model, Slot(key), k), shown(model, Slot(item), v)] for k, v in data]
            return sorted(pairs, key=lambda pair: _order(model, key, pair[0]))
        case NamedType(name):
            declared = model.find(name)
            if isinstance(declared, Struct) and declared.maps_to is None:
                slots = zip(members(model, declared), data.items(), strict=True)
                return {key: shown(model, s, each) for s, (key, each) in slots}
            if isinstance(declared, Union) and "value" in data:
                tag = data["tag"]
                number = _order(model, declared.discriminator, tag)
                arm = chosen(model, declared, ord(number) if isinstance(number, str) else number)
                return {"tag": tag, "value": shown(model, arms(declared)[arm - 1], data["value"])}
    return data


def _order(model: Model, used: Any, key: Any) -> Any:
    used = settled(model, Slot(used)).type
    declared = model.find(used.name) if isinstance(used, NamedType) else None
    if isinstance(declared, EnumDeclaration):
        return next(e.number for e in declared.enumerators if e.name == key)
    if isinstance(declared, Bitmask):
        return sum(1 << f.position for f in declared.flags if f.name in key)
    return key


def _plain_number(kind: Primitive, value: Any) -> Any:
    if kind is Primitive.BOOLEAN:
        return bool(value) if value in (0, 1) else value
    if kind is Primitive.CHAR:
        return chr(value)
    if not kind.is_floating:
        return int(value)
    number = rounded(value) if kind is Primitive.FLOAT else float(value)
    return str(number) if number != number or abs(number) == float("inf") else number


def _texts(value: list[Any]) -> list[Any]:
    return [v.decode("utf-8", "surrogateescape") if isinstance(v, bytes) else v for v in value]
