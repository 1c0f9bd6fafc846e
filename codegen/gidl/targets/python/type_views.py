"""The views of `<file>_types.py`: one dataclass per template."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EnumeratorView:
    name: str
    value: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EnumView:
    kind: str  # "enum" or "mask"
    name: str
    layout: str  # "_layout.enumeration(…)"
    doc: tuple[str, ...]
    enumerators: tuple[EnumeratorView, ...]


@dataclass(frozen=True, slots=True)
class FieldView:
    name: str
    hint: str
    default: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StructView:
    kind: str  # always "struct"
    name: str
    role: str  # "struct", "exception", "result" or "twin"
    layout: str  # "_layout.struct(…)"
    doc: tuple[str, ...]
    fields: tuple[FieldView, ...]


@dataclass(frozen=True, slots=True)
class ArmView:
    name: str
    maker: str  # name of the factory method, for example "make_circle"
    hint: str
    tag: str
    several: bool
    index: int
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnionView:
    kind: str  # always "union"
    name: str
    layout: str  # "_layout.union(…)"
    doc: tuple[str, ...]
    tag_hint: str
    tag_default: str
    value_hint: str
    arms: tuple[ArmView, ...]


@dataclass(frozen=True, slots=True)
class BitsView:
    kind: str  # always "bits"
    name: str
    layout: str  # "_layout.bits(…)"
    doc: tuple[str, ...]
    fields: tuple[FieldView, ...]


@dataclass(frozen=True, slots=True)
class AliasView:
    kind: str  # always "alias"
    name: str
    doc: tuple[str, ...]
    hint: str


@dataclass(frozen=True, slots=True)
class ConstantView:
    kind: str  # always "constant"
    name: str
    doc: tuple[str, ...]
    hint: str
    value: str


TypeView = EnumView | StructView | UnionView | BitsView | AliasView | ConstantView


@dataclass(frozen=True, slots=True)
class TypesView:
    source: str
    doc: tuple[str, ...]
    standard: tuple[str, ...]  # import lines of the standard library
    imports: tuple[str, ...]  # import lines of gecos, hand-written types and other files
    numpy: tuple[str, ...]  # imports of numpy, only for type checkers
    types: tuple[TypeView, ...]
    exported: tuple[str, ...]
