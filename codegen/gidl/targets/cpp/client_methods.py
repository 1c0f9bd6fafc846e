"""Builds the views of the methods of client proxies."""

from __future__ import annotations

from gidl.model import (
    Attribute,
    Operation,
)
from gidl.model.policy import OnNew
from gidl.targets.calls import (
    attribute_value,
    parameter_value,
    short_name,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.call_facts import CallFacts
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.interface_views import MethodView, ReadingView, WriterView
from gidl.targets.cpp.statements import conjunction
from gidl.targets.cpp.type_text import Slot
from gidl.targets.groups import call as called
from gidl.targets.groups import group
from gidl.targets.naming import (
    value_note,
)
from gidl.wire.wire_layout import CallKind, CallLayout, FieldLayout


class Client(CallFacts):
    def _method(self, call: CallLayout) -> MethodView:
        member = self._member(call)
        if isinstance(member, Operation):
            name, values = (
                names.method_name(member.name),
                [parameter_value(p) for p in member.inputs],
            )
            doc = self._operation_doc(member)
        elif call.kind is CallKind.SETTER:
            name, values = self._setter_name(member), [attribute_value(member)]
            note = value_note(member.unit, member.range)
            doc = doc_lines(member.facts, note) or (f"Sets {member.name}.",)
        else:
            name, values = names.method_name(member.name), []
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        types = self._command_types(call, member)
        parameters = self._parameters(values)
        taken = {n for _, n, _ in parameters}
        slots = self._slots(call.request, short_name(call).removesuffix("="))
        local = names.Locals(taken)
        size, to = local.fresh("size"), local.fresh("to")
        used = {*taken, size, to}
        constant = self._constant(self._constants[call.name])
        blends = isinstance(member, Operation) and member.on_new is OnNew.BLEND

        def refused(why: str) -> str:
            # A command that blends continues the motion of the command before it. If the generated
            # code refuses a blending command, the session must therefore not send the blending
            # commands that follow.
            known = ("*gecos_session_", constant) if blends else ()
            return called("gecos::session::Refused", why, *known)

        return MethodView(
            doc,
            f"gecos::Command<{types}>",
            name,
            group(f"{t} {n}{d}" for t, n, d in parameters),
            group(f"{t} {n}" for t, n, _ in parameters),
            tuple(x for s in slots for x in self._lowering.check(s, names.Locals(used), refused)),
            f"gecos_call<{types}>",
            constant,
            self._writing(slots, size, to, taken) if slots else None,
            self._reading(call.reply, short_name(call), taken) if call.reply else None,
        )

    def _reading(self, reply: tuple[FieldLayout, ...], owner: str, taken: set[str]) -> ReadingView:
        local = names.Locals(taken)
        value, source = local.fresh("value"), local.fresh("from")
        if len(reply) > 1:
            return ReadingView(source, value, (f"return {value}.decode({source});",))
        slot = Slot(value, owner, reply[0].node)
        terms = [self._lowering.decode(slot, source, names.Locals({*taken, value, source}))]
        return ReadingView(source, value, tuple(conjunction(terms)))

    def _subscribing(self, attribute: Attribute) -> MethodView:
        value = attribute_value(attribute)
        used = self._lowering.type(value.type, value.optional)
        sample = self._layout.stream(attribute.scoped_name).sample
        rate = attribute.stream.rate_hz if attribute.stream else None
        note = f"Samples of {attribute.name}"
        note += f", {rate:g} a second." if rate else "."
        event = doc_lines(attribute.facts) or (f"The events `{attribute.name}`.",)
        return MethodView(
            (note,) if attribute.event is None else event,
            f"tl::expected<gecos::Stream<{used}>, gecos::Failure>",
            names.method_name(attribute.name),
            group(["gecos::StreamAnnotation"]),
            group(["gecos::StreamAnnotation"]),
            (),
            f"gecos_subscribe<{used}>",
            self._constant(self._stream_constants[attribute.name]),
            None,
            self._reading((sample,), attribute.name, set()),
        )

    def _writer(self, attribute: Attribute) -> WriterView:
        value = attribute_value(attribute)
        sample = self._layout.stream(attribute.scoped_name).sample
        slot = Slot("value", attribute.name, sample.node)
        taken = {"value", "core", "stamp_ns"}

        def refused(why: str) -> str:
            return called("gecos::session::refused_sample", why)

        note = f"Sends samples of {attribute.name}."
        return WriterView(
            doc_lines(attribute.facts, value_note(attribute.unit, attribute.range)) or (note,),
            names.method_name(attribute.name),
            self._lowering.type(value.type, value.optional),
            self._constant(self._stream_constants[attribute.name]),
            tuple(self._lowering.check(slot, names.Locals({*taken, "size", "to"}), refused)),
            self._writing([slot], "size", "to", taken),
        )
