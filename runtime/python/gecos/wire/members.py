"""Sequences of named values: the members of a struct, the arguments of a call, or the fields of a
bitset."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from operator import attrgetter
from typing import Any, TypeAlias

from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, number
from gecos.wire.errors import JsonError, RangeError, expect
from gecos.wire.fields import Fields
from gecos.wire.kinds import Kind, Number, Secret, below, expect_json, kind_of
from gecos.wire.units import Range
from gecos.wire.values import same, signed

_Group: TypeAlias = tuple[int, int, Callable[..., Any], Callable[..., Any], str]
"""First and end index of a group of members, the functions that encode and decode the group, and
its label. A group is a run of numbers with the label "", or one member with its own label."""


class Members:
    """Members in the order of their encoding. `names` are their names in the interface; error
    texts call a member `label.name`. `defaults` are for the last members, which an older writer
    may omit.
    """

    __slots__ = ("_groups", "_needed", "defaults", "kinds", "label", "names")

    def __init__(
        self,
        label: str,
        names: Sequence[str],
        steps: Sequence[Any],
        defaults: Sequence[Any],
    ) -> None:
        self.label = label
        self.names = names
        self.kinds = [kind_of(each) for each in _single(steps)]
        if len(self.kinds) != len(names):
            raise TypeError(f"{label}: {len(self.kinds)} steps for {len(names)} members")
        self.defaults = defaults
        self._needed = len(names) - len(defaults)
        self._groups: list[_Group] = []

    @property
    def least(self) -> int:
        return sum(kind.least for kind in self.kinds)

    @property
    def holds_array(self) -> bool:
        return any(kind.holds_array for kind in self.kinds)

    def _grouped(self) -> list[_Group]:
        # Several threads may run this code at the same time, and no thread may see an incomplete
        # list.
        self._groups = groups = list(self._each_group())
        return groups

    def _each_group(self) -> Iterator[_Group]:
        kinds, labels = self.kinds, [f"{self.label}.{name}" for name in self.names]
        at, required = 0, self._needed
        while at < len(kinds):
            end = at
            while end < required and type(kinds[end]) is Number:
                end += 1
            if end > at:
                codes = "".join(kind.code for kind in kinds[at:end])  # type: ignore[attr-defined]
                run = Fields(codes, labels[at:end])
                yield at, end, run.pack, run.unpack, ""
                at = end
            else:
                yield at, at + 1, kinds[at].put, kinds[at].take, labels[at]
                at += 1

    def write(self, values: Sequence[Any], out: Parts) -> None:
        for at, end, put, _, label in self._groups or self._grouped():
            if label:
                put(values[at], out, label)
            else:
                out.append(put(*values[at:end]))

    def read(self, source: Decoder) -> list[Any]:
        values: list[Any] = []
        required = self._needed
        for at, _, _, take, label in self._groups or self._grouped():
            if not label:
                values += take(source)
            elif at < required or source.offset < source.end:
                values.append(take(source, label))
            else:
                values.append(self.defaults[at - required])
        return values

    def plain(self, values: Sequence[Any]) -> dict[str, Any]:
        """Converts the members to types that the module `json` can dump."""
        return {
            name: kind.plain(value)
            for name, kind, value in zip(self.names, self.kinds, values, strict=True)
        }

    def made(self, data: Any, path: str) -> list[tuple[int, Any]]:
        """Converts plain data back to members: returns the index and the value of each given
        member. Refuses unknown members."""
        expect_json(dict, data, path, "an object")
        for name in sorted(data.keys() - set(self.names)):
            why = f"unknown member; the known members are {', '.join(self.names)}"
            raise JsonError(below(path, name), why)
        return [
            (i, kind.made(data[name], below(path, name)))
            for i, (name, kind) in enumerate(zip(self.names, self.kinds, strict=True))
            if name in data
        ]


def _single(steps: Sequence[Any]) -> Iterator[Any]:
    for step in steps:
        if isinstance(step, str):
            yield from step
        else:
            yield step


class StructLayout(Members):
    """The layout of a dataclass; `gecos.wire.layout.struct` explains the parameters."""

    __slots__ = (
        "_deep",
        "_values",
        "attributes",
        "compiled",
        "fingerprint",
        "in_block",
        "kind",
        "open",
    )

    def __init__(
        self,
        kind: Any,
        fingerprint: int | None,
        steps: Sequence[Any],
        missing: int,
        open: bool,
        deep: bool,
        label: str,
        names: Mapping[str, str],
    ) -> None:
        members = fields(kind)
        self.attributes = [member.name for member in members]
        called = [names.get(name, name) for name in self.attributes]
        defaults = [member.default for member in members[len(members) - missing :]]
        super().__init__(label or kind.__name__, called, steps, defaults)
        self.kind = kind
        self.fingerprint = fingerprint
        self.open = open
        self.in_block = open
        self.compiled = False
        self._deep = deep
        self._values: Callable[[Any], Sequence[Any]] = _getter(self.attributes)

    def codecs(self) -> tuple[Any, Any]:
        """Returns the methods `encode` and `decode`."""
        values, write, read = self._values, self.write, self.read
        label, deep, open = self.label, self._deep, self.open

        def encode(self: Any, out: Parts, /) -> None:
            write(values(self), out)

        def decode(cls: Any, source: Decoder, /) -> Any:
            if deep:
                source.enter(label)
            members = read(source)
            if deep:
                source.leave()
            if open:
                source.offset = source.end  # skips members that a newer writer added
            return cls(*members)

        return encode, classmethod(decode)

    def plain(self, value: Any) -> dict[str, Any]:
        return super().plain(self._values(value))

    def made(self, data: Any, path: str) -> Any:
        """Converts plain data back to a value. Omitted members get their default values."""
        return self.kind(**{self.attributes[i]: each for i, each in super().made(data, path)})

    @property
    def has_secrets(self) -> bool:
        return any(type(each) is Secret for each in self.kinds)

    def printing(self) -> Callable[[Any], str]:
        """Returns a `__repr__` that leaves out secret members."""
        for member, each in zip(fields(self.kind), self.kinds, strict=True):
            member.repr = type(each) is not Secret

        def __repr__(self: Any) -> str:
            shown = (f"{m.name}={getattr(self, m.name)!r}" for m in fields(self) if m.repr)
            return f"{type(self).__qualname__}({', '.join(shown)})"

        return __repr__

    def equality(self) -> Callable[[Any, object], bool]:
        """Returns an `__eq__` for values that hold arrays."""
        kind, values = self.kind, self._values

        def __eq__(self: Any, other: object) -> bool:
            if not isinstance(other, kind):
                return NotImplemented
            return all(map(same, values(self), values(other)))

        return __eq__


def _getter(attributes: Sequence[str]) -> Callable[[Any], Sequence[Any]]:
    if len(attributes) > 1:
        return attrgetter(*attributes)
    return lambda value: [getattr(value, name) for name in attributes]


class Arguments(Members):
    """The arguments of a call."""

    __slots__ = ()

    def encode(self, *values: Any) -> Parts:
        out: Parts = []
        # This loop is a copy of the body of `write`, for speed.
        for at, end, put, _, label in self._groups or self._grouped():
            if label:
                put(values[at], out, label)
            else:
                out.append(put(*values[at:end]))
        return out

    def decode(self, source: Decoder) -> tuple[Any, ...]:
        return tuple(self.read(source))

    def made_values(self, data: Any, path: str = "") -> tuple[Any, ...]:
        """Converts plain data back to arguments. Only arguments with defaults may be omitted."""
        given = dict(super().made(data, path))
        required = self._needed
        for i, name in enumerate(self.names):
            if i not in given:
                if i < required:
                    raise JsonError(below(path, name), "it is missing")
                given[i] = self.defaults[i - required]
        return tuple(given[i] for i in range(len(self.names)))


class BitsLayout(Kind):
    """The layout of a bitset, which is encoded as one number of the type that `code` names, as in
    the module struct. `members` gives the position, width and type code of each member."""

    __slots__ = ("_labels", "_members", "_number", "attributes", "kind", "least", "names", "used")

    def __init__(
        self,
        kind: Any,
        code: str,
        members: Sequence[tuple[int, int, str]],
        label: str,
        names: Mapping[str, str],
    ) -> None:
        self.kind = kind
        self._number = Number(code)
        self.least = self._number.least
        self.attributes = [member.name for member in fields(kind)]
        self.names = [names.get(name, name) for name in self.attributes]
        self._labels = [f"{label or kind.__name__}.{name}" for name in self.names]
        self._members = members
        self.used = sum(((1 << width) - 1) << position for position, width, _ in members)

    def pack(self, value: Any) -> bytes:
        bits = 0
        for name, label, (position, width, code) in zip(
            self.attributes, self._labels, self._members, strict=True
        ):
            member = getattr(value, name)
            low = -(1 << width - 1) if code.islower() else 0
            high = low + (1 << width) - 1
            if not low <= member <= high:
                raise RangeError(label, member, Range(low, high))
            bits |= (member & (1 << width) - 1) << position
        return number(bits, self._number.code)

    def unpack(self, kind: Any, source: Decoder, label: str) -> Any:
        bits: int = source.number(self._number.code, label)
        if bits & ~self.used:
            source.refuse_range(label, self.least)
        values: list[int] = []
        for position, width, code in self._members:
            member = bits >> position & (1 << width) - 1
            values.append(
                member == 1 if code == "?" else signed(member, width) if code.islower() else member
            )
        return kind(*values)

    def put(self, value: Any, out: Parts, label: str) -> None:
        expect(value, self.kind, label)
        out.append(value.pack())

    def take(self, source: Decoder, label: str) -> Any:
        return self.kind.unpack(source, label)

    def _json(self) -> Members:
        return Members("", self.names, [code for _, _, code in self._members], ())

    def plain(self, value: Any) -> Any:
        return self._json().plain([getattr(value, name) for name in self.attributes])

    def made(self, data: Any, path: str) -> Any:
        return self.kind(**{self.attributes[i]: v for i, v in self._json().made(data, path)})
