"""Chooses the values that a generated mock server returns. The values are equal in all
languages."""

from __future__ import annotations

import math

from gidl.model import (
    EnumDeclaration,
    Model,
    Primitive,
    Range,
    Union,
    UnionCase,
)
from gidl.wire.wire_layout import node_of
from gidl.wire.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    Node,
    ScalarNode,
    StructNode,
    UnionNode,
)


def number(kind: Primitive, limits: Range | None) -> int | float:
    """Returns the middle of the range `limits`. If the range has only one limit, returns the number
    in the range that is nearest to 0."""
    if limits is None:
        return 0 if kind.is_integer else 0.0
    low, high = limits.minimum, limits.maximum
    if low is not None and high is not None:
        if kind.is_integer:
            return (math.ceil(low) + math.floor(high)) // 2
        return float(low) / 2 + float(high) / 2
    nearest = max(0, low) if low is not None else min(0, high if high is not None else 0)
    return int(nearest) if kind.is_integer else float(nearest)


def is_made_by_default(model: Model, node: Node, alone: bool) -> bool:
    """Returns whether a default-constructed value of this type is already a sample that a mock can
    return. `alone` means that the value is not a member of a struct: a default-constructed enum
    then has the number 0, even if its initial enumerator has another number."""
    match node:
        case ScalarNode(kind, limits):
            return not kind.is_number or number(kind, limits) == 0
        case ArrayNode(element):
            return is_made_by_default(model, element, alone)
        case EnumNode(name):
            enum = model.find(name)
            return not (alone and isinstance(enum, EnumDeclaration)) or enum.initial.number == 0
        case StructNode(name) | AppendableNode(name):
            struct = model.struct(name)
            return struct.maps_to is not None or all(
                m.optional
                or m.default is not None
                or is_made_by_default(model, node_of(model, m.type, False, m.range), alone=False)
                for m in model.all_members(struct)
            )
        case UnionNode():
            return False
        case _:
            return True


def arm_of(union: Union) -> UnionCase:
    """Returns the first arm of the union that has a label. If no arm has a label, returns the
    default arm."""
    return next((case for case in union.cases if case.labels), union.cases[0])


def nanoseconds(rate_hz: float | None) -> int:
    """Returns the interval between two samples of a stream. The interval is one second if no rate
    is declared."""
    return round(1e9 / rate_hz) if rate_hz else 1_000_000_000
