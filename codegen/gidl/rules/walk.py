"""Ways to go through a model, which several rules share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gidl.model import (
    ArrayType,
    Attribute,
    Facts,
    Interface,
    MapType,
    Model,
    Operation,
    Parameter,
    PrimitiveType,
    Range,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
    Value,
)


@dataclass(frozen=True, slots=True)
class Slot:
    """A place that holds a value: a member, parameter, attribute, result or typedef."""

    what: str  # words for the place in messages, for example "member 'speed'"
    type: Type
    facts: Facts
    unit: str | None = None
    range: Range | None = None
    default: Value | None = None
    optional: bool = False
    bulk: bool = False
    secret: bool = False


def slots(model: Model) -> Iterator[Slot]:
    """Yields every place of the model that holds a value, in order."""
    for declaration in model.declarations():
        match declaration:
            case Struct():
                for m in declaration.members:
                    what = f"member '{m.name}'"
                    yield Slot(what, m.type, m.facts, m.unit, m.range, m.default, m.optional,
                               m.bulk, m.secret)  # fmt: skip
            case Union():
                for case in declaration.cases:
                    m = case.member
                    what = f"member '{m.name}'"
                    yield Slot(what, m.type, m.facts, m.unit, m.range, m.default, m.optional,
                               m.bulk, m.secret)  # fmt: skip
            case Typedef():
                d = declaration
                yield Slot(f"type '{d.simple_name}'", d.type, d.facts, d.unit, d.range)
    for member in members(model):
        if isinstance(member, Attribute):
            yield Slot(f"attribute '{member.name}'", member.type, member.facts, member.unit,
                       member.range, None, member.optional, member.bulk,
                       member.secret)  # fmt: skip
            continue
        for p in member.parameters:
            yield _of_parameter(p)
        if member.result is not None:
            what = f"the result of '{member.name}'"
            yield Slot(what, member.result, member.facts, member.result_unit, member.result_range,
                       None, member.result_optional, member.result_bulk,
                       member.result_secret)  # fmt: skip


def _of_parameter(p: Parameter) -> Slot:
    what = f"parameter '{p.name}'"
    return Slot(what, p.type, p.facts, p.unit, p.range, p.default, p.optional, p.bulk, p.secret)


def members(model: Model) -> Iterator[Operation | Attribute]:
    """Yields every operation, event and attribute once, from the interface that declares it."""
    for interface in model.interfaces():
        yield from interface.members


def meet_first(model: Model, interface: Interface, one: str, other: str) -> bool:
    """Returns whether `interface` derives from both `one` and `other`, but no base of `interface`
    derives from both. A clash between `one` and `other` is reported only at such an interface."""
    for base in interface.all_bases:
        line = {i.name for i in model.with_bases(model.interface(base))}
        if one in line and other in line:
            return False
    return True


def numeric_core(model: Model, used: Type) -> PrimitiveType | None:
    """Returns the type of the numbers in a type, after resolving typedefs, arrays, sequences and
    the values of maps. Returns None if the type contains something other than numbers."""
    target = model.target(used)
    while isinstance(target, ArrayType | SequenceType | MapType):
        inner = target.value if isinstance(target, MapType) else target.element
        target = model.target(inner)
    if isinstance(target, PrimitiveType) and target.kind.is_number:
        return target
    return None
