"""Builds the views of one file for the templates of `<file>_types.{hpp,cpp}`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from gidl.files.names import source_stem
from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    File,
    Interface,
    StringType,
    Struct,
    Typedef,
    Union,
)
from gidl.names.type_names import TypeName
from gidl.targets.calls import passes_objects
from gidl.targets.cpp import names
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.definition_order import Placed, in_order
from gidl.targets.cpp.enums import Enums
from gidl.targets.cpp.includes import system_headers
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.structs import Structs
from gidl.targets.cpp.type_views import (
    AliasView,
    ConstantView,
    MappedView,
    NamespaceView,
    StructView,
    TypesView,
    TypeView,
)
from gidl.targets.cpp.unions import Unions
from gidl.targets.naming import (
    has_output,
    value_note,
)


def _whole(place: TypeName, view: TypeView) -> NamespaceView:
    return NamespaceView("::".join(place.scope), (), (view,))


def _forward(place: TypeName) -> NamespaceView:
    return NamespaceView("::".join(place.scope), (place.name,), ())


def types_view(lowering: Lowering, file: File) -> TypesView:
    declarations = file.declarations
    stem = source_stem(file.path)
    includes = {
        f"{source_stem(path)}_types.hpp"
        for path in file.includes
        if has_output(lowering.model, path)
    }
    if passes_objects(lowering.model, file):
        includes.add(f"{names.OBJECT_REF_STEM}_types.hpp")
    for declaration in declarations:
        by_hand = names.hand_written(declaration)
        if by_hand is not None:
            includes.add(by_hand[1])
    spaces = tuple(_Types(lowering).namespaces(declarations))
    return TypesView(
        file.path,
        f"{stem}_types.hpp",
        _system_includes((*_declared(lowering, declarations), *_members(spaces))),
        tuple(sorted(includes)),
        spaces,
    )


def _system_includes(declared: tuple[str, ...]) -> tuple[str, ...]:
    always = {"cstddef", "cstdint", "iosfwd", "string", "string_view"}
    return tuple(sorted(always | system_headers(declared)))


def _members(spaces: tuple[NamespaceView, ...]) -> Iterator[str]:
    """Yields the C++ texts of the types and initial values of all struct members."""
    for view in (view for space in spaces for view in space.types):
        if isinstance(view, StructView):
            yield from (f"{member.type} {member.initial}" for member in view.fields)


def _declared(lowering: Lowering, declarations: tuple[AnyDeclaration, ...]) -> Iterator[str]:
    """Yields the C++ texts of the types and values in unions, typedefs and constants."""
    for declaration in declarations:
        match declaration:
            case Union():
                yield "std::variant"
                yield from (lowering.type(case.member.type) for case in declaration.cases)
            case Typedef(type=target):
                yield lowering.type(target)
            case Constant(type=used, value=value):
                yield lowering.literal(value, used)


_Shown = EnumDeclaration | Bitmask | Bitset | Struct | Union | Typedef | Constant


class _Types(Enums, Structs, Unions):
    def namespaces(self, declarations: tuple[AnyDeclaration, ...]) -> Iterator[NamespaceView]:
        """Yields the views of a file by namespace: first the declarations, then the structs of
        results of operations with several results."""
        ordered = in_order(self._model, [d for d in declarations if isinstance(d, _Shown)])
        early = sorted({name for each in ordered for name in each.incomplete})
        parts = [_forward(self._place(name)) for name in early]
        parts += [_whole(self._place(each.declaration.name), self._type(each)) for each in ordered]
        for interface in (d for d in declarations if isinstance(d, Interface)):
            parts += [_whole(place, view) for place, view in self.results_of(interface)]
        for scope, run in groupby(parts, key=lambda part: part.name):
            views = list(run)
            forward = tuple(name for view in views for name in view.forward)
            yield NamespaceView(scope, forward, tuple(t for view in views for t in view.types))

    def _place(self, scoped_name: str) -> TypeName:
        return self._layout.cpp_names.types[scoped_name]

    def _type(self, placed: Placed) -> TypeView:
        declaration = placed.declaration
        match declaration:
            case EnumDeclaration():
                return self._enum(declaration)
            case Bitmask():
                return self._mask(declaration)
            case Bitset():
                return self._bits(declaration)
            case Struct():
                by_hand = names.hand_written(declaration)
                if by_hand is not None:
                    return MappedView("mapped", f"::{by_hand[0]}", by_hand[1])
                return self._struct(declaration, placed.incomplete)
            case Union():
                return self._union(declaration)
            case Typedef():
                note = value_note(declaration.unit, declaration.range)
                return AliasView(
                    "alias",
                    self._name(declaration),
                    doc_lines(declaration.facts, note),
                    self._lowering.type(declaration.type),
                )
            case Constant():
                return self._constant(declaration)
            case _:
                raise AssertionError(declaration)

    def _constant(self, constant: Constant) -> ConstantView:
        target = self._model.target(constant.type)
        text = isinstance(target, StringType)
        return ConstantView(
            "constant",
            self._name(constant),
            doc_lines(constant.facts, value_note(constant.unit, None)),
            "std::string_view" if text else self._lowering.type(constant.type),
            self._lowering.literal(constant.value, constant.type),
        )
