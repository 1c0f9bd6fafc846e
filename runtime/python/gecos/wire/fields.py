"""Runs of consecutive members of fixed size. Each run is encoded by one `struct.Struct`."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any, NoReturn

from gecos.wire.codes import CODE_MEANING
from gecos.wire.decode import Decoder
from gecos.wire.errors import DecodeError, DecodeProblem, EncodeError, expect_boolean, unfit


class Fields:
    """A run of consecutive members of fixed size, which are packed and unpacked in a single call.

    `codes` are those of `struct` without byte order: `b B h H i I q Q f d`, and `?` for a boolean.
    """

    __slots__ = (
        "_booleans",
        "_codes",
        "_names",
        "_pack",
        "_unpack_from",
        "size",
    )

    def __init__(self, codes: str, names: Sequence[str]) -> None:
        if len(codes) != len(names):
            raise ValueError(f"{len(codes)} codes for {len(names)} names: {codes!r}, {names!r}")
        self._codes = codes
        self._names = tuple(names)
        self._booleans = tuple(i for i, code in enumerate(codes) if code == "?")
        self._pack = struct.Struct(">" + codes).pack
        reader = struct.Struct(">" + codes.replace("?", "B"))
        self._unpack_from = reader.unpack_from
        self.size = reader.size

    def pack(self, *values: Any) -> bytes:
        if self._booleans and len(values) == len(self._codes):
            for i in self._booleans:
                if values[i] is not True and values[i] is not False:
                    expect_boolean(values[i], self._names[i])
        try:
            return self._pack(*values)
        except (struct.error, OverflowError, TypeError):
            raise self._unfit(values) from None

    def unpack(self, source: Decoder) -> tuple[Any, ...]:
        offset = source.offset
        after = offset + self.size
        if after > source.end:
            self._refuse_truncated(source)
        source.offset = after
        values = self._unpack_from(source.data, offset)
        if self._booleans:
            return self._with_booleans(values, offset)
        return values

    def _with_booleans(self, values: tuple[Any, ...], offset: int) -> tuple[Any, ...]:
        changed = list(values)
        for i in self._booleans:
            if values[i] > 1:
                at = offset + struct.calcsize(">" + self._codes[:i])
                raise DecodeError(DecodeProblem.INVALID_BOOLEAN, at, self._names[i])
            changed[i] = values[i] == 1
        return tuple(changed)

    def _refuse_truncated(self, source: Decoder) -> NoReturn:
        for code, name in zip(self._codes, self._names, strict=True):
            if source.remaining < struct.calcsize(">" + code):
                source.refuse(DecodeProblem.TRUNCATED, name)
            # An invalid boolean in front of the missing bytes is reported instead of TRUNCATED.
            source.number(code, name)
        raise AssertionError("too few bytes for all numbers, but enough for each of them")

    def _unfit(self, values: tuple[Any, ...]) -> EncodeError | TypeError:
        if len(values) != len(self._codes):
            return TypeError(f"{len(self._codes)} values expected, {len(values)} given")
        for code, name, value in zip(self._codes, self._names, values, strict=True):
            try:
                struct.pack(">" + code, value)
            except (struct.error, OverflowError, TypeError):
                return EncodeError(name, unfit(value, CODE_MEANING[code]))
        raise AssertionError(
            "the values cannot be packed together, but each one can be packed alone"
        )
