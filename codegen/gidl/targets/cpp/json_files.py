"""Builds the view with which the templates of `<file>_json.{hpp,cpp}` are rendered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gidl.files.names import source_stem
from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    EnumDeclaration,
    File,
    Interface,
    Member,
    Struct,
)
from gidl.names.languages import CPP_BITSET_WORDS, CPP_WORDS
from gidl.names.type_names import escaped
from gidl.targets.calls import passes_objects, result_struct
from gidl.targets.cpp import names
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.structs import Structs
from gidl.targets.cpp.type_views import StructView
from gidl.targets.naming import has_output


@dataclass(frozen=True, slots=True)
class NamesShape:
    """The JSON form of an enum or a bitmask: the names of enumerators or flags."""

    kind: str  # always "names"
    type: str
    base: str  # class template of the runtime: "JsonEnum" or "JsonFlags"
    names: tuple[tuple[str, str], ...]  # pairs of IDL name and C++ name


@dataclass(frozen=True, slots=True)
class MemberView:
    word: str  # name of the member in the interface
    name: str
    secret: bool


@dataclass(frozen=True, slots=True)
class MembersShape:
    """The JSON form of a struct, exception or bitset: an object with its members."""

    kind: str  # always "members"
    type: str
    argument: str
    members: tuple[MemberView, ...]


@dataclass(frozen=True, slots=True)
class LayoutShape:
    """A hand-written type, which has the JSON form of the struct for which the type stands.
    `layout` is this struct, as the interface file declares it."""

    kind: str  # always "layout"
    type: str
    argument: str
    layout: StructView
    members: MembersShape


JsonShape = NamesShape | MembersShape | LayoutShape


@dataclass(frozen=True, slots=True)
class JsonView:
    source: str  # "robcl/geometry.gidl"
    header: str  # "robcl/geometry_json.hpp"
    types_header: str
    includes: tuple[str, ...]
    shapes: tuple[JsonShape, ...]


def json_view(lowering: Lowering, file: File) -> JsonView:
    stem = source_stem(file.path)
    stems = {source_stem(path) for path in file.includes if has_output(lowering.model, path)}
    if passes_objects(lowering.model, file):
        stems.add(names.OBJECT_REF_STEM)
    return JsonView(
        file.path,
        f"{stem}_json.hpp",
        f"{stem}_types.hpp",
        tuple(sorted(f"{each}_json.hpp" for each in stems)),
        tuple(_Shapes(lowering).of(file)),
    )


class _Shapes(Structs):
    def of(self, file: File) -> Iterator[JsonShape]:
        for declaration in file.declarations:
            match declaration:
                case EnumDeclaration(enumerators=enumerators):
                    words = [each.name for each in enumerators]
                    yield self._names(declaration, words, "JsonEnum")
                case Bitmask(flags=flags):
                    words = [each.name for each in flags]
                    yield self._names(declaration, words, "JsonFlags")
                case Bitset():
                    yield self._bitset(declaration)
                case Struct() if names.hand_written(declaration):
                    yield self._mapped(declaration)
                case Struct():
                    type_name = self._lowering.named(declaration.name)
                    yield self._members(type_name, self._model.all_members(declaration))
                case Interface():
                    for operation in declaration.operations:
                        if len(self._layout.call(operation.scoped_name).reply) > 1:
                            place = self._layout.cpp_names.results[operation.scoped_name]
                            members = result_struct(self._layout, operation).members
                            yield self._members(names.absolute(place), members)
                case _:
                    pass

    def _names(self, declaration: AnyDeclaration, words: list[str], base: str) -> NamesShape:
        type_name = self._lowering.named(declaration.name)
        known = tuple((word, escaped(word, CPP_WORDS)) for word in words)
        return NamesShape("names", type_name, base, known)

    def _bitset(self, bitset: Bitset) -> MembersShape:
        reserved = CPP_BITSET_WORDS
        members = tuple(
            MemberView(field.name, escaped(field.name, reserved), False)
            for field in self._model.all_fields(bitset)
            if field.name is not None
        )
        type_name = self._lowering.named(bitset.name)
        return MembersShape("members", type_name, f"const {type_name}&", members)

    @staticmethod
    def _members(type_name: str, members: tuple[Member, ...]) -> MembersShape:
        views = tuple(MemberView(m.name, names.member_name(m.name), m.secret) for m in members)
        return MembersShape("members", type_name, f"const {type_name}&", views)

    def _mapped(self, struct: Struct) -> LayoutShape:
        type_name = self._lowering.named(struct.name)
        name = f"JsonLayout<{type_name}>"
        view = self._struct(struct)
        members = self._model.all_members(struct)
        whole = replace(
            view,
            name=name,
            fields=tuple(self._field(member) for member in members),
            codec=replace(view.codec, check=()),
        )
        shape = self._members(name, members)
        return LayoutShape("layout", type_name, f"const {type_name}&", whole, shape)
