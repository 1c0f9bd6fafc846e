"""The nodes of the wire layout. The encoding of each node is described in wire_layout.py."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

from gidl.model import Primitive, Range


@dataclass(frozen=True, slots=True)
class ScalarNode:
    """A number, boolean or character. `limits` is the range of the value, narrowed by the ranges
    of all its typedefs; None if every value of the type is allowed. `unit` is the unit of the
    limits, which messages show; None if the limits have no unit."""

    primitive: Primitive
    limits: Range | None = None
    unit: str | None = None

    @property
    def bounds(self) -> Range | None:
        """The limits with which a value is compared, in the precision of the type; for a float,
        each limit is the nearest float. A limit that no value of the type can violate is None."""
        if self.limits is None:
            return None
        low, high = self.limits.minimum, self.limits.maximum
        if self.primitive is Primitive.FLOAT:
            low, high = _single(low), _single(high)
        elif self.primitive.is_integer:
            least, most = self.primitive.integer_limits
            low = None if low is not None and low <= least else low
            high = None if high is not None and high >= most else high
        return None if low is None and high is None else Range(low, high)


@dataclass(frozen=True, slots=True)
class EnumNode:
    name: str  # scoped name of an enum, bitmask or bitset
    wire: Primitive  # encoded as INT32 or INT64


@dataclass(frozen=True, slots=True)
class StringNode:
    bound: int | None


@dataclass(frozen=True, slots=True)
class StructNode:
    name: str


@dataclass(frozen=True, slots=True)
class AppendableNode:
    name: str


@dataclass(frozen=True, slots=True)
class UnionNode:
    name: str
    appendable: bool


@dataclass(frozen=True, slots=True)
class ArrayNode:
    element: Node
    dimensions: tuple[int, ...]

    @property
    def count(self) -> int:
        return math.prod(self.dimensions)


@dataclass(frozen=True, slots=True)
class SequenceNode:
    element: Node
    bound: int | None


@dataclass(frozen=True, slots=True)
class OptionalNode:
    element: Node


@dataclass(frozen=True, slots=True)
class MapNode:
    key: Node
    value: Node
    bound: int | None


@dataclass(frozen=True, slots=True)
class ObjectNode:
    interface: str


Node = (
    ScalarNode | EnumNode | StringNode | StructNode | AppendableNode | UnionNode | ArrayNode
    | SequenceNode | OptionalNode | MapNode | ObjectNode
)  # fmt: skip


def _single(bound: int | float | None) -> float | None:
    if bound is None:
        return None
    rounded: float = struct.unpack("f", struct.pack("f", bound))[0]
    return rounded
