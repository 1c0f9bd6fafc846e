"""Parameters, results and streams of calls, in the form that the targets of all languages use."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gidl.model import (
    BUILT_IN,
    AnyDeclaration,
    Attribute,
    Extensibility,
    Facts,
    File,
    Interface,
    Location,
    Member,
    Model,
    Operation,
    Parameter,
    Range,
    Struct,
    Type,
    Typedef,
    Union,
    Value,
)
from gidl.targets.naming import UnsupportedError
from gidl.targets.reach import named_types
from gidl.wire.wire_layout import CallLayout, Layout


@dataclass(frozen=True, slots=True)
class CallValue:
    """A parameter, a result or the value of an attribute."""

    name: str
    type: Type
    optional: bool = False
    range: Range | None = None
    default: Value | None = None
    unit: str | None = None
    secret: bool = False


def parameter_value(p: Parameter) -> CallValue:
    return CallValue(p.name, p.type, p.optional, p.range, p.default, p.unit, p.secret)


def attribute_value(a: Attribute) -> CallValue:
    return CallValue("value", a.type, a.optional, a.range, None, a.unit, a.secret)


def reply_values(operation: Operation, call: CallLayout) -> list[CallValue]:
    """Returns the values in a reply: the result, then the `inout` and `out` parameters."""
    values = []
    if operation.result is not None:
        values.append(
            CallValue(
                call.reply[0].name, operation.result, operation.result_optional,
                operation.result_range, None, operation.result_unit, operation.result_secret,
            )
        )  # fmt: skip
    return values + [parameter_value(p) for p in operation.outputs]


def first_missing(values: Sequence[CallValue]) -> int:
    """Returns the smallest index from which on all values are optional or have a default. An older
    caller may leave out these values."""
    index = len(values)
    while index and (values[index - 1].optional or values[index - 1].default is not None):
        index -= 1
    return index


def result_struct(layout: Layout, operation: Operation) -> Struct:
    """Returns the results of an operation as a struct, for example `Gripper_measure_result`. The
    struct is appendable, like every reply."""
    return Struct(
        f"{operation.interface}_{operation.name}_result",
        Facts(operation.facts.location, f"The results of `{operation.name}`."),
        members_of(reply_values(operation, layout.call(operation.scoped_name))),
        extensibility=Extensibility.APPENDABLE,
    )


def members_of(values: Sequence[CallValue]) -> tuple[Member, ...]:
    """Returns the values of a call as members of a struct."""
    nowhere = Facts(Location("", 0, 0))
    return tuple(
        Member(v.name, v.type, nowhere, v.unit, v.range, v.default, v.optional, secret=v.secret)
        for v in values
    )


def stream_attributes(model: Model, layout: Layout, interface: Interface) -> list[Attribute]:
    """Returns the streams that the server publishes, including inherited streams, sorted by
    function code."""
    members = model.all_interface_members(interface)
    found = [m for m in members if isinstance(m, Attribute) and m.streams_out]
    return sorted(found, key=lambda a: layout.stream(a.scoped_name).code)


def inward_streams(model: Model, layout: Layout, interface: Interface) -> list[Attribute]:
    """Returns the streams that clients send, including inherited streams, sorted by function
    code."""
    members = model.all_interface_members(interface)
    found = [m for m in members if isinstance(m, Attribute) and m.streams_in]
    return sorted(found, key=lambda a: layout.stream(a.scoped_name).code)


def short_name(call: CallLayout) -> str:
    """Returns the name of a call without its scope, for example "move", or "tool_offset=" for a
    setter."""
    return call.name.rpartition("::")[2]


def passes_objects(model: Model, file: File) -> bool:
    """Returns whether a type or a call of the file contains object references
    (gecos::ObjectRef)."""
    return any(
        isinstance(model.find(name), Interface)
        for declaration in file.declarations
        for used in _used_types(declaration)
        for name in named_types(used)
    )


def _used_types(declaration: AnyDeclaration) -> Iterator[Type]:
    match declaration:
        case Struct():
            yield from (m.type for m in declaration.members)
        case Union():
            yield from (case.member.type for case in declaration.cases)
        case Typedef():
            yield declaration.type
        case Interface():
            for member in declaration.members:
                if isinstance(member, Attribute):
                    yield member.type
                    continue
                yield from (p.type for p in member.parameters)
                if member.result is not None:
                    yield member.result


def refuse_unsupported(interface: Interface) -> None:
    """Raises UnsupportedError for constructs in the interface that no target supports yet."""
    if BUILT_IN in interface.all_bases:
        raise UnsupportedError(
            interface.facts.location,
            f"{interface.name}: every object answers the operations of {BUILT_IN}, so an interface"
            " must not inherit from it; leave it out of the bases",
        )
