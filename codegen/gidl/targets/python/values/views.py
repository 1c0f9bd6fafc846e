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
    doc: tuple[str, ...]
    enumerators: tuple[EnumeratorView, ...]


@dataclass(frozen=True, slots=True)
class FieldView:
    name: str
    hint: str
    default: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class RunView:
    name: str  # "_HOLDER_1"
    codes: str
    labels: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StructView:
    kind: str  # "struct"
    name: str
    base: str  # "(_DeclaredError)" or ""
    decorator: str
    scoped_name: str
    is_exception: bool
    doc: tuple[str, ...]
    fields: tuple[FieldView, ...]
    runs: tuple[RunView, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    fingerprint: str  # "" for what is no declared type
    equal: tuple[str, ...]  # comparisons, where arrays need help
    shape: tuple[str, ...]  # its members as gecos.wire.shapes has them
    plan: str  # decorator that tells gecos.wire.plans of its members; "" where it has no plan
    stands_for: str  # the hand-written type whose layout it has, or ""


@dataclass(frozen=True, slots=True)
class ArmView:
    name: str
    maker: str  # "make_circle"
    hint: str
    tag: str
    several: bool
    index: int
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnionView:
    kind: str  # "union"
    name: str
    doc: tuple[str, ...]
    tag_hint: str
    tag_default: str
    value_hint: str
    arms: tuple[ArmView, ...]
    select: tuple[str, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    fingerprint: str
    needs_same: bool
    secret_arms: tuple[int, ...]
    tag_shape: str
    arm_shapes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BitsFieldView:
    name: str
    hint: str
    default: str
    doc: tuple[str, ...]
    position: int
    width: int
    low: int
    high: int
    mask: str
    kind: str  # "bool", "unsigned", "signed"
    label: str


@dataclass(frozen=True, slots=True)
class BitsView:
    kind: str  # "bits"
    name: str
    doc: tuple[str, ...]
    code: str
    size: int
    used: str
    fields: tuple[BitsFieldView, ...]
    shape: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AliasView:
    kind: str  # "alias"
    name: str
    doc: tuple[str, ...]
    hint: str


@dataclass(frozen=True, slots=True)
class ConstantView:
    kind: str  # "constant"
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
    numpy: tuple[str, ...]  # only for type checkers
    types: tuple[TypeView, ...]
    exported: tuple[str, ...]
