"""The views of `<file>_types.{hpp,cpp}`: one dataclass per template."""

from __future__ import annotations

from dataclasses import dataclass

from gidl.model import (
    SequenceType,
    StringType,
    Type,
)


@dataclass(frozen=True, slots=True)
class EnumeratorView:
    name: str
    value: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EnumView:
    kind: str  # always "enum"
    name: str
    doc: tuple[str, ...]
    underlying: str
    enumerators: tuple[EnumeratorView, ...]
    unknown: str  # enumerator that replaces an unknown number; "" if such a number is refused
    words: tuple[tuple[str, str], ...]  # pairs of enumerator and its IDL name
    cases: tuple[str, ...]  # lines with the `case` labels of all enumerators
    known: str  # the enumerators, for the message about an unknown number


@dataclass(frozen=True, slots=True)
class MaskView:
    kind: str  # always "mask"
    name: str
    doc: tuple[str, ...]
    underlying: str
    wire: str
    flags: tuple[EnumeratorView, ...]
    all_bits: str  # mask of the bits that may be set


@dataclass(frozen=True, slots=True)
class BitsView:
    kind: str  # always "bits"
    name: str
    doc: tuple[str, ...]
    wire: str
    unsigned: str
    fields: tuple[FieldView, ...]
    pack: tuple[str, ...]
    unpack: tuple[str, ...]
    check: tuple[str, ...]
    printed: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FieldView:
    type: str
    name: str
    initial: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PrintView:
    label: str  # text before the value: "speed="
    value: str  # C++ expression; "" for a secret
    unit: str  # text after the value: " m", or ""


@dataclass(frozen=True, slots=True)
class CodecView:
    """Bodies of the functions that every struct and union has."""

    writer: str  # name of the encoder parameter; "" if nothing is written
    reader: str
    size: tuple[str, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    check: tuple[str, ...]  # empty if every value may be sent


@dataclass(frozen=True, slots=True)
class StructView:
    kind: str  # always "struct"
    name: str
    type_name: str
    doc: tuple[str, ...]
    base: str  # " : Base", or "" for a struct without base
    fields: tuple[FieldView, ...]
    fingerprint: str  # "" for structs of several results
    codec: CodecView
    printed: tuple[str, ...]  # lines of arguments for gecos::wire::print_all


@dataclass(frozen=True, slots=True)
class ArmView:
    name: str
    type: str
    argument: str
    index: int
    tag: str  # label that the factory function sets as tag; not used if `several` is True
    several: bool  # True: no single label selects the arm; its factory function takes the tag
    secret: bool
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnionView:
    kind: str  # always "union"
    name: str
    type_name: str
    doc: tuple[str, ...]
    tag_type: str
    tag_initial: str
    value_type: str
    arms: tuple[ArmView, ...]
    secrets: str  # C++ test whether the arm of index `arm` is secret; "" if none is
    select: tuple[str, ...]  # body of the function that maps a tag to an index of the variant
    fingerprint: str
    codec: CodecView


@dataclass(frozen=True, slots=True)
class AliasView:
    kind: str  # always "alias"
    name: str
    doc: tuple[str, ...]
    type: str


@dataclass(frozen=True, slots=True)
class ConstantView:
    kind: str  # always "constant"
    name: str
    doc: tuple[str, ...]
    type: str
    value: str


@dataclass(frozen=True, slots=True)
class MappedView:
    kind: str  # always "mapped"
    name: str
    header: str


TypeView = (
    EnumView | MaskView | BitsView | StructView | UnionView | AliasView | ConstantView | MappedView
)


@dataclass(frozen=True, slots=True)
class NamespaceView:
    name: str  # "robcl"; "" for the global namespace
    forward: tuple[str, ...]  # structs that are used before their definition
    types: tuple[TypeView, ...]


@dataclass(frozen=True, slots=True)
class TypesView:
    source: str  # "robcl/geometry.gidl"
    header: str  # "robcl/geometry_types.hpp"
    system_includes: tuple[str, ...]
    includes: tuple[str, ...]
    namespaces: tuple[NamespaceView, ...]


def printed(name: str, prints: list[PrintView], end: str = "") -> tuple[str, ...]:
    """Returns the arguments that print a value: literals and members in turn, for example
    `"Point{x=", value.x, " m}"`. If `end` is not empty, `end` is the last argument."""
    parts, literal = [], f"{name}{{"
    for i, each in enumerate(prints):
        literal += f"{', ' if i else ''}{each.label}"
        if each.value:
            parts += [f'"{literal}"', f"value.{each.value}"]
            literal = each.unit
        else:
            literal += "***"
    lines = [""]
    for part in [*parts, f'"{literal}}}"', *([end] if end else [])]:
        if lines[-1] and len(lines[-1]) + len(part) > 90:
            lines.append("")
        lines[-1] += f"{', ' if lines[-1] else ''}{part}"
    return (*(f"{line}," for line in lines[:-1]), f"{lines[-1]});")


def unit_of(used: Type) -> str | None:
    return used.unit if isinstance(used, SequenceType) else None


def bound_of(used: Type) -> int | None:
    return used.bound if isinstance(used, SequenceType | StringType) else None
