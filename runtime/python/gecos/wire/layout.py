"""Layouts of generated types. A type declares its layout once, and the layout provides its methods.

    @layout.struct(0xE3695E149ACAA4EA, "dd??", layout.text(), open=True)
    @dataclass(slots=True)
    class GripperState(layout.Struct):
        width: float = 0.0
        ...

A layout lists the members in order, as *steps*. A step is one of these: a text with the codes of
one or more numbers, as in `wire.Fields`; a type with a layout of its own; a function that returns
a type that is declared later; or the result of a function below. A layout provides encoding and
decoding with all checks, `==` for values that hold arrays, JSON, and a `repr` without secrets. It
also provides the plan by which the C++ extension encodes and decodes the usual case
(`gecos.wire.plans`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum, IntFlag
from typing import Any, ClassVar, Self, TypeAlias, TypeVar

from gecos.wire import plans
from gecos.wire.codes import MAX_COUNT, MAX_TEXT
from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts
from gecos.wire.enums import printed_by_name
from gecos.wire.kinds import (
    Char,
    Enumerators,
    Flags,
    Kind,
    Ranged,
    Secret,
    Text,
    Twin,
    kind_of,
    twins,
)
from gecos.wire.members import BitsLayout, StructLayout
from gecos.wire.several import Array, Entries, Items, Numbers, Octets, Optional
from gecos.wire.unions import Arm, UnionLayout

Step: TypeAlias = str | type | Kind | Callable[[], Any]

_KindT = TypeVar("_KindT", bound=type[Any])
_EnumT = TypeVar("_EnumT", bound=type[IntEnum])
_FlagsT = TypeVar("_FlagsT", bound=type[IntFlag])


def ranged(code: str, low: float | None, high: float | None = None, unit: str = "") -> Kind:
    """Describes a number from `low` to `high`. None means that there is no limit on that side.
    Messages show the limits with `unit`."""
    return Ranged(code, low, high, unit)


def char() -> Kind:
    return Char()


def text(most: int = MAX_TEXT) -> Kind:
    return Text(most)


def octets(
    most: int = MAX_COUNT, low: int | None = None, high: int | None = None, unit: str = ""
) -> Kind:
    return Octets(most, low=low, high=high, unit=unit)


def fixed_octets(
    size: int, low: int | None = None, high: int | None = None, unit: str = ""
) -> Kind:
    return Octets(size=size, low=low, high=high, unit=unit)


def numbers(
    code: str,
    most: int = MAX_COUNT,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
) -> Kind:
    """Describes a sequence of numbers, which is kept as a numpy array."""
    return Numbers(code, most, low, high, unit)


def array(
    code: str,
    *shape: int,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
) -> Kind:
    return Array(code, shape, low, high, unit)


def items(inner: Step, most: int = MAX_COUNT) -> Kind:
    return Items(kind_of(inner), most)


def fixed_items(inner: Step, size: int) -> Kind:
    return Items(kind_of(inner), size=size)


def optional(inner: Step) -> Kind:
    return Optional(kind_of(inner))


def mapping(key: Step, value: Step, most: int = MAX_COUNT) -> Kind:
    return Entries(kind_of(key), kind_of(value), most)


def secret(inner: Step) -> Kind:
    return Secret(kind_of(inner))


def arm(name: str, step: Step, *tags: Any) -> Arm:
    """Describes an arm of a union, and the tags that select it. Without tags, the arm is selected
    by every tag that selects no other arm."""
    return Arm(name, kind_of(step), tags)


class Encoded:
    """The base class of generated types. Its methods encode and decode as the layout says."""

    __slots__ = ()
    _gecos_layout: ClassVar[Any]

    def encode(self, out: Parts, /) -> None:
        self._gecos_layout.encode(self, out)

    @classmethod
    def decode(cls, source: Decoder, /) -> Self:
        value: Self = cls._gecos_layout.decode(cls, source)
        return value


class Struct(Encoded):
    """A struct, exception or union that an interface declares."""

    __slots__ = ()

    @classmethod
    def fingerprint(cls) -> int:
        number: int = cls._gecos_layout.fingerprint
        return number


class Union(Struct):
    __slots__ = ()

    @classmethod
    def _arm(cls, tag: Any) -> int:
        """Returns the number of the arm that `tag` selects, counted from 1; 0 if `tag` selects no
        arm."""
        number: int = cls._gecos_layout.selected(tag)
        return number


class Bits:
    """The base class of generated bitsets."""

    __slots__ = ()
    _gecos_layout: ClassVar[BitsLayout]

    def pack(self) -> bytes:
        return self._gecos_layout.pack(self)

    @classmethod
    def unpack(cls, source: Decoder, label: str) -> Self:
        value: Self = cls._gecos_layout.unpack(cls, source, label)
        return value


def _describe(kind: Any, layout: StructLayout | UnionLayout) -> None:
    kind._gecos_layout = layout
    if isinstance(layout, StructLayout):
        kind.encode, kind.decode = layout.codecs()
    if layout.holds_array and kind.__hash__ is None:  # exceptions compare by identity
        kind.__eq__ = layout.equality()
    if layout.has_secrets:
        kind.__repr__ = layout.printing()


def struct(
    fingerprint: int,
    *steps: Step,
    missing: int = 0,
    open: bool = False,
    deep: bool = False,
    label: str = "",
    names: Mapping[str, str] | None = None,
) -> Callable[[_KindT], _KindT]:
    """Declares the members of a dataclass, in the order of its constructor.

    An older writer may omit the last `missing` members, which then get their default values. In an
    `open` struct, members added by a newer writer are skipped. A `deep` struct may contain values
    of its own type. `label` is the struct's name in messages, if its class has another name.
    `names` maps Python names of members to names in the interface where the two differ.
    """

    def tell(kind: _KindT) -> _KindT:
        layout = StructLayout(kind, fingerprint, steps, missing, open, deep, label, names or {})
        _describe(kind, layout)
        if plans.COMPILED:
            plans.compile_struct(layout, fingerprint)
        return kind

    return tell


def result(
    *steps: Step,
    missing: int = 0,
    names: Mapping[str, str] | None = None,
) -> Callable[[_KindT], _KindT]:
    """Declares the members of the result of an operation with several results. Such a result can be
    extended like an @appendable struct, but needs no block because it is a whole reply."""

    def tell(kind: _KindT) -> _KindT:
        layout = StructLayout(kind, None, steps, missing, True, False, "", names or {})
        layout.in_block = False
        _describe(kind, layout)
        return kind

    return tell


def exception(
    name: str,
    fingerprint: int,
    *steps: Step,
    missing: int = 0,
    open: bool = False,
    label: str = "",
    names: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Callable[[_KindT], _KindT]:
    """Declares the members of an exception with the scoped name `name`. Two exceptions are equal
    only if they are the same object. `units` maps the names of members in the interface to units,
    which the message of the exception shows."""

    def tell(kind: _KindT) -> _KindT:
        layout = StructLayout(kind, fingerprint, steps, missing, open, False, label, names or {})
        named = zip(layout.attributes, layout.names, strict=True)
        kind._gecos_name = name
        kind._gecos_units = {here: units[n] for here, n in named if n in units} if units else {}
        _describe(kind, layout)
        return kind

    return tell


def twin(
    of: Any,
    *steps: Step,
    missing: int = 0,
    open: bool = False,
    label: str = "",
    names: Mapping[str, str] | None = None,
) -> Callable[[_KindT], _KindT]:
    """Declares the members of a struct whose encoding equals that of the hand-written type `of`."""

    def tell(kind: _KindT) -> _KindT:
        layout = StructLayout(kind, None, steps, missing, open, False, label, names or {})
        _describe(kind, layout)
        twins[of] = Twin(of, kind)
        return kind

    return tell


def union(
    fingerprint: int,
    tag: Step,
    *arms: Arm,
    open: bool = False,
    deep: bool = False,
    label: str = "",
) -> Callable[[_KindT], _KindT]:
    """Declares a dataclass with `tag` and `value` as a union. The parameter `tag` is the step of
    the union's tag: an enum, or the code of a number."""

    def tell(kind: _KindT) -> _KindT:
        layout = UnionLayout(kind, fingerprint, kind_of(tag), arms, open, deep, label)
        _describe(kind, layout)
        return kind

    return tell


def bits(
    code: str,
    *members: tuple[int, int, str],
    label: str = "",
    names: Mapping[str, str] | None = None,
) -> Callable[[_KindT], _KindT]:
    """Declares a bitset that is encoded as one number with the code `code`. `members` are the
    position, width and code of each member."""

    def tell(kind: _KindT) -> _KindT:
        kind._gecos_layout = BitsLayout(kind, code, members, label, names or {})
        return kind

    return tell


def enumeration(
    code: str, otherwise: str | None = None, names: Mapping[str, str] | None = None
) -> Callable[[_EnumT], _EnumT]:
    """Declares the layout of an enum. The enumerator `otherwise` replaces unknown numbers."""

    def tell(kind: _EnumT) -> _EnumT:
        unknown = None if otherwise is None else kind[otherwise]
        kind._gecos_layout = Enumerators(kind, code, unknown, names or {})  # type: ignore[attr-defined]
        return printed_by_name(kind)

    return tell


def flags(
    code: str, count: int, names: Mapping[str, str] | None = None
) -> Callable[[_FlagsT], _FlagsT]:
    """Declares the layout of a bitmask. Only the lowest `count` bits may be set."""

    def tell(kind: _FlagsT) -> _FlagsT:
        kind._gecos_layout = Flags(kind, code, count, names or {})  # type: ignore[attr-defined]
        return kind

    return tell
