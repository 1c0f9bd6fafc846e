"""The files of a run of gidl, and the model, which finds declarations by their names."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from gidl.model.declarations import (
    AnnotationDeclaration,
    Bitfield,
    Bitmask,
    Bitset,
    Constant,
    Declaration,
    EnumDeclaration,
    Member,
    Struct,
    Typedef,
    Union,
)
from gidl.model.interfaces import Attribute, Interface, Operation
from gidl.model.types import NamedType, Type

AnyDeclaration = (
    Struct | EnumDeclaration | Bitmask | Bitset | Union | Typedef | Constant | Interface
    | AnnotationDeclaration
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class File:
    path: str  # path as in `#include`, such as "robcl/geometry.gidl"
    includes: tuple[str, ...]  # paths of the directly included files, in order
    # All declarations, in order. A nested declaration comes before the enclosing one.
    declarations: tuple[AnyDeclaration, ...]
    asked_for: bool = True  # True: named on the command line; False: only included
    doc: str = ""
    modules: tuple[Declaration, ...] = ()  # one for each `module X {` of the file, in order

    @property
    def has_interface(self) -> bool:
        return any(isinstance(d, Interface) for d in self.declarations)


@dataclass(frozen=True, slots=True)
class Model:
    files: tuple[File, ...]  # each file comes after the files that it includes
    _index: dict[str, AnyDeclaration] = field(init=False, repr=False, compare=False)
    _homes: dict[str, str] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index = {d.name: d for f in self.files for d in f.declarations}
        homes = {d.name: f.path for f in self.files for d in f.declarations}
        object.__setattr__(self, "_index", index)
        object.__setattr__(self, "_homes", homes)

    def find(self, name: str) -> AnyDeclaration:
        """Returns the declaration with the scoped name `name`. @pre `name` is declared: see
        `has`."""
        return self._index[name]

    def has(self, name: str) -> bool:
        return name in self._index

    def file_of(self, name: str) -> str:
        """Returns the path of the file that declares `name`."""
        return self._homes[name]

    def declarations(self) -> Iterator[AnyDeclaration]:
        for file in self.files:
            yield from file.declarations

    def interfaces(self) -> Iterator[Interface]:
        for declaration in self.declarations():
            if isinstance(declaration, Interface):
                yield declaration

    def interface(self, name: str) -> Interface:
        found = self.find(name)
        assert isinstance(found, Interface), name
        return found

    def struct(self, name: str) -> Struct:
        found = self.find(name)
        assert isinstance(found, Struct), name
        return found

    def target(self, used: Type) -> Type:
        """Returns the type that `used` stands for, with typedefs resolved. Typedefs of its
        elements, keys and values are not resolved."""
        while isinstance(used, NamedType):
            declaration = self.find(used.name)
            if not isinstance(declaration, Typedef):
                break
            used = declaration.type
        return used

    def all_members(self, struct: Struct) -> tuple[Member, ...]:
        """Returns all members of a struct; the members of its bases come first."""
        inherited = self.all_members(self.struct(struct.base)) if struct.base else ()
        return inherited + struct.members

    def all_fields(self, bitset: Bitset) -> tuple[Bitfield, ...]:
        """Returns all fields of a bitset; the fields of its bases come first."""
        if bitset.base is None:
            return bitset.fields
        base = self.find(bitset.base)
        assert isinstance(base, Bitset)
        return self.all_fields(base) + bitset.fields

    def with_bases(self, interface: Interface) -> tuple[Interface, ...]:
        """Returns all bases of an interface, the most general first, and then the interface
        itself."""
        return (*(self.interface(name) for name in interface.all_bases), interface)

    def all_interface_members(self, interface: Interface) -> tuple[Operation | Attribute, ...]:
        """Returns all members of an object of this interface; inherited members come first."""
        return tuple(m for i in self.with_bases(interface) for m in i.members)
