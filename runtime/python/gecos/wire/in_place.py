"""Encodes and decodes structs whose @bulk octets are in memory that is lent."""

from __future__ import annotations

import struct
from typing import Any

from gecos.wire.decode import Decoder
from gecos.wire.encode import Parts, count
from gecos.wire.errors import EncodeError
from gecos.wire.members import StructLayout
from gecos.wire.several import Octets

_size = struct.Struct(">i")


class OctetsInPlace:
    """The codec of a struct without the octets of its member `name`, a `sequence<octet>`. Messages
    call the struct `label`."""

    __slots__ = ("_index", "_kind", "_label", "_labels", "_layout", "attribute")

    def __init__(self, layout: StructLayout, name: str, label: str) -> None:
        self._layout = layout
        self._label = label
        self._index = list(layout.names).index(name)
        self.attribute = layout.attributes[self._index]  # its Python name
        self._labels = [f"{layout.label}.{each}" for each in layout.names]
        kind = layout.kinds[self._index]
        assert isinstance(kind, Octets)
        self._kind = kind

    def encode(self, value: Any, octets: int) -> tuple[bytes, bytes]:
        """Returns the encoded bytes before the octets, and those after them. `octets` is the number
        of the octets. Raises EncodeError if `value` itself has octets, or if a member must not be
        sent."""
        layout, index = self._layout, self._index
        parts: tuple[Parts, Parts] = ([], [])
        for i, attribute in enumerate(layout.attributes):
            member, label = getattr(value, attribute), self._labels[i]
            if i != index:
                layout.kinds[i].put(member, parts[i > index], label)
                continue
            if len(member):
                raise EncodeError(label, "has octets; leave it empty, and write them into the loan")
            parts[0].append(count(octets, self._kind.most, label))
        head, tail = b"".join(parts[0]), b"".join(parts[1])
        if layout.in_block:
            head = _size.pack(len(head) + octets + len(tail)) + head
        return head, tail

    def decode(self, sample: memoryview) -> tuple[Any, memoryview]:
        """Returns the value without the octets, and the octets, which are not copied. Raises
        DecodeError as the other decoders do."""
        layout = self._layout
        source = Decoder(sample)
        if layout.in_block:
            source = source.block(self._label)
        values: list[Any] = []
        required = len(layout.kinds) - len(layout.defaults)
        octets = sample[:0]
        for i, kind in enumerate(layout.kinds):
            if i == self._index:
                size = source.count(1, self._kind.most, self._labels[i])
                octets = sample[source.offset : source.offset + size]
                source.offset += size
                values.append(b"")
            elif i < required or source.offset < source.end:
                values.append(kind.take(source, self._labels[i]))
            else:
                values.append(layout.defaults[i - required])
        return layout.kind(*values), octets
