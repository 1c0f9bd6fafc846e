"""The kinds of values in layouts. Each kind encodes and decodes its values, also as JSON.

`plain` converts a value to types that the module `json` can dump. `made` converts the result of
`plain` back to a value, and raises `JsonError`. `step` describes the kind to the extension
`_plans`; it returns None if the extension does not support the kind.
"""

from __future__ import annotations

import math
import struct
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from enum import IntEnum, IntFlag
from typing import Any

from gecos.wire.codes import CODE_MEANING, MAX_TEXT, READERS, WRITERS
from gecos.wire.contents import from_bytes, put, put_block, to_bytes
from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, char, number, string
from gecos.wire.errors import (
    HIDDEN,
    DecodeError,
    EncodeError,
    JsonError,
    RangeError,
    brief,
    expect_enumerator,
    expect_number_of,
)
from gecos.wire.units import Range

_NOT_FINITE = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


def expect_json(kind: type, data: Any, path: str, wanted: str) -> None:
    if type(data) is not kind:
        raise JsonError(path, f"{wanted} is expected, {_shown(data)} is there")


def _shown(data: Any) -> str:
    names = {dict: "an object", list: "a list", str: "a text", bool: "a boolean"}
    return "null" if data is None else names.get(type(data), "a number")


def below(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


class Kind(ABC):
    """Encodes and decodes values of one kind. `label` is the name of the value in error
    messages."""

    __slots__ = ()

    least = 0
    """Smallest size of a value in bytes."""
    holds_array = False
    """True if values contain numpy arrays. The function `same` must compare such values, because
    `==` of arrays returns an array."""
    may_be_missing = False
    """True if the value may be missing (None)."""

    @abstractmethod
    def put(self, value: Any, out: Parts, label: str) -> None: ...

    @abstractmethod
    def take(self, source: Decoder, label: str) -> Any: ...

    @abstractmethod
    def plain(self, value: Any) -> Any: ...

    @abstractmethod
    def made(self, data: Any, path: str) -> Any: ...

    def step(self) -> Any:
        return None


class Number(Kind):
    """A number. `code` is a number code as in `wire.Fields`. In JSON, a floating-point number that
    is not finite is one of the texts "nan", "inf" and "-inf"."""

    __slots__ = ("code", "least")

    def __init__(self, code: str) -> None:
        if code not in READERS:
            raise TypeError(f"{code!r} is not the type code of a number")
        self.code = code
        self.least = READERS[code].size

    def put(self, value: Any, out: Parts, label: str) -> None:
        out.append(number(value, self.code, label))

    def take(self, source: Decoder, label: str) -> Any:
        return source.number(self.code, label)

    def step(self) -> Any:
        return self.code

    def plain(self, value: Any) -> Any:
        if self.code == "?":
            return bool(value)
        if self.code not in "fd":
            return int(value)
        number = float(value)
        return number if math.isfinite(number) else str(number)

    def made(self, data: Any, path: str) -> Any:
        if self.code == "?":
            expect_json(bool, data, path, "a boolean")
            return data
        if self.code in "fd":
            return self._floating(data, path)
        # A float passes this check, because the error below shows its value.
        if type(data) is not float:
            expect_json(int, data, path, "a whole number")
        low, high = limits_of(self.code)
        if type(data) is float or not low <= data <= high:
            raise JsonError(path, f"{brief(data)} is not {CODE_MEANING[self.code]}")
        return data

    def _floating(self, data: Any, path: str) -> float:
        if type(data) is str and data in _NOT_FINITE:
            return _NOT_FINITE[data]
        if type(data) not in (int, float):
            raise JsonError(path, f"a number is expected, {_shown(data)} is there")
        try:
            WRITERS[self.code].pack(data)
            return float(data)
        except (OverflowError, struct.error):  # struct.error for a whole number of 309 digits
            wrong = (
                "too large; give a smaller number"
                if isinstance(data, int)
                else f"not {CODE_MEANING[self.code]}"
            )
            raise JsonError(path, f"{brief(data)[:40]} is {wrong}") from None


def limits_of(code: str) -> tuple[int, int]:
    """Returns the smallest and the largest whole number that `code` can represent."""
    bits = 8 * READERS[code].size
    return (0, (1 << bits) - 1) if code.isupper() else (-(1 << bits - 1), (1 << bits - 1) - 1)


class Limits:
    """The range that @range declares for numbers of code `code`. None means that there is no limit
    on that side.

    Python's floats are more precise than single precision. For code `f`, both the limit as written
    and the nearest single-precision number may be sent. Both are encoded as the nearest
    single-precision number.
    """

    __slots__ = ("range", "received", "sent")

    def __init__(self, code: str, low: Any, high: Any, unit: str = "") -> None:
        self.range = Range(low, high, unit)  # as messages show it
        self.sent: tuple[Any, Any] = (low, high)
        self.received: tuple[Any, Any] = (low, high)
        if code == "f":
            self.received = (_single(low), _single(high))
            self.sent = (_outer(min, low), _outer(max, high))

    def effective(self, code: str) -> tuple[Any, Any]:
        """Returns the lower and the upper limit. A limit that no number of the type `code` can
        exceed is None."""
        low, high = self.sent
        if code not in "fd":
            least, most = limits_of(code)
            low = None if low is not None and low <= least else low
            high = None if high is not None and high >= most else high
        return low, high


def _single(x: float | None) -> float | None:
    return None if x is None else READERS["f"].unpack(WRITERS["f"].pack(x))[0]


def _outer(choose: Callable[[Any, Any], Any], exact: float | None) -> float | None:
    return None if exact is None else choose(exact, _single(exact))


class Ranged(Number):
    """A number within limits."""

    __slots__ = ("high", "limits", "low")

    def __init__(self, code: str, low: Any, high: Any, unit: str = "") -> None:
        super().__init__(code)
        self.limits = Limits(code, low, high, unit)
        self.low, self.high = self.limits.sent

    def put(self, value: Any, out: Parts, label: str) -> None:
        out.append(number(value, self.code, label))
        low, high = self.low, self.high
        if (low is not None and not value >= low) or (high is not None and not value <= high):
            raise RangeError(label, value, self.limits.range)

    def take(self, source: Decoder, label: str) -> Any:
        return source.ranged(self.code, *self.limits.received, label, self.limits.range)

    def step(self) -> Any:
        low, high = self.limits.effective(self.code)
        if low is None and high is None:
            return self.code
        return None if self.code == "Q" else ("ranged", self.code, low, high)


class Text(Kind):
    __slots__ = ("most",)
    least = 5

    def __init__(self, most: int = MAX_TEXT) -> None:
        self.most = most

    def put(self, value: Any, out: Parts, label: str) -> None:
        out.append(string(value, self.most, label))

    def take(self, source: Decoder, label: str) -> Any:
        return source.string(self.most, label)

    def step(self) -> Any:
        return ("text", self.most)

    def plain(self, value: Any) -> Any:
        return value

    def made(self, data: Any, path: str) -> Any:
        expect_json(str, data, path, "a text")
        return data


class Char(Text):
    """One character of Latin-1."""

    __slots__ = ()
    least = 1

    def put(self, value: Any, out: Parts, label: str) -> None:
        out.append(char(value, label))

    def take(self, source: Decoder, label: str) -> Any:
        return chr(source.number("B", label))

    def step(self) -> Any:
        return None

    def made(self, data: Any, path: str) -> Any:
        expect_json(str, data, path, "a text")
        if len(data) != 1 or data > "\xff":
            raise JsonError(path, "one character of Latin-1 is expected")
        return data


class Enumerators(Kind):
    """An enumerator; in JSON its name. `names` maps Python names to names in the interface where
    the two differ. `otherwise` replaces a number that no enumerator has."""

    __slots__ = ("code", "kind", "least", "names", "otherwise")

    def __init__(
        self, kind: type[IntEnum], code: str, otherwise: IntEnum | None, names: Mapping[str, str]
    ) -> None:
        self.kind = kind
        self.code = code
        self.least = READERS[code].size
        self.otherwise = otherwise
        self.names = names

    def put(self, value: Any, out: Parts, label: str) -> None:
        expect_enumerator(value, self.kind, label)
        out.append(number(value, self.code, label))

    def take(self, source: Decoder, label: str) -> Any:
        read = source.number(self.code, label)
        return source.enumerator(self.kind, read, self.otherwise, label, self.least)

    def step(self) -> Any:
        return ("enumerator", self.code, self.kind, self.otherwise)

    def plain(self, value: Any) -> Any:
        name = self.kind(value).name
        return self.names.get(name, name)

    def made(self, data: Any, path: str) -> Any:
        expect_json(str, data, path, "a name")
        for each in self.kind:
            if self.names.get(each.name, each.name) == data:
                return each
        known = ", ".join(self.plain(each) for each in self.kind)
        raise JsonError(path, f"unknown name {data}; the known names are {known}")


class Flags(Kind):
    """A bitmask; in JSON the list of the flags that are set. Only the lowest `bits` bits may be
    set."""

    __slots__ = ("bits", "code", "kind", "least", "names")

    def __init__(self, kind: type[IntFlag], code: str, bits: int, names: Mapping[str, str]) -> None:
        self.kind = kind
        self.code = code
        self.bits = bits
        self.least = READERS[code].size
        self.names = names

    def put(self, value: Any, out: Parts, label: str) -> None:
        expect_number_of(value, self.kind, label)
        out.append(number(value, self.code, label))
        if value >> self.bits:
            raise RangeError(label, value, Range(0, (1 << self.bits) - 1))

    def take(self, source: Decoder, label: str) -> Any:
        read = source.number(self.code, label)
        return source.flags(self.kind, read, self.bits, label, self.least)

    def _named(self) -> dict[str, IntFlag]:
        members = self.kind.__members__.items()
        return {self.names.get(name, name): flag for name, flag in members}

    def plain(self, value: Any) -> Any:
        return [name for name, flag in self._named().items() if flag in self.kind(value)]

    def made(self, data: Any, path: str) -> Any:
        expect_json(list, data, path, "a list of flags")
        named, whole = self._named(), self.kind(0)
        for i, each in enumerate(data):
            if type(each) is not str or each not in named:
                raise JsonError(
                    f"{path}[{i}]", f"unknown name {each}; the known names are {', '.join(named)}"
                )
            whole |= named[each]
        return whole


class Nested(Kind):
    """A value whose type has a layout of its own. It is encoded in a block if the type is
    appendable."""

    __slots__ = ("kind", "layout", "put")
    # `put` is an attribute instead of a method, which saves one call.
    put: Callable[[Any, Parts, str], None]  # type: ignore[assignment]

    def __init__(self, kind: Any, layout: Any) -> None:
        self.kind = kind
        self.layout = layout
        write = put_block if layout.in_block else put
        self.put = lambda value, out, label: write(value, kind, out, label)

    @property
    def least(self) -> int:  # type: ignore[override]
        return 4 if self.layout.in_block else self.layout.least

    def take(self, source: Decoder, label: str) -> Any:
        return self.kind.decode(source.block(label) if self.layout.in_block else source)

    def step(self) -> Any:
        return (
            ("block" if self.layout.in_block else "struct", self.kind)
            if self.layout.compiled
            else None
        )

    def plain(self, value: Any) -> Any:
        return self.layout.plain(value)

    def made(self, data: Any, path: str) -> Any:
        return self.layout.made(data, path)


class Later(Kind):
    """A value whose type is declared later. `known` returns the type once it is declared."""

    __slots__ = ("_known",)

    def __init__(self, known: Callable[[], Any]) -> None:
        self._known = known

    def _kind(self) -> Kind:
        return kind_of(self._known())

    @property
    def least(self) -> int:  # type: ignore[override]
        return self._kind().least

    def put(self, value: Any, out: Parts, label: str) -> None:
        self._kind().put(value, out, label)

    def take(self, source: Decoder, label: str) -> Any:
        return self._kind().take(source, label)

    def plain(self, value: Any) -> Any:
        return self._kind().plain(value)

    def made(self, data: Any, path: str) -> Any:
        return self._kind().made(data, path)


class Secret(Kind):
    """A secret value, which neither JSON nor error messages show."""

    __slots__ = ("inner",)

    def __init__(self, inner: Kind) -> None:
        self.inner = inner

    @property
    def least(self) -> int:  # type: ignore[override]
        return self.inner.least

    @property
    def holds_array(self) -> bool:  # type: ignore[override]
        return self.inner.holds_array

    @property
    def may_be_missing(self) -> bool:  # type: ignore[override]
        return self.inner.may_be_missing

    def put(self, value: Any, out: Parts, label: str) -> None:
        try:
            self.inner.put(value, out, label)
        except EncodeError as error:
            raise EncodeError(error.field, _without(value, error.why)) from None

    def take(self, source: Decoder, label: str) -> Any:
        return self.inner.take(source, label)

    def step(self) -> Any:
        return self.inner.step()

    def plain(self, value: Any) -> Any:
        return HIDDEN

    def made(self, data: Any, path: str) -> Any:
        if data == HIDDEN:
            raise JsonError(
                path,
                "the text stands for a secret that was left out; write the secret itself, or omit "
                "the member",
            )
        try:
            return self.inner.made(data, path)
        except JsonError as error:
            inside = _without(data, error.path[len(path) :])
            raise JsonError(path + inside, _without(data, error.why)) from None


def _without(value: Any, text: str) -> str:
    """Returns `text` with a placeholder wherever it shows the value, or a value inside it."""
    for each in sorted(_inside(value), key=len, reverse=True):
        text = text.replace(each, HIDDEN)
    return text


def _inside(value: Any) -> set[str]:
    """Returns the texts that would reveal the value, or a value inside it, in an error message."""
    shown = {repr(value), str(value)} - {""}
    if isinstance(value, dict):
        value = [*value.keys(), *value.values()]
    if isinstance(value, list | tuple):
        shown = shown.union(*map(_inside, value))
    return shown


class Twin:
    """The layout of a hand-written type. Its encoding equals that of the generated type
    `struct`."""

    __slots__ = ("kind", "struct")
    compiled = False

    def __init__(self, kind: Any, struct: Any) -> None:
        self.kind = kind
        self.struct = struct

    @property
    def in_block(self) -> bool:
        return self.struct._gecos_layout.in_block  # type: ignore[no-any-return]

    @property
    def least(self) -> int:
        return self.struct._gecos_layout.least  # type: ignore[no-any-return]

    def plain(self, value: Any) -> Any:
        return self.struct._gecos_layout.plain(from_bytes(self.struct, to_bytes(value)))

    def made(self, data: Any, path: str) -> Any:
        twin = self.struct._gecos_layout.made(data, path)
        try:
            return from_bytes(self.kind, to_bytes(twin))
        except DecodeError as error:
            raise JsonError(path, error.problem.value) from None


twins: dict[Any, Twin] = {}
"""The layouts of hand-written types. The generated module that uses a hand-written type registers
the layout here."""

_numbers = {code: Number(code) for code in READERS}


def kind_of(step: Any) -> Kind:
    """Converts a layout step to a Kind. A step is a Kind, the code of a number, a type with a
    layout of its own, or a function that returns a type that is declared later."""
    if isinstance(step, Kind):
        return step
    if isinstance(step, str):
        return _numbers.get(step) or Number(step)
    if not isinstance(step, type):
        return Later(step)
    layout = twins.get(step) or getattr(step, "_gecos_layout", None)
    if layout is None:
        raise TypeError(f"{step!r} has no layout")
    return layout if isinstance(layout, Kind) else Nested(step, layout)
