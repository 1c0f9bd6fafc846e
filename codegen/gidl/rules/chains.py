"""Rule: a chain of types, in which each type uses the next one, has at most 64 types. Layouts and
hashes are computed recursively, so the depth must be limited."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.diagnostics.findings import Findings
from gidl.model import (
    AnyDeclaration,
    Model,
    Struct,
    Type,
    Typedef,
    Union,
)
from gidl.model.types import named_in

MAX_CHAIN = 64


def check(model: Model, findings: Findings) -> None:
    lengths = _lengths(model)
    for declaration in model.declarations():
        length = lengths[declaration.name]
        if length == MAX_CHAIN + 1:
            findings.error(
                "G0322",
                declaration.facts.location,
                f"'{declaration.simple_name}' is at the end of a chain of {length} types that "
                f"use each other; at most {MAX_CHAIN} are allowed",
                "use the type at the beginning of the chain, or declare fewer types in between",
            )


def _lengths(model: Model) -> dict[str, int]:
    """Returns, for each declaration, the length of the longest chain that begins with this
    declaration. In a chain, each declaration uses the next one. A type that contains itself counts
    once. The function is not recursive, because a chain may be longer than Python's stack."""
    used = {each.name: _used(each) for each in model.declarations()}
    lengths: dict[str, int] = {}
    for first in used:
        work, begun = [first], set[str]()
        while work:
            name = work[-1]
            if name not in lengths and name not in begun:
                begun.add(name)
                work += [n for n in used[name] if n in used and n not in begun]
                continue
            work.pop()
            lengths.setdefault(name, 1 + max((lengths.get(n, 0) for n in used[name]), default=0))
    return lengths


def _used(declaration: AnyDeclaration) -> list[str]:
    """Returns the names of the declared types that a declaration uses."""
    names = [name for used in _types(declaration) for name in named_in(used)]
    if isinstance(declaration, Struct) and declaration.base is not None:
        names.append(declaration.base)
    return names


def _types(declaration: AnyDeclaration) -> Iterator[Type]:
    match declaration:
        case Struct(members=members):
            yield from (member.type for member in members)
        case Union(cases=cases):
            yield from (case.member.type for case in cases)
        case Typedef():
            yield declaration.type
