"""The order in which the types of a file are defined.

In C++, the type of a member must be complete where a struct is default-constructed. In IDL, a
declaration of the type is enough. In C++, each type is therefore defined after all types that it
contains, even if the file has another order. Types that contain each other in sequences are an
exception: one of them is defined before the others.
"""

from __future__ import annotations

from dataclasses import dataclass

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
from gidl.targets.cpp import names


@dataclass(frozen=True, slots=True)
class Placed:
    declaration: AnyDeclaration
    incomplete: frozenset[str]  # structs and unions in the declaration that are defined later


def in_order(model: Model, declarations: list[AnyDeclaration]) -> list[Placed]:
    """Returns `declarations` in the order of the file, but moves a type behind all types that it
    contains."""
    ordering = _Ordering(model, declarations)
    for declaration in declarations:
        ordering.place(declaration)
    return ordering.placed


def held(model: Model, used: Type, sequences: bool = True) -> set[str]:
    """Returns the names of the declarations that a type contains, directly or through typedefs. If
    `sequences` is False, leaves out the elements of sequences, because their C++ types may be
    incomplete."""
    match used:
        case SequenceType() if not sequences:
            return set()
        case SequenceType(element) | ArrayType(element):
            return held(model, element, sequences)
        case MapType(key, value):
            return held(model, key, sequences) | held(model, value, sequences)
        case NamedType(name):
            target = model.find(name)
            after = held(model, target.type, sequences) if isinstance(target, Typedef) else set()
            return {name} | after
        case _:
            return set()


class _Ordering:
    def __init__(self, model: Model, declarations: list[AnyDeclaration]) -> None:
        self.placed: list[Placed] = []
        self._model = model
        self._here = {d.name: d for d in declarations}
        self._open: set[str] = set()
        self._complete: set[str] = set()

    def place(self, declaration: AnyDeclaration) -> None:
        if declaration.name in self._complete | self._open:
            return
        self._open.add(declaration.name)
        all_held = [d for d in self._here.values() if d.name in self._held(declaration, True)]
        for each in all_held:
            by_name = isinstance(declaration, Typedef) and isinstance(each, Struct | Union)
            if not by_name and not self._needed(each) & self._open:
                self.place(each)
        missing = (d.name for d in all_held if _is_generated(d) and d.name not in self._complete)
        self.placed.append(Placed(declaration, frozenset(missing) - {declaration.name}))
        self._open.discard(declaration.name)
        self._complete.add(declaration.name)

    def _needed(self, declaration: AnyDeclaration) -> set[str]:
        """Returns the name of `declaration`, and the names of the types in the file that must be
        complete before it. These are all types that `declaration` contains, directly or indirectly,
        except in sequences."""
        needed, open_names = set[str](), {declaration.name}
        while open_names:
            name = open_names.pop()
            if name not in needed and name in self._here:
                needed.add(name)
                open_names |= self._held(self._here[name], False)
        return needed

    def _held(self, declaration: AnyDeclaration, sequences: bool) -> set[str]:
        found = {n for t in _types_in(declaration) for n in held(self._model, t, sequences)}
        if isinstance(declaration, Struct) and declaration.base is not None:
            found.add(declaration.base)
        return found


def _is_generated(declaration: AnyDeclaration) -> bool:
    return isinstance(declaration, Struct | Union) and not names.hand_written(declaration)


def _types_in(declaration: AnyDeclaration) -> list[Type]:
    match declaration:
        case Struct():
            return [m.type for m in declaration.members]
        case Union():
            return [declaration.discriminator, *(c.member.type for c in declaration.cases)]
        case Typedef():
            return [declaration.type]
        case _:
            return []
