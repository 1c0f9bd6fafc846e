"""Finds declarations in different files that would get the same name in C++.

gidl adds names, for example `LampServant` or `Lamp_Mode`. It changes an added name that is already
in use in the same file or in an included file: see type_names.py. If neither of two files includes
the other, gidl cannot compare their names, and both files may get the same name. A program that
includes the headers of both files would not compile.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gidl.diagnostics.findings import Findings, Note
from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    File,
    Interface,
    Location,
    Model,
    Struct,
)
from gidl.names.languages import CPP_TYPES
from gidl.names.type_names import TypeName, TypeNames, name_types


@dataclass(frozen=True, slots=True)
class _Use:
    """The use of a C++ name for a declaration."""

    what: str  # for example "the servant of 'lab::Lamp'"
    declared: str  # scoped name of the declaration that could be renamed
    location: Location
    is_module: bool = False


def same_names(model: Model, findings: Findings) -> None:
    """Reports each pair of declarations in different files that have the same name in C++. The
    finding is at the beginning of the first file that includes both files. If no file includes
    both, it is at the second declaration."""
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
            f"{files} give the same C++ name '{shared}' to {one.what} and to {other.what}",
            f"rename '{one.declared}' or '{other.declared}', or include one of the two files in the"
            " other, so that gidl sees both names and can change one that it generates",
            notes=(
                Note(f"'{one.declared}' is declared here", one.location),
                Note(f"'{other.declared}' is declared here", other.location),
            ),
        )


def _uses(names: TypeNames, file: File) -> Iterator[tuple[TypeName, _Use]]:
    """Yields all C++ names of the declarations in a file."""
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
    """Returns whether the declaration has a hand-written C++ type, so that gidl generates none."""
    return (
        isinstance(declaration, Struct)
        and declaration.maps_to is not None
        and declaration.maps_to.cpp is not None
    )
