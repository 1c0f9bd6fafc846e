"""Rule: at most 64 types use each other in a chain, so that computing a layout or a hash ends."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.diagnostics import Findings
from gidl.model import (
    AnyDeclaration,
    ArrayType,
    MapType,
    Model,
    NamedType,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
)

MAX_CHAIN = 64


def check(model: Model, findings: Findings) -> None:
    lengths: dict[str, int] = {}  # a type is declared after the types that it uses
    for declaration in model.declarations():
        used = [lengths.get(name, 0) for each in _used(declaration) for name in _names(each)]
        if isinstance(declaration, Struct) and declaration.base is not None:
            used.append(lengths.get(declaration.base, 0))
        length = lengths[declaration.name] = 1 + max(used, default=0)
        if length == MAX_CHAIN + 1:
            findings.error(
                "G0322",
                declaration.facts.location,
                f"'{declaration.simple_name}' is the end of a chain of {length} types that use "
                f"each other, at most {MAX_CHAIN} are allowed",
                "use the type at the beginning of the chain, or declare fewer types in between",
            )


def _used(declaration: AnyDeclaration) -> Iterator[Type]:
    match declaration:
        case Struct(members=members):
            yield from (member.type for member in members)
        case Union(cases=cases):
            yield from (case.member.type for case in cases)
        case Typedef():
            yield declaration.type


def _names(used: Type) -> Iterator[str]:
    match used:
        case NamedType(name):
            yield name
        case SequenceType(element=element) | ArrayType(element=element):
            yield from _names(element)
        case MapType(key, value):
            yield from _names(key)
            yield from _names(value)
