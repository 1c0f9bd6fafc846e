"""Prints CORBA IDL for omniidl. Annotations are dropped. A construct that CORBA IDL cannot express
becomes a finding."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gidl.model import (
    AnyDeclaration,
    Attribute,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    ExceptionStruct,
    Interface,
    Member,
    Operation,
    PrimitiveType,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
)
from gidl.omg.writer import OmgWriter


class CorbaWriter(OmgWriter):
    dialect = "CORBA"
    primitives = {  # noqa: RUF012  # read only
        "boolean": "boolean", "octet": "octet", "uint8": "octet", "char": "char",
        "int16": "short", "uint16": "unsigned short", "int32": "long", "uint32": "unsigned long",
        "int64": "long long", "uint64": "unsigned long long", "float": "float", "double": "double",
    }  # fmt: skip

    # -- units: declarations that are printed together -----------------------------------------

    def _units(
        self, declarations: Iterable[AnyDeclaration]
    ) -> Iterator[tuple[AnyDeclaration, ...]]:
        """Yields units. A unit is an interface with the declarations inside it, or any other single
        declaration."""
        inside: list[AnyDeclaration] = []
        for declaration in declarations:
            if not self._is_written(declaration):
                continue
            if isinstance(declaration, Interface):
                yield (*inside, declaration)
                inside = []
            elif self._model.has(declaration.scope):
                inside.append(declaration)
            else:
                yield (declaration,)

    def _unit(self, unit: tuple[AnyDeclaration, ...]) -> None:
        *inside, last = unit
        if isinstance(last, Interface):
            self._interface(last, inside)
        else:
            self._declaration(last, 0)
        self._repository_names(unit)

    def _repository_names(self, unit: tuple[AnyDeclaration, ...]) -> None:
        for declaration in unit:
            for kept in declaration.facts.annotations:
                if kept.name == "typeid":
                    self._line(f'#pragma ID {declaration.name} "{dict(kept.arguments)["value"]}"')

    # -- declarations --------------------------------------------------------------------------

    def _declaration(self, declaration: AnyDeclaration, deeper: int) -> None:
        self._at = declaration.facts.location
        self._doc(declaration.facts, deeper)
        match declaration:
            case Struct():
                self._struct(declaration, deeper)
            case Union():
                self._union(declaration, deeper)
            case EnumDeclaration():
                if [e.number for e in declaration.enumerators] != list(
                    range(len(declaration.enumerators))
                ):
                    self._cannot(
                        "enumerators with explicit numbers", "leave out @value, or use constants"
                    )
                self._enum(
                    declaration, deeper, [self._name(e.name) for e in declaration.enumerators]
                )
            case Typedef():
                self._typedef(declaration, deeper)
            case Constant():
                self._constant(declaration, deeper)
            case Bitmask():
                self._cannot(f"bitmask '{declaration.simple_name}'", "use an integer and constants")
            case Bitset():
                self._cannot(f"bitset '{declaration.simple_name}'", "use a struct of integers")

    def _struct(self, struct: Struct, deeper: int) -> None:
        if struct.base is not None:
            self._cannot("a struct with a base", "declare a member whose type is the base struct")
        kind = "exception" if isinstance(struct, ExceptionStruct) else "struct"
        if kind == "struct" and not struct.members:
            self._cannot("an empty struct")
        self._line(f"{kind} {self._name(struct.simple_name)} {{", deeper)
        for member in struct.members:
            self._member(member, "", deeper + 1)
        self._line("};", deeper)

    def _member(self, member: Member, before: str, deeper: int) -> None:
        self._at = member.facts.location
        self._doc(member.facts, deeper)
        if member.optional:
            self._no_optional()
        unit = f"  // {member.unit}" if member.unit else ""
        declarator = self._declarator(member.name, member.type)
        self._line(f"{before}{self._type(member.type)} {declarator};{unit}", deeper)

    def _no_optional(self) -> None:
        self._cannot("an optional value", "use a sequence of at most one element")

    def _union(self, union: Union, deeper: int) -> None:
        used = union.discriminator
        if isinstance(used, PrimitiveType) and used.kind.value in ("octet", "uint8", "int8"):
            self._cannot(
                f"a union with the discriminator {used.kind.value}",
                "use short or char as discriminator",
            )
        name = self._name(union.simple_name)
        self._line(f"union {name} switch ({self._type(used)}) {{", deeper)
        for case in union.cases:
            labels = self._labels(union, case.labels, case.is_default)
            self._member(case.member, labels + " ", deeper + 1)
        self._line("};", deeper)

    # -- interfaces ----------------------------------------------------------------------------

    def _interface(self, interface: Interface, inside: list[AnyDeclaration]) -> None:
        self._at = interface.facts.location
        self._doc(interface.facts)
        bases = ", ".join(self._full(base) for base in interface.bases)
        name = self._name(interface.simple_name)
        self._line(f"interface {name}{' : ' if bases else ''}{bases} {{")
        for declaration in inside:
            for needed in self._missing((declaration,)):
                self._forward(needed, 1)
            self._declared.add(declaration.name)
            self._declaration(declaration, 1)
        self._aliases: dict[Type, str] = {}
        self._taken = {
            part.lower()
            for i in self._model.with_bases(interface)
            for part in (*(m.name for m in i.members), *(n.rpartition("::")[2] for n in i.nested))
        }
        for member in interface.members:
            self._at = member.facts.location
            if isinstance(member, Attribute):
                self._attribute(member)
            else:
                self._operation(member)
        self._line("};")

    def _named(self, used: Type, name: str, of: str) -> str:
        """Returns the name of a type. For a sequence, prints a typedef first, because CORBA allows
        a sequence here only under a name."""
        if not isinstance(used, SequenceType):
            return self._type(used)
        if used not in self._aliases:
            alias = f"{of}_{name}_seq" if name else f"{of}_seq"
            while alias.lower() in self._taken:
                alias += "_"
            self._taken.add(alias.lower())
            self._aliases[used] = alias
            self._line(f"typedef {self._type(used)} {alias};", 1)
        return self._aliases[used]

    def _attribute(self, attribute: Attribute) -> None:
        if attribute.streams_in:
            self._cannot(
                "a stream that clients send", "declare an operation with the sample as a parameter"
            )
        if attribute.get_raises or attribute.set_raises:
            self._cannot("exceptions of an attribute", "declare operations that get and set")
        if attribute.optional:
            self._no_optional()
        used = self._named(attribute.type, "", attribute.name)
        self._doc(attribute.facts, 1)
        readonly = "readonly " if attribute.readonly else ""
        unit = f"  // {attribute.unit}" if attribute.unit else ""
        self._line(f"{readonly}attribute {used} {self._name(attribute.name)};{unit}", 1)

    def _operation(self, operation: Operation) -> None:
        if operation.is_event:
            self._cannot("an event", "declare an interface that subscribers implement")
        if operation.result_optional or any(p.optional for p in operation.parameters):
            self._no_optional()
        result = "void"
        if operation.result is not None:
            result = self._named(operation.result, "", operation.name)
        parameters = []
        for p in operation.parameters:
            used = self._named(p.type, p.name, operation.name)
            parameters.append(f"{p.direction.value} {used} {self._name(p.name)}")
        self._doc(operation.facts, 1)
        oneway = "oneway " if operation.oneway else ""
        raised = ", ".join(self._full(name) for name in operation.raises)
        raises = f" raises ({raised})" if raised else ""
        name = self._name(operation.name)
        text = f"{oneway}{result} {name}({', '.join(parameters)}){raises};"
        self._line(text + _units_of(operation), 1)


def _units_of(operation: Operation) -> str:
    said = [f"{p.name} in {p.unit}" for p in operation.parameters if p.unit]
    if operation.result_unit:
        said.append(f"gives {operation.result_unit}")
    return f"  // {', '.join(said)}" if said else ""
