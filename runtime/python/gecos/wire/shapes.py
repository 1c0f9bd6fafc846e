"""What values are made of, member by member, and how each kind stands in JSON.

Generated types describe themselves by these; `gecos.wire.json` reads and writes with them. `plain`
gives what the module json can dump; `made` is its inverse and raises `JsonError`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum, IntFlag
from typing import Any, Protocol

from gecos.wire.codes import CODE_MEANING, WRITERS, native
from gecos.wire.errors import HIDDEN
from gecos.wire.values import as_array

_WIDTHS = (8, 16, 32, 64)
_LIMITS = {c: (-(1 << n - 1), (1 << n - 1) - 1) for c, n in zip("bhiq", _WIDTHS, strict=True)}
_LIMITS |= {c: (0, (1 << n) - 1) for c, n in zip("BHIQ", _WIDTHS, strict=True)}
_NOT_FINITE = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


class JsonError(ValueError):
    """Text that is not the JSON of its type: where in the value, and why."""

    def __init__(self, path: str, why: str) -> None:
        super().__init__(f"{path}: {why}" if path else why)
        self.path = path
        self.why = why

    def __reduce__(self) -> tuple[type[JsonError], tuple[str, str]]:
        return JsonError, (self.path, self.why)


class Shape(Protocol):
    def plain(self, value: Any) -> Any: ...
    def made(self, data: Any, path: str) -> Any: ...


def _shown(data: Any) -> str:
    names = {dict: "an object", list: "a list", str: "a text", bool: "a boolean"}
    return "null" if data is None else names.get(type(data), "a number")


def _expect(kind: type, data: Any, path: str, wanted: str) -> None:
    if type(data) is not kind:
        raise JsonError(path, f"{wanted} is expected, {_shown(data)} is there")


def _below(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


@dataclass(frozen=True, slots=True)
class Number:
    """`code` is that of `wire.Fields`. What JSON has no number for is "nan", "inf" or "-inf"."""

    code: str

    def plain(self, value: Any) -> Any:
        if self.code == "?":
            return bool(value)
        if self.code not in "fd":
            return int(value)
        number = float(value)
        return number if math.isfinite(number) else str(number)

    def made(self, data: Any, path: str) -> Any:
        if self.code == "?":
            _expect(bool, data, path, "a boolean")
            return data
        if self.code in "fd":
            return self._floating(data, path)
        _expect(int, data, path, "a whole number")
        low, high = _LIMITS[self.code]
        if not low <= data <= high:
            raise JsonError(path, f"{data} is not {CODE_MEANING[self.code]}")
        return data

    def _floating(self, data: Any, path: str) -> float:
        if type(data) is str and data in _NOT_FINITE:
            return _NOT_FINITE[data]
        if type(data) not in (int, float):
            raise JsonError(path, f"a number is expected, {_shown(data)} is there")
        try:
            WRITERS[self.code].pack(data)
            return float(data)
        except OverflowError:
            raise JsonError(path, f"{data} is not {CODE_MEANING[self.code]}") from None


@dataclass(frozen=True, slots=True)
class Text:
    characters: int | None = None  # 1 for a char

    def plain(self, value: Any) -> Any:
        return value

    def made(self, data: Any, path: str) -> Any:
        _expect(str, data, path, "a text")
        if self.characters is not None and (len(data) != self.characters or data > "\xff"):
            raise JsonError(path, "one character of Latin-1 is expected")
        return data


@dataclass(frozen=True, slots=True)
class Enumerators:
    """By name; `renamed` are those that Python calls otherwise."""

    kind: type[IntEnum]
    renamed: Mapping[str, str] = field(default_factory=dict)

    def plain(self, value: Any) -> Any:
        name = self.kind(value).name
        return self.renamed.get(name, name)

    def made(self, data: Any, path: str) -> Any:
        _expect(str, data, path, "a name")
        for each in self.kind:
            if self.renamed.get(each.name, each.name) == data:
                return each
        known = ", ".join(self.plain(each) for each in self.kind)
        raise JsonError(path, f"there is no {data}; there are {known}")


@dataclass(frozen=True, slots=True)
class Flags:
    """The list of the flags that are set."""

    kind: type[IntFlag]
    renamed: Mapping[str, str] = field(default_factory=dict)

    def _named(self) -> dict[str, IntFlag]:
        members = self.kind.__members__.items()
        return {self.renamed.get(name, name): flag for name, flag in members}

    def plain(self, value: Any) -> Any:
        return [name for name, flag in self._named().items() if flag in self.kind(value)]

    def made(self, data: Any, path: str) -> Any:
        _expect(list, data, path, "a list of flags")
        named, whole = self._named(), self.kind(0)
        for i, each in enumerate(data):
            if type(each) is not str or each not in named:
                raise JsonError(f"{path}[{i}]", f"there is no {each}; there are {', '.join(named)}")
            whole |= named[each]
        return whole


@dataclass(frozen=True, slots=True)
class Optional:
    inner: Shape

    def plain(self, value: Any) -> Any:
        return None if value is None else self.inner.plain(value)

    def made(self, data: Any, path: str) -> Any:
        return None if data is None else self.inner.made(data, path)


@dataclass(frozen=True, slots=True)
class Items:
    """A list; `size` that of an array."""

    inner: Shape
    size: int | None = None

    def plain(self, value: Any) -> Any:
        return [self.inner.plain(each) for each in value]

    def made(self, data: Any, path: str) -> Any:
        _expect(list, data, path, "a list")
        if self.size is not None and len(data) != self.size:
            raise JsonError(path, f"{self.size} elements are expected, {len(data)} are there")
        return [self.inner.made(each, f"{path}[{i}]") for i, each in enumerate(data)]


@dataclass(frozen=True, slots=True)
class Octets:
    """Bytes, in JSON the list of their numbers."""

    size: int | None = None

    def plain(self, value: Any) -> Any:
        return list(value)

    def made(self, data: Any, path: str) -> Any:
        return bytes(Items(Number("B"), self.size).made(data, path))


@dataclass(frozen=True, slots=True)
class Array:
    """Numbers in numpy; `shape` that of an array, None for a sequence."""

    code: str
    shape: tuple[int, ...] | None = None

    def _list(self) -> Shape:
        whole: Shape = Number(self.code)
        for size in reversed(self.shape or (None,)):
            whole = Items(whole, size)
        return whole

    def plain(self, value: Any) -> Any:
        return self._list().plain(as_array(value, self.code).tolist())

    def made(self, data: Any, path: str) -> Any:
        import numpy as np

        return np.array(self._list().made(data, path), native(self.code))


@dataclass(frozen=True, slots=True)
class Entries:
    """A map: the list of pairs of key and value, as they are sorted on the wire."""

    key: Shape
    value: Shape

    def plain(self, value: Any) -> Any:
        return [[self.key.plain(k), self.value.plain(value[k])] for k in sorted(value)]

    def made(self, data: Any, path: str) -> Any:
        _expect(list, data, path, "a list of pairs")
        entries = {}
        for i, pair in enumerate(data):
            at = f"{path}[{i}]"
            if type(pair) is not list or len(pair) != 2:
                raise JsonError(at, "a pair of key and value is expected")
            key = self.key.made(pair[0], at)
            if key in entries:
                raise JsonError(at, "its key was there before")
            entries[key] = self.value.made(pair[1], at)
        return entries


def _expect_told(data: Any, path: str) -> None:
    if data == HIDDEN:
        raise JsonError(path, "it was hidden when this was written; say it, or leave it out")


@dataclass(frozen=True, slots=True)
class Secret:
    """What is not shown."""

    inner: Shape

    def plain(self, value: Any) -> Any:
        return HIDDEN

    def made(self, data: Any, path: str) -> Any:
        _expect_told(data, path)
        return self.inner.made(data, path)


@dataclass(frozen=True, slots=True)
class Member:
    name: str  # in the interface
    shape: Shape
    attribute: str = ""  # in Python, where it is another
    secret: bool = False


@dataclass(frozen=True, slots=True)
class Members:
    """A struct. What is left out has its default; what nobody knows is an error."""

    kind: Callable[..., Any]
    members: Sequence[Member]

    def plain(self, value: Any) -> Any:
        return {
            m.name: HIDDEN if m.secret else m.shape.plain(getattr(value, m.attribute or m.name))
            for m in self.members
        }

    def made(self, data: Any, path: str) -> Any:
        _expect(dict, data, path, "an object")
        known = [m.name for m in self.members]
        for name in sorted(data.keys() - known):
            why = f"there is no such member; there are {', '.join(known)}"
            raise JsonError(_below(path, name), why)
        given = {}
        for member in self.members:
            if member.name not in data:
                continue
            at, each = _below(path, member.name), data[member.name]
            if member.secret:
                _expect_told(each, at)
            given[member.attribute or member.name] = member.shape.made(each, at)
        return self.kind(**given)


@dataclass(frozen=True, slots=True)
class Arms:
    """A union: {"tag": …, "value": …}, without value where the tag selects nothing."""

    kind: Any
    tag: Shape
    arms: Sequence[Shape]

    def plain(self, value: Any) -> Any:
        arm = self.kind._arm(value.tag)
        tag = self.tag.plain(value.tag)
        return {"tag": tag, "value": self.arms[arm - 1].plain(value.value)} if arm else {"tag": tag}

    def made(self, data: Any, path: str) -> Any:
        _expect(dict, data, path, "an object")
        if "tag" not in data:
            raise JsonError(path, "its tag is missing")
        tag = self.tag.made(data["tag"], _below(path, "tag"))
        arm = self.kind._arm(tag)
        for name in sorted(data):
            if name != "tag" and not (arm and name == "value"):
                raise JsonError(_below(path, name), "this tag has no such member")
        if not arm:
            return self.kind(tag)
        if "value" not in data:
            raise JsonError(path, "what its tag selects is missing: value")
        return self.kind(tag, self.arms[arm - 1].made(data["value"], _below(path, "value")))


@dataclass(frozen=True, slots=True)
class Value:
    """A value of a generated type, or of a hand-written one that was described."""

    kind: Any

    def shape(self) -> Shape:
        found: Shape = described.get(self.kind) or self.kind._gecos_shape()
        return found

    def plain(self, value: Any) -> Any:
        return self.shape().plain(value)

    def made(self, data: Any, path: str) -> Any:
        return self.shape().made(data, path)


described: dict[Any, Shape] = {}
"""Shapes of hand-written types, told by the generated module of the interface that maps to them."""


@dataclass(frozen=True, slots=True)
class Layout:
    """A hand-written type, by way of the bytes that it shares with the declared struct."""

    kind: Any
    struct: Any  # its generated twin

    def plain(self, value: Any) -> Any:
        from gecos.wire.contents import from_bytes, to_bytes

        return Value(self.struct).plain(from_bytes(self.struct, to_bytes(value)))

    def made(self, data: Any, path: str) -> Any:
        from gecos.wire.contents import from_bytes, to_bytes
        from gecos.wire.errors import DecodeError

        twin = Value(self.struct).made(data, path)
        try:
            return from_bytes(self.kind, to_bytes(twin))
        except DecodeError as error:
            raise JsonError(path, error.problem.value) from None
