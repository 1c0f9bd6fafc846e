"""Prints DDS types for Cyclone's idlc: structs, unions, enums, bitmasks, typedefs and constants.

Interfaces and exceptions are omitted. The types that an interface declares are printed in a module
with the name of the interface.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gidl.model import (
    AnnotationDeclaration,
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    EnumValue,
    ExceptionStruct,
    Extensibility,
    Interface,
    Member,
    NamedType,
    Struct,
    Type,
    Typedef,
    Union,
)
from gidl.omg.writer import OmgWriter


class DdsWriter(OmgWriter):
    dialect = "DDS"
    primitives = {  # noqa: RUF012  # read only
        name: name
        for name in (
            "boolean", "octet", "char", "int8", "uint8", "int16", "uint16", "int32", "uint32",
            "int64", "uint64", "float", "double",
        )
    }  # fmt: skip

    def _is_written(self, declaration: AnyDeclaration) -> bool:
        return not isinstance(declaration, AnnotationDeclaration | Interface | ExceptionStruct)

    def _units(
        self, declarations: Iterable[AnyDeclaration]
    ) -> Iterator[tuple[AnyDeclaration, ...]]:
        return ((d,) for d in declarations if self._is_written(d))

    def _missing(self, unit: tuple[AnyDeclaration, ...]) -> list[str]:
        return [n for n in super()._missing(unit) if self._is_written(self._model.find(n))]

    def _type(self, used: Type) -> str:
        if isinstance(used, NamedType) and isinstance(self._model.find(used.name), Interface):
            self._cannot(
                f"a reference to an object of '{used.name}'", "send the object's name, as a string"
            )
        return super()._type(used)

    def _unit(self, unit: tuple[AnyDeclaration, ...]) -> None:
        declaration = unit[-1]
        self._at = declaration.facts.location
        self._doc(declaration.facts)
        match declaration:
            case Struct():
                self._struct(declaration)
            case Union():
                self._union(declaration)
            case EnumDeclaration():
                items = []
                for e in declaration.enumerators:
                    default = "@default_literal " if e.name == declaration.default_literal else ""
                    items.append(f"{default}@value({e.number}) {self._name(e.name)}")
                self._enum(declaration, 0, items)
            case Bitmask():
                flags = [f"@position({f.position}) {self._name(f.name)}" for f in declaration.flags]
                self._line(
                    f"@bit_bound({declaration.bit_bound}) bitmask "
                    f"{self._name(declaration.simple_name)} {{ {', '.join(flags)} }};"
                )
            case Bitset():
                self._cannot(f"bitset '{declaration.simple_name}'", "use a struct of integers")
            case Typedef():
                self._typedef(declaration, 0)
            case Constant():
                self._bitmask_constant(declaration)
                self._constant(declaration, 0)

    def _bitmask_constant(self, constant: Constant) -> None:
        value = constant.value
        if isinstance(value, EnumValue) and isinstance(self._model.find(value.enum), Bitmask):
            self._cannot("a constant of a bitmask", "use a constant of an unsigned integer")

    def _struct(self, struct: Struct) -> None:
        base = f" : {self._full(struct.base)}" if struct.base else ""
        name = self._name(struct.simple_name)
        self._line(f"@{struct.extensibility.value} struct {name}{base} {{")
        for member in struct.members:
            self._member(member, "")
        self._line("};")

    def _member(self, member: Member, before: str) -> None:
        self._at = member.facts.location
        self._doc(member.facts, 1)
        marks = "@optional " if member.optional else ""
        if member.unit:
            marks += f'@unit("{member.unit}") '
        if member.default is not None:
            marks += f"@default({self._value(member.default, member.type)}) "
        declarator = self._declarator(member.name, member.type)
        self._line(f"{before}{marks}{self._type(member.type)} {declarator};", 1)

    def _union(self, union: Union) -> None:
        extensibility = "appendable" if union.extensibility is Extensibility.APPENDABLE else "final"
        name = self._name(union.simple_name)
        self._line(f"@{extensibility} union {name} switch ({self._type(union.discriminator)}) {{")
        for case in union.cases:
            self._member(case.member, self._labels(union, case.labels, case.is_default) + " ")
        self._line("};")
