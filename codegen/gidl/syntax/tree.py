"""The syntax tree of one file, as written: names are not yet looked up, and expressions are not yet
computed."""

from __future__ import annotations

from dataclasses import dataclass, field

from gidl.diagnostics.source import Span


@dataclass(frozen=True, slots=True)
class Name:
    """The identifier that a declaration declares."""

    text: str
    span: Span
    escaped: bool = False


@dataclass(frozen=True, slots=True)
class ScopedName:
    parts: tuple[str, ...]
    absolute: bool
    span: Span

    def __str__(self) -> str:
        return ("::" if self.absolute else "") + "::".join(self.parts)


# ---------------------------------------------------------------------------------------------
# Expressions


@dataclass(frozen=True, slots=True)
class Literal:
    value: bool | int | float | str
    kind: str  # one of "bool" "int" "float" "string" "char"
    span: Span


@dataclass(frozen=True, slots=True)
class NameUse:
    name: ScopedName
    span: Span


@dataclass(frozen=True, slots=True)
class Unary:
    operator: str
    operand: Expression
    span: Span


@dataclass(frozen=True, slots=True)
class Binary:
    operator: str
    left: Expression
    right: Expression
    span: Span


@dataclass(frozen=True, slots=True)
class RefusedValue:
    """The use of a macro with parameters. The preprocessor has already reported the macro."""

    span: Span


Expression = Literal | NameUse | Unary | Binary | RefusedValue


@dataclass(frozen=True, slots=True)
class AnnotationUse:
    name: ScopedName
    arguments: tuple[tuple[Name | None, Expression], ...]
    span: Span


# ---------------------------------------------------------------------------------------------
# Types


@dataclass(frozen=True, slots=True)
class BasicType:
    """A primitive type, by its name in the model: for example "uint32" for `unsigned long`."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class RefusedType:
    """A type of the IDL standard that is not part of .gidl. The parser has already reported the
    type."""

    span: Span


@dataclass(frozen=True, slots=True)
class TypeUse:
    name: ScopedName
    span: Span


@dataclass(frozen=True, slots=True)
class StringOf:
    bound: Expression | None
    span: Span


@dataclass(frozen=True, slots=True)
class SequenceOf:
    element: TypeSyntax
    bound: Expression | None
    annotations: tuple[AnnotationUse, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class MapOf:
    key: TypeSyntax
    value: TypeSyntax
    bound: Expression | None
    span: Span


@dataclass(frozen=True, slots=True)
class InlineType:
    """A type that is declared where it is used: by a member, a typedef, or the discriminator of a
    union."""

    declaration: ConstructedSyntax
    span: Span


TypeSyntax = BasicType | RefusedType | TypeUse | StringOf | SequenceOf | MapOf | InlineType


@dataclass(frozen=True, slots=True)
class Declarator:
    name: Name
    dimensions: tuple[Expression, ...] = ()


# ---------------------------------------------------------------------------------------------
# Declarations


@dataclass(slots=True)
class Extras:
    """The annotations and the documentation of a declaration."""

    annotations: list[AnnotationUse] = field(default_factory=list)
    doc: str = ""


@dataclass(slots=True)
class MemberSyntax:
    type: TypeSyntax
    declarators: list[Declarator]
    extras: Extras


@dataclass(slots=True)
class StructSyntax:
    name: Name
    base: ScopedName | None
    members: list[MemberSyntax]
    extras: Extras
    is_exception: bool = False


@dataclass(slots=True)
class CaseSyntax:
    labels: list[Expression]
    default: Span | None
    member: MemberSyntax


@dataclass(slots=True)
class UnionSyntax:
    name: Name
    discriminator: TypeSyntax
    cases: list[CaseSyntax]
    extras: Extras


@dataclass(slots=True)
class NamedItem:
    """An enumerator, or a flag of a bitmask."""

    name: Name
    extras: Extras


@dataclass(slots=True)
class EnumSyntax:
    name: Name
    items: list[NamedItem]
    extras: Extras


@dataclass(slots=True)
class BitmaskSyntax:
    name: Name
    items: list[NamedItem]
    extras: Extras


@dataclass(slots=True)
class BitfieldSyntax:
    width: Expression
    type: BasicType | RefusedType | None
    names: list[Name]  # an empty list means padding bits
    extras: Extras
    span: Span


@dataclass(slots=True)
class BitsetSyntax:
    name: Name
    base: ScopedName | None
    fields: list[BitfieldSyntax]
    extras: Extras


ConstructedSyntax = StructSyntax | UnionSyntax | EnumSyntax | BitmaskSyntax | BitsetSyntax


@dataclass(slots=True)
class TypedefSyntax:
    type: TypeSyntax
    declarators: list[Declarator]
    extras: Extras


@dataclass(slots=True)
class ConstSyntax:
    type: TypeSyntax
    name: Name
    value: Expression
    extras: Extras


@dataclass(slots=True)
class ForwardSyntax:
    kind: str  # one of "struct" "union" "interface"
    name: Name


@dataclass(slots=True)
class RefusedSyntax:
    """A declaration that is not part of .gidl. The parser has reported the declaration. Its name is
    kept, so that uses of the name are not reported as unknown."""

    name: Name


@dataclass(slots=True)
class ParameterSyntax:
    direction: str
    type: TypeSyntax
    name: Name
    extras: Extras


@dataclass(slots=True)
class OperationSyntax:
    name: Name
    oneway: bool
    result: TypeSyntax | None  # None: void
    parameters: list[ParameterSyntax]
    raises: list[ScopedName]
    extras: Extras


@dataclass(slots=True)
class AttributeSyntax:
    names: list[Name]
    readonly: bool
    type: TypeSyntax
    get_raises: list[ScopedName]
    set_raises: list[ScopedName]
    extras: Extras


@dataclass(slots=True)
class InterfaceSyntax:
    name: Name
    bases: list[ScopedName]
    body: list[DeclarationSyntax]
    extras: Extras


@dataclass(slots=True)
class ModuleSyntax:
    name: Name
    body: list[DeclarationSyntax]
    extras: Extras


@dataclass(slots=True)
class AnnotationParameterSyntax:
    name: Name
    type: TypeSyntax | None  # None: the type `any`
    default: Expression | None


@dataclass(slots=True)
class AnnotationSyntax:
    """An annotation that is declared with @annotation. `body` holds its enums, constants and
    typedefs."""

    name: Name
    parameters: list[AnnotationParameterSyntax]
    body: list[DeclarationSyntax]
    extras: Extras


@dataclass(slots=True)
class ImportSyntax:
    name: ScopedName


@dataclass(slots=True)
class RepositorySyntax:
    """A `typeid` or `typeprefix` declaration."""

    kind: str
    name: ScopedName
    text: str


DeclarationSyntax = (
    ModuleSyntax | StructSyntax | UnionSyntax | EnumSyntax | BitmaskSyntax | BitsetSyntax
    | TypedefSyntax | ConstSyntax | ForwardSyntax | InterfaceSyntax | OperationSyntax
    | AttributeSyntax | AnnotationSyntax | ImportSyntax | RepositorySyntax | RefusedSyntax
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Include:
    path: str
    angled: bool
    span: Span
    # True if the file that contains this `#include` has an include guard or #pragma once before the
    # `#include`. That file may then be part of an include cycle.
    protected: bool = False


@dataclass(slots=True)
class FileSyntax:
    includes: list[Include] = field(default_factory=list)
    body: list[DeclarationSyntax] = field(default_factory=list)
    doc: str = ""
    uses_object: bool = False  # True: the file uses the type `Object`
