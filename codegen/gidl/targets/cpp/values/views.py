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
    kind: str  # "enum"
    name: str
    doc: tuple[str, ...]
    underlying: str
    enumerators: tuple[EnumeratorView, ...]
    unknown: str  # what an unknown number becomes; "" refuses it
    words: tuple[tuple[str, str], ...]  # enumerator, its IDL name


@dataclass(frozen=True, slots=True)
class MaskView:
    kind: str  # "mask"
    name: str
    doc: tuple[str, ...]
    underlying: str
    wire: str
    flags: tuple[EnumeratorView, ...]
    all_bits: str  # bits that may be set


@dataclass(frozen=True, slots=True)
class BitsView:
    kind: str  # "bits"
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
    label: str  # "speed="
    value: str  # expression; "" for a secret
    unit: str  # " m", or ""


@dataclass(frozen=True, slots=True)
class CodecView:
    """Bodies of the functions that every struct and union has."""

    writer: str  # name of the encoder parameter; "" where nothing is written
    reader: str
    size: tuple[str, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    check: tuple[str, ...]  # empty: every value may be sent


@dataclass(frozen=True, slots=True)
class StructView:
    kind: str  # "struct"
    name: str
    type_name: str
    doc: tuple[str, ...]
    base: str  # ": Base" or ""
    fields: tuple[FieldView, ...]
    fingerprint: str  # "" for what is no declared type
    codec: CodecView
    # Arguments of gecos::wire::print_all, over lines; empty: it is neither printed nor compared.
    printed: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ArmView:
    name: str
    type: str
    argument: str
    index: int
    tag: str  # the label that selects it when none is named
    several: bool  # more than one label selects it: the maker takes the tag
    secret: bool
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnionView:
    kind: str  # "union"
    name: str
    type_name: str
    doc: tuple[str, ...]
    tag_type: str
    tag_initial: str
    value_type: str
    arms: tuple[ArmView, ...]
    secrets: str  # which values of `arm` are secret, as a test; "" where none is
    select: tuple[str, ...]  # body of the function from tag to index of the variant
    fingerprint: str
    codec: CodecView


@dataclass(frozen=True, slots=True)
class AliasView:
    kind: str  # "alias"
    name: str
    doc: tuple[str, ...]
    type: str


@dataclass(frozen=True, slots=True)
class ConstantView:
    kind: str  # "constant"
    name: str
    doc: tuple[str, ...]
    type: str
    value: str


@dataclass(frozen=True, slots=True)
class MappedView:
    kind: str  # "mapped"
    name: str
    header: str


TypeView = (
    EnumView | MaskView | BitsView | StructView | UnionView | AliasView | ConstantView | MappedView
)


@dataclass(frozen=True, slots=True)
class NamespaceView:
    name: str  # "robcl"; "" at the top
    forward: tuple[str, ...]  # structs that are used before they are declared
    types: tuple[TypeView, ...]


@dataclass(frozen=True, slots=True)
class TypesView:
    source: str  # "robcl/geometry.gidl"
    header: str  # "robcl/geometry_types.hpp"
    system_includes: tuple[str, ...]
    includes: tuple[str, ...]
    namespaces: tuple[NamespaceView, ...]


def printed(name: str, prints: list[PrintView]) -> tuple[str, ...]:
    """Literals and values in turn: `"Point{x=", value.x, " m}"`."""
    parts, literal = [], f"{name}{{"
    for i, each in enumerate(prints):
        literal += f"{', ' if i else ''}{each.label}"
        if each.value:
            parts += [f'"{literal}"', f"value.{each.value}"]
            literal = each.unit
        else:
            literal += "***"
    lines = [""]
    for part in [*parts, f'"{literal}}}"']:
        if len(lines[-1]) + len(part) > 90:
            lines.append("")
        lines[-1] += f"{', ' if lines[-1] else ''}{part}"
    return (*(f"{line}," for line in lines[:-1]), f"{lines[-1]});")


def unit_of(used: Type) -> str | None:
    return used.unit if isinstance(used, SequenceType) else None


def bound_of(used: Type) -> int | None:
    return used.bound if isinstance(used, SequenceType | StringType) else None
