"""Rule: the keys of a map must compare exactly, so a key is neither a floating-point number nor a
container."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import (
    ArrayType,
    EnumDeclaration,
    Location,
    MapType,
    Model,
    NamedType,
    PrimitiveType,
    SequenceType,
    StringType,
    Type,
)
from gidl.rules.walk import slots


def check(model: Model, findings: Findings) -> None:
    for slot in slots(model):
        _look(model, slot.type, slot.facts.location, findings)


def _look(model: Model, used: Type, at: Location, findings: Findings) -> None:
    match used:
        case MapType(key, value):
            if not _may_be_key(model, key):
                findings.error(
                    "G0319",
                    at,
                    "the keys of a map must be strings, integers, characters, booleans or enums",
                    "use a sequence of structs",
                )
            _look(model, value, at, findings)
        case SequenceType(element=element) | ArrayType(element=element):
            _look(model, element, at, findings)


def _may_be_key(model: Model, key: Type) -> bool:
    match model.target(key):
        case PrimitiveType(kind):
            return not kind.is_floating
        case StringType():
            return True
        case NamedType(name):
            return isinstance(model.find(name), EnumDeclaration)
        case _:
            return False
