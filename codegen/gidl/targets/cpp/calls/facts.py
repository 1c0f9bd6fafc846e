"""What client and server must agree on: names, parameters and results of each call."""

from __future__ import annotations

from gidl.languages import CPP_WORDS
from gidl.model import (
    Attribute,
    Interface,
    Operation,
)
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    first_missing,
    reply_values,
    short_name,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.comments import comment, doc_lines
from gidl.targets.cpp.lower import Lowering, Slot
from gidl.targets.cpp.lower.statements import indented
from gidl.targets.naming import (
    LocalNames,
    value_note,
)
from gidl.type_names import escaped
from gidl.wire_layout import CallKind, CallLayout, FieldLayout


class CallFacts:
    def __init__(self, lowering: Lowering, interface: Interface) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self._interface = interface
        self._members = {m.scoped_name: m for m in self._model.all_interface_members(interface)}
        self._calls = sorted(
            self._layout.all_calls(self._model, interface), key=lambda call: call.code
        )
        self._type = names.absolute(self._layout.cpp_names.types[interface.name])

    def _member(self, call: CallLayout) -> Operation | Attribute:
        return self._members[call.name.removesuffix("=")]

    def _index(self, call: CallLayout) -> int:
        return self._calls.index(call)

    def _operation_doc(self, operation: Operation) -> tuple[str, ...]:
        doc = list(
            doc_lines(operation.facts, value_note(operation.result_unit, operation.result_range))
        )
        for p in operation.parameters:
            note = value_note(p.unit, p.range)
            if note or p.facts.doc:
                text = " ".join(doc_lines(p.facts, note))
                doc.append(f"@param {escaped(p.name, CPP_WORDS)} {text}")
        if operation.raises:
            raised = ", ".join(self._lowering.named(n)[2:] for n in operation.raises)
            doc.append(f"May fail with {raised}.")
        return comment(doc)

    def _setter_name(self, attribute: Attribute) -> str:
        return LocalNames(names.method_names(self._model, self._interface)).fresh(
            f"set_{attribute.name}"
        )

    def _parameters(self, values: list[CallValue]) -> list[tuple[str, str, str]]:
        """Type, name and default. A default needs one in all that follow."""
        from_here = first_missing(values)
        result = []
        for i, value in enumerate(values):
            default = ""
            if i >= from_here:
                default = " = {}" if value.optional else f" = {self._default(value)}"
            result.append(
                (
                    self._lowering.parameter(value.type, value.optional),
                    escaped(value.name, CPP_WORDS),
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
        return [Slot(escaped(f.name, CPP_WORDS), f"{owner}.{f.name}", f.node) for f in fields]

    def _caller_name(self, call: CallLayout) -> str:
        short = short_name(call)
        if short.endswith("="):
            return f"gecos_set_{short.removesuffix('=')}"
        return f"gecos_call_{short}"


def request_name(slots: list[Slot]) -> str:
    """What a handler's caller calls the incoming call: parameters have their own names."""
    return LocalNames(slot.expression for slot in slots).fresh("call")


def why_not(checks: list[str], wrong: str) -> list[str]:
    """Statements that say in `wrong` why something must not be sent."""
    if not checks:
        return []
    head = f"const std::string {wrong} = [&]() -> std::string {{"
    return [head, *indented(checks), "  return {};", "}();"]


def hex32(value: int) -> str:
    return f"0x{value:08x}"


def hex64(value: int) -> str:
    return f"0x{value & 0xFFFFFFFFFFFFFFFF:016x}"
