"""Facts that client and server share: names, parameters and results of each call."""

from __future__ import annotations

from collections.abc import Collection

from gidl.model import (
    Attribute,
    Interface,
    Operation,
)
from gidl.names.languages import CPP_WORDS
from gidl.names.type_names import escaped
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    first_missing,
    reply_values,
    short_name,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.comments import comment, doc_lines
from gidl.targets.cpp.interface_views import WritingView
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.statements import joined_puts
from gidl.targets.cpp.type_text import Slot
from gidl.targets.naming import (
    LocalNames,
    value_note,
)
from gidl.wire.wire_layout import CallKind, CallLayout, FieldLayout

# Names of the members of every generated class that describes an interface.
_DESCRIPTION = ("bases", "description", "inherits", "inward_streams", "operations", "streams")


class CallFacts:
    def __init__(self, lowering: Lowering, interface: Interface) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self._interface = interface
        self._members = {m.scoped_name: m for m in self._model.all_interface_members(interface)}
        self._calls = sorted(
            self._layout.interfaces[interface.name].calls, key=lambda call: call.code
        )
        self._constants, self._stream_constants = self._named_constants()

    def _member(self, call: CallLayout) -> Operation | Attribute:
        return self._members[call.name.removesuffix("=")]

    def _named_constants(self) -> tuple[dict[str, str], dict[str, str]]:
        """Returns the names of the constants in the class that describes the interface. The first
        map has the constants of the operations that the interface itself declares. The second map
        has the constants of its streams."""
        described = self._layout.cpp_names.descriptions[self._interface.name].name
        local = LocalNames({described, *_DESCRIPTION})
        calls = {c.name: local.fresh(_constant_name(c)) for c in self._calls}
        streams = [*self._own_streams(), *self._own_inward_streams()]
        return calls, {s.name: local.fresh(f"{s.name}_stream") for s in streams}

    def _own_streams(self) -> list[Attribute]:
        members = [m for m in self._interface.members if isinstance(m, Attribute) and m.streams_out]
        return sorted(members, key=lambda a: self._layout.stream(a.scoped_name).code)

    def _own_inward_streams(self) -> list[Attribute]:
        members = [m for m in self._interface.members if isinstance(m, Attribute) and m.streams_in]
        return sorted(members, key=lambda a: self._layout.stream(a.scoped_name).code)

    def _constant(self, name: str) -> str:
        """The qualified name of the constant `name` in the class that describes the interface."""
        return f"{self._layout.cpp_names.descriptions[self._interface.name].name}::{name}"

    def _operation_doc(self, operation: Operation) -> tuple[str, ...]:
        doc = list(
            doc_lines(operation.facts, value_note(operation.result_unit, operation.result_range))
        )
        for p in operation.parameters:
            note = value_note(p.unit, p.range)
            if note or p.facts.doc:
                text = " ".join(doc_lines(p.facts, note))
                doc.append(f"@param {self._parameter(p.name)} {text}")
        if operation.raises:
            raised = ", ".join(self._lowering.named(n)[2:] for n in operation.raises)
            doc.append(f"May fail with {raised}.")
        return comment(doc)

    def _parameter(self, name: str) -> str:
        return names.parameter_name(self._layout, self._interface, name)

    def _setter_name(self, attribute: Attribute) -> str:
        return LocalNames(names.method_names(self._model, self._interface)).fresh(
            f"set_{attribute.name}"
        )

    def _parameters(self, values: list[CallValue]) -> list[tuple[str, str, str]]:
        """Returns the type, the name and the default of each parameter. A parameter gets its
        default only if all later parameters have one, because C++ requires this."""
        from_here = first_missing(values)
        result = []
        for i, value in enumerate(values):
            default = ""
            if i >= from_here:
                default = " = {}" if value.optional else f" = {self._default(value)}"
            result.append(
                (
                    self._lowering.parameter(value.type, value.optional),
                    self._parameter(value.name),
                    default,
                )
            )
        return result

    def _default(self, value: CallValue) -> str:
        assert value.default is not None
        return self._lowering.literal(value.default, value.type)

    def _reply(self, call: CallLayout, member: Operation | Attribute) -> list[CallValue]:
        if isinstance(member, Operation):
            return reply_values(member, call)
        return [] if call.kind is CallKind.SETTER else [attribute_value(member)]

    def _result_type(self, call: CallLayout, member: Operation | Attribute) -> str:
        values = self._reply(call, member)
        if not values:
            return "void"
        if len(values) == 1:
            return self._lowering.type(values[0].type, values[0].optional)
        return names.absolute(self._layout.cpp_names.results[member.scoped_name])

    def _command_types(self, call: CallLayout, member: Operation | Attribute) -> str:
        result = self._result_type(call, member)
        if isinstance(member, Operation) and member.feedback is not None:
            return f"{result}, {self._lowering.type(member.feedback)}"
        return result

    def _slots(self, fields: tuple[FieldLayout, ...], owner: str) -> list[Slot]:
        return [Slot(self._parameter(f.name), f"{owner}.{f.name}", f.node) for f in fields]

    def _writing(
        self, slots: list[Slot], size: str, to: str, taken: Collection[str]
    ) -> WritingView:
        """Returns the view of a lambda that encodes `slots`. In the text of the lambda, `size`
        is the name of the variable for the size, and `to` is the name of the encoder. The other
        variables get names that are not in `taken`."""
        sizing, expression = self._lowering.whole_size(slots, size, taken)
        used = {*taken, size, to}
        lines = [line for s in slots for line in self._lowering.encode(s, to, names.Locals(used))]
        return WritingView(tuple(sizing), expression, to, tuple(joined_puts(lines, to)))


def _constant_name(call: CallLayout) -> str:
    name = short_name(call)
    if call.kind is CallKind.SETTER:
        return f"set_{name.removesuffix('=')}"
    return escaped(name, CPP_WORDS)


def hex32(value: int) -> str:
    return f"0x{value:08x}"


def hex64(value: int) -> str:
    return f"0x{value & 0xFFFFFFFFFFFFFFFF:016x}"
