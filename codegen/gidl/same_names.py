"""Finds declarations of different files that would get the same name in C++.

Within a file and its includes, a name that gidl adds (`LampServant`, `Lamp_Mode`) gives way to
other names: see type_names.py. Two files of which neither includes the other do not know each
other, so they can get the same name. No program could use both.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gidl.diagnostics import Findings, Note
from gidl.layout.languages import CPP_TYPES
from gidl.layout.type_names import TypeName, TypeNames, name_types
from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    File,
    Interface,
    Location,
    Model,
    Struct,
)


@dataclass(frozen=True, slots=True)
class _Use:
    """The use of a C++ name by a declaration."""

    what: str  # "the servant of 'lab::Lamp'"
    declared: str  # scoped name of the declaration, which could be renamed
    location: Location
    is_module: bool = False


def same_names(model: Model, findings: Findings) -> None:
    """Reports each C++ name that declarations of two files have: in the first file that includes
    both files, otherwise at the second declaration."""
    names = name_types(model, CPP_TYPES)
    first: dict[TypeName, _Use] = {}
    reach: dict[str, frozenset[str]] = {}
    clashes: list[tuple[TypeName, _Use, _Use]] = []
    for file in model.files:
        beyond = (reach.get(path, frozenset()) for path in file.includes)
        reach[file.path] = frozenset([file.path]).union(*beyond)
        for place, use in _uses(names, file):
            other = first.setdefault(place, use)
            if other.declared != use.declared and not (other.is_module and use.is_module):
                clashes.append((place, other, use))
    for place, one, other in clashes:
        both = {one.location.file, other.location.file}
        if len(both) == 1:
            continue
        user = next((file.path for file in model.files if both <= reach[file.path]), None)
        files = "two files" if user is None else "two files that this file includes"
        shared = "::".join((*place.scope, place.name))
        findings.error(
            "G0114",
            other.location if user is None else Location(user, 1, 1),
            f"{files} give one name in C++, '{shared}', to {one.what} and to {other.what}",
            f"rename '{one.declared}' or '{other.declared}', or let one of the two files include"
            " the other: a name that gidl adds then gives way",
            notes=(
                Note("one is declared here", one.location),
                Note("the other is declared here", other.location),
            ),
        )


def _uses(names: TypeNames, file: File) -> Iterator[tuple[TypeName, _Use]]:
    """All C++ names of the declarations in a file."""
    for declaration in file.declarations:
        if isinstance(declaration, AnnotationDeclaration) or _is_hand_written(declaration):
            continue
        name, at = declaration.name, declaration.facts.location
        place = names.types[name]
        modules = name.split("::")
        for depth, module in enumerate(place.scope):
            scoped = "::".join(modules[: depth + 1])
            use = _Use(f"module '{scoped}'", scoped, at, True)
            yield TypeName(place.scope[:depth], module), use
        yield place, _Use(f"'{name}'", name, at)
        if not isinstance(declaration, Interface):
            continue
        for table, what in ((names.servants, "servant"), (names.descriptions, "description")):
            yield table[name], _Use(f"the {what} of '{name}'", name, at)
        for member in declaration.members:
            called, at = member.scoped_name, member.facts.location
            for table, what in ((names.arguments, "arguments"), (names.results, "results")):
                for key in (called, f"{called}="):
                    if key in table:
                        yield table[key], _Use(f"the {what} of '{called}'", called, at)


def _is_hand_written(declaration: AnyDeclaration) -> bool:
    """Whether no C++ type is generated, because there is one that was written by hand."""
    return (
        isinstance(declaration, Struct)
        and declaration.maps_to is not None
        and declaration.maps_to.cpp is not None
    )
