"""Layouts of generated types: each type states its layout once, and all else follows from it.

    @layout.struct(0xE3695E149ACAA4EA, "dd??", layout.text(), open=True)
    @dataclass(slots=True)
    class GripperState(layout.Struct):
        width: float = 0.0
        ...

A layout is its members in order, in *steps*: codes of numbers as for `wire.Fields`, any number of
them in one text; a type with a layout of its own; a function that gives a type that Python does
not know yet; or what a function below gives. From it come encoding and decoding with all checks,
`==` where arrays are held, JSON, what hides secrets, and what the extension is told, which does the
usual case in one go (`gecos.wire.plans`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum, IntFlag
from typing import Any, ClassVar, Self, TypeAlias, TypeVar

from gecos.wire import plans
from gecos.wire.codes import MAX_COUNT, MAX_TEXT
from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts
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


def ranged(code: str, low: float | None, high: float | None = None) -> Kind:
    """A number within limits; None leaves a side open."""
    return Ranged(code, low, high)


def char() -> Kind:
    return Char()


def text(most: int = MAX_TEXT) -> Kind:
    return Text(most)


def octets(most: int = MAX_COUNT, low: int | None = None, high: int | None = None) -> Kind:
    return Octets(most, low=low, high=high)


def fixed_octets(size: int, low: int | None = None, high: int | None = None) -> Kind:
    return Octets(size=size, low=low, high=high)


def numbers(
    code: str, most: int = MAX_COUNT, low: float | None = None, high: float | None = None
) -> Kind:
    """A sequence of numbers, in numpy."""
    return Numbers(code, most, low, high)


def array(code: str, *shape: int, low: float | None = None, high: float | None = None) -> Kind:
    return Array(code, shape, low, high)


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
    """An arm of a union and the tags that select it; without tags, all others do."""
    return Arm(name, kind_of(step), tags)


class Encoded:
    """The methods of generated values."""

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
        """Number of the arm that a tag selects, from 1; 0 for none."""
        number: int = cls._gecos_layout.selected(tag)
        return number


class Bits:
    """A bitset."""

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
    if layout.holds_array and kind.__hash__ is None:  # else it is equal to itself alone
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
    """Tells of a dataclass what its members are, in the order of its constructor.

    An older writer leaves out as many of the last as `missing` says, which then have their
    defaults; when it is `open`, what a newer writer added is skipped. A `deep` one may hold itself.
    `label` is what messages call it where that is not its name, and `names` are the interface's of
    members that Python calls otherwise.
    """

    def tell(kind: _KindT) -> _KindT:
        layout = StructLayout(kind, fingerprint, steps, missing, open, deep, label, names or {})
        _describe(kind, layout)
        if plans.COMPILED:
            plans.compile_struct(layout, fingerprint)
        return kind

    return tell


def result(
    *steps: Step, missing: int = 0, names: Mapping[str, str] | None = None
) -> Callable[[_KindT], _KindT]:
    """The same of what an operation gives that gives several values: it grows, and is the whole of
    a reply, so it needs no block."""

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
) -> Callable[[_KindT], _KindT]:
    """The same of a declared exception with this scoped name, which is equal to itself alone."""

    def tell(kind: _KindT) -> _KindT:
        kind._gecos_name = name
        _describe(
            kind, StructLayout(kind, fingerprint, steps, missing, open, False, label, names or {})
        )
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
    """The same of what stands for `of`, which is written by hand and has these bytes."""

    def tell(kind: _KindT) -> _KindT:
        _describe(kind, StructLayout(kind, None, steps, missing, open, False, label, names or {}))
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
    """Tells of a dataclass with `tag` and `value` which arms it has; `tag` is an enum or a code."""

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
    """Layout of a bitset in a number of this code: position, width and code of each member."""

    def tell(kind: _KindT) -> _KindT:
        kind._gecos_layout = BitsLayout(kind, code, members, label, names or {})
        return kind

    return tell


def enumeration(
    code: str, otherwise: str | None = None, names: Mapping[str, str] | None = None
) -> Callable[[_EnumT], _EnumT]:
    """Layout of an enum; the enumerator `otherwise` stands for unknown numbers."""

    def tell(kind: _EnumT) -> _EnumT:
        unknown = None if otherwise is None else kind[otherwise]
        kind._gecos_layout = Enumerators(kind, code, unknown, names or {})  # type: ignore[attr-defined]
        return kind

    return tell


def flags(
    code: str, count: int, names: Mapping[str, str] | None = None
) -> Callable[[_FlagsT], _FlagsT]:
    """Layout of a bitmask whose lowest `count` bits may be set."""

    def tell(kind: _FlagsT) -> _FlagsT:
        kind._gecos_layout = Flags(kind, code, count, names or {})  # type: ignore[attr-defined]
        return kind

    return tell
