"""Kinds of values that contain other values: optional values, sequences, arrays, maps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gecos.wire.codes import MAX_COUNT, READERS, native
from gecos.wire.decode import Decoder
from gecos.wire.encode import (
    Parts,
    counted,
    entries,
    exactly,
    fixed,
    fixed_octets,
    numbers,
    octets,
)
from gecos.wire.errors import JsonError, RangeError
from gecos.wire.kinds import Kind, Limits, Number, expect_json
from gecos.wire.units import outside
from gecos.wire.values import as_array


class Optional(Kind):
    __slots__ = ("inner",)
    least = 1
    may_be_missing = True

    def __init__(self, inner: Kind) -> None:
        self.inner = inner

    @property
    def holds_array(self) -> bool:  # type: ignore[override]
        return self.inner.holds_array

    def put(self, value: Any, out: Parts, label: str) -> None:
        if value is None:
            out.append(b"\0")
        else:
            out.append(b"\1")
            self.inner.put(value, out, label)

    def take(self, source: Decoder, label: str) -> Any:
        return self.inner.take(source, label) if source.number("?", label) else None

    def step(self) -> Any:
        step = self.inner.step()
        return None if step is None else ("optional", step)

    def plain(self, value: Any) -> Any:
        return None if value is None else self.inner.plain(value)

    def made(self, data: Any, path: str) -> Any:
        return None if data is None else self.inner.made(data, path)


class Items(Kind):
    """A sequence of at most `most` elements, or an array of `size` elements."""

    __slots__ = ("inner", "most", "size")

    def __init__(self, inner: Kind, most: int = MAX_COUNT, size: int | None = None) -> None:
        self.inner = inner
        self.most = most
        self.size = size

    @property
    def least(self) -> int:  # type: ignore[override]
        return 4 if self.size is None else self.size * self.inner.least

    @property
    def holds_array(self) -> bool:  # type: ignore[override]
        return self.inner.holds_array

    def put(self, value: Any, out: Parts, label: str) -> None:
        if self.size is None:
            out.append(counted(value, self.most, label))
        else:
            exactly(value, self.size, label)
        put = self.inner.put
        for each in value:
            put(each, out, label)

    def take(self, source: Decoder, label: str) -> Any:
        size = self.size
        if size is None:
            size = source.count(self.inner.least, self.most, label)
        take = self.inner.take
        return [take(source, label) for _ in range(size)]

    def step(self) -> Any:
        step = self.inner.step()
        least = 0 if step is None else self.inner.least
        if least == 0:
            return None
        return ("items", step, least, self.size, self.most if self.size is None else self.size)

    def plain(self, value: Any) -> Any:
        return [self.inner.plain(each) for each in value]

    def made(self, data: Any, path: str) -> Any:
        expect_json(list, data, path, "a list")
        if self.size is not None and len(data) != self.size:
            raise JsonError(path, f"{self.size} elements are expected, {len(data)} are there")
        return [self.inner.made(each, f"{path}[{i}]") for i, each in enumerate(data)]


class Octets(Kind):
    """A bytes object; in JSON a list of numbers from 0 to 255."""

    __slots__ = ("limits", "most", "size")

    def __init__(
        self,
        most: int = MAX_COUNT,
        size: int | None = None,
        low: int | None = None,
        high: int | None = None,
        unit: str = "",
    ) -> None:
        self.most = most
        self.size = size
        limits = Limits("B", low, high, unit)
        self.limits = None if limits.effective("B") == (None, None) else limits

    def _first_outside(self, value: bytes | bytearray | memoryview[int]) -> int | None:
        """Returns the index of the first byte outside the declared range; None if there is no such
        byte."""
        if self.limits is None:
            return None
        low, high = self.limits.sent
        for index, octet in enumerate(value):
            if (low is not None and octet < low) or (high is not None and octet > high):
                return index
        return None

    @property
    def least(self) -> int:  # type: ignore[override]
        return 4 if self.size is None else self.size

    def put(self, value: Any, out: Parts, label: str) -> None:
        if self.size is None:
            out += octets(value, self.most, label)
        else:
            out.append(fixed_octets(value, self.size, label))
        if self.limits is not None and (index := self._first_outside(out[-1])) is not None:
            raise RangeError(f"{label}[{index}]", out[-1][index], self.limits.range)

    def take(self, source: Decoder, label: str) -> Any:
        size = source.count(1, self.most, label) if self.size is None else self.size
        taken = source.octets(size, label)
        if (index := self._first_outside(taken)) is not None:
            assert self.limits is not None
            source.refuse_range(label, size - index, outside(taken[index], self.limits.range))
        return taken

    def step(self) -> Any:
        if self.limits is not None:
            return None
        return ("octets", self.size, self.most if self.size is None else self.size)

    def plain(self, value: Any) -> Any:
        return list(value)

    def made(self, data: Any, path: str) -> Any:
        return bytes(Items(Number("B"), size=self.size).made(data, path))


class Numbers(Kind):
    """A sequence of numbers, kept as a numpy array. Limits are compared in the precision of the
    array."""

    __slots__ = ("code", "limits", "most")
    least = 4
    holds_array = True

    def __init__(
        self, code: str, most: int, low: Any = None, high: Any = None, unit: str = ""
    ) -> None:
        self.code = code
        self.most = most
        self.limits = Limits(code, low, high, unit)

    def put(self, value: Any, out: Parts, label: str) -> None:
        limits = self.limits
        out += numbers(value, self.code, self.most, label, *limits.sent, limits.range)

    def take(self, source: Decoder, label: str) -> Any:
        limits = self.limits
        return source.numbers(self.code, self.most, label, *limits.sent, limits.range)

    def step(self) -> Any:
        supported = self.limits.sent == (None, None) or self.code == "d"
        return ("numbers", self.code, self.most, *self.limits.sent) if supported else None

    def _list(self) -> Kind:
        return Items(Number(self.code))

    def plain(self, value: Any) -> Any:
        return self._list().plain(as_array(value, self.code).tolist())

    def made(self, data: Any, path: str) -> Any:
        import numpy as np

        return np.array(self._list().made(data, path), native(self.code))


class Array(Numbers):
    """An array of numbers with a fixed shape, kept as a numpy array."""

    __slots__ = ("count", "shape")

    def __init__(
        self,
        code: str,
        shape: tuple[int, ...],
        low: Any = None,
        high: Any = None,
        unit: str = "",
    ) -> None:
        super().__init__(code, 0, low, high, unit)
        self.shape = shape
        self.count = 1
        for size in shape:
            self.count *= size

    @property
    def least(self) -> int:  # type: ignore[override]
        return self.count * READERS[self.code].size

    def put(self, value: Any, out: Parts, label: str) -> None:
        limits = self.limits
        out.append(fixed(value, self.code, self.shape, label, *limits.sent, limits.range))

    def take(self, source: Decoder, label: str) -> Any:
        limits = self.limits
        read = source.array(self.code, self.count, label, *limits.sent, limits.range)
        return read.reshape(self.shape) if len(self.shape) > 1 else read

    def step(self) -> Any:
        supported = self.limits.sent == (None, None) or self.code == "d"
        return ("array", self.code, self.shape, *self.limits.sent) if supported else None

    def _list(self) -> Kind:
        whole: Kind = Number(self.code)
        for size in reversed(self.shape):
            whole = Items(whole, size=size)
        return whole


class Entries(Kind):
    """A map; in JSON a list of pairs of key and value, in ascending order of the keys."""

    __slots__ = ("key", "most", "value")
    least = 4

    def __init__(self, key: Kind, value: Kind, most: int = MAX_COUNT) -> None:
        self.key = key
        self.value = value
        self.most = most

    @property
    def holds_array(self) -> bool:  # type: ignore[override]
        return self.key.holds_array or self.value.holds_array

    def put(self, value: Mapping[Any, Any], out: Parts, label: str) -> None:
        out.append(counted(value, self.most, label))
        for key, each in entries(value, label):
            self.key.put(key, out, label)
            self.value.put(each, out, label)

    def take(self, source: Decoder, label: str) -> Any:
        return source.mapping(
            lambda: self.key.take(source, label),
            lambda: self.value.take(source, label),
            self.key.least + self.value.least,
            self.most,
            label,
        )

    def plain(self, value: Any) -> Any:
        return [[self.key.plain(k), self.value.plain(value[k])] for k in sorted(value)]

    def made(self, data: Any, path: str) -> Any:
        expect_json(list, data, path, "a list of pairs")
        entries = {}
        for i, pair in enumerate(data):
            at = f"{path}[{i}]"
            if type(pair) is not list or len(pair) != 2:
                raise JsonError(at, "a pair of key and value is expected")
            key = self.key.made(pair[0], at)
            if key in entries:
                raise JsonError(at, "the map already has this key")
            entries[key] = self.value.made(pair[1], at)
        return entries
