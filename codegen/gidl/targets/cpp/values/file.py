"""What the templates of `<file>_types.{hpp,cpp}` print of one file."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.file_names import source_stem
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
from gidl.targets.calls import passes_objects
from gidl.targets.cpp import names
from gidl.targets.cpp.includes import system_headers
from gidl.targets.cpp.lower import Lowering
from gidl.targets.cpp.values.enums import Enums
from gidl.targets.cpp.values.structs import Structs
from gidl.targets.cpp.values.unions import Unions
from gidl.targets.cpp.values.views import (
    AliasView,
    ConstantView,
    MappedView,
    NamespaceView,
    TypesView,
    TypeView,
)
from gidl.targets.naming import (
    doc_lines,
    has_output,
    value_note,
)
from gidl.targets.reach import named_types


def types_view(lowering: Lowering, file: File, extra: tuple[Struct, ...]) -> TypesView:
    """`extra` are structs that calls need and nobody declared (results of several values)."""
    builder = _Types(lowering)
    declarations = (*file.declarations, *extra)
    stem = source_stem(file.path)
    includes = {
        f"{source_stem(path)}_types.hpp"
        for path in file.includes
        if has_output(lowering.model, path)
    }
    if passes_objects(lowering.model, file):
        includes.add(f"{names.OBJECT_REF_STEM}_types.hpp")
    for declaration in declarations:
        if isinstance(declaration, Struct) and declaration.maps_to and declaration.maps_to.cpp:
            includes.add(declaration.maps_to.cpp[1])
    return TypesView(
        file.path,
        f"{stem}_types.hpp",
        _system_includes(lowering, declarations),
        tuple(sorted(includes)),
        tuple(builder.namespaces(declarations)),
    )


def _system_includes(
    lowering: Lowering, declarations: tuple[AnyDeclaration, ...]
) -> tuple[str, ...]:
    always = {"cstddef", "cstdint", "iosfwd", "string", "string_view"}
    return tuple(sorted(always | system_headers(_declared(lowering, declarations))))


def _declared(lowering: Lowering, declarations: tuple[AnyDeclaration, ...]) -> Iterator[str]:
    """Types and initial values as they are written."""
    for declaration in declarations:
        match declaration:
            case Struct():
                for member in declaration.members:
                    yield lowering.type(member.type, member.optional)
                    yield lowering.initial(member)
            case Union():
                yield "std::variant"
                yield from (lowering.type(case.member.type) for case in declaration.cases)
            case Typedef(type=target):
                yield lowering.type(target)
            case Constant(type=used, value=value):
                yield lowering.literal(value, used)


class _Types(Enums, Structs, Unions):
    def namespaces(self, declarations: tuple[AnyDeclaration, ...]) -> Iterator[NamespaceView]:
        """Runs of declarations of one module."""
        run: list[AnyDeclaration] = []
        for declaration in declarations:
            if isinstance(declaration, Interface) or self._view_kind(declaration) is None:
                continue
            if run and self._scope(run[-1]) != self._scope(declaration):
                yield self._namespace(run)
                run = []
            run.append(declaration)
        if run:
            yield self._namespace(run)

    def _scope(self, declaration: AnyDeclaration) -> str:
        return "::".join(names.scope_of(self._model, declaration.name))

    @staticmethod
    def _view_kind(declaration: AnyDeclaration) -> type | None:
        known = Struct | EnumDeclaration | Bitmask | Bitset | Union | Typedef | Constant
        return type(declaration) if isinstance(declaration, known) else None

    def _namespace(self, run: list[AnyDeclaration]) -> NamespaceView:
        forward = []
        seen: set[str] = set()
        for declaration in run:
            if isinstance(declaration, Struct | Union | Typedef):
                used = self._named_types(declaration)
                forward += [
                    name for name in sorted(used) if name not in seen and name not in forward
                ]
            seen.add(declaration.name)
        local = {d.name for d in run if isinstance(d, Struct | Union)}
        simple = tuple(names.simple_name(self._model, n) for n in forward if n in local)
        return NamespaceView(self._scope(run[0]), simple, tuple(self._type(d) for d in run))

    @staticmethod
    def _named_types(declaration: Struct | Union | Typedef) -> set[str]:
        match declaration:
            case Struct():
                used = [m.type for m in declaration.members]
            case Union():
                used = [case.member.type for case in declaration.cases]
            case Typedef():
                used = [declaration.type]
        return {name for each in used for name in named_types(each)} - {declaration.name}

    def _type(self, declaration: AnyDeclaration) -> TypeView:
        match declaration:
            case EnumDeclaration():
                return self._enum(declaration)
            case Bitmask():
                return self._mask(declaration)
            case Bitset():
                return self._bits(declaration)
            case Struct(maps_to=maps_to) if maps_to is not None and maps_to.cpp is not None:
                return MappedView("mapped", *maps_to.cpp)
            case Struct():
                return self._struct(declaration)
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
