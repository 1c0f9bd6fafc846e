"""The nodes of wire_layout.py, which explains them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gidl.model import Primitive


@dataclass(frozen=True, slots=True)
class ScalarNode:
    primitive: Primitive


@dataclass(frozen=True, slots=True)
class EnumNode:
    name: str  # of an enum, bitmask or bitset
    wire: Primitive  # INT32 or INT64


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
