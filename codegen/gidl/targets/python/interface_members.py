"""Builds the views of proxy methods, servant handlers and stream publishers."""

from __future__ import annotations

from gidl.model import Attribute, Operation
from gidl.targets.calls import first_missing, short_name
from gidl.targets.naming import LocalNames, doc_lines, value_note
from gidl.targets.python import names
from gidl.targets.python.interface_tables import Tables
from gidl.targets.python.interface_views import (
    EventView,
    HandlerView,
    InwardView,
    ParameterView,
    ProxyMemberView,
    PublisherView,
)
from gidl.targets.python.name_lookup import type_doc
from gidl.wire.wire_layout import CallKind, CallLayout


class Members(Tables):
    def _doc(self, layout: CallLayout) -> tuple[str, ...]:
        member = self._member(layout)
        if isinstance(member, Attribute):
            doc = type_doc(member.facts, value_note(member.unit, member.range))
            if layout.kind is CallKind.SETTER and not doc:
                return (f"Sets {member.name}.",)
            return doc
        lines = doc_lines(member.facts, value_note(member.result_unit, member.result_range))
        notes = []
        inputs = (each.value.name for each in self._inputs(layout))
        called = dict(zip(inputs, self._parameter_names(layout), strict=True))
        for p in member.parameters:
            note = value_note(p.unit, p.range)
            if note or p.facts.doc:
                notes.append(f"{called.get(p.name, p.name)}: {' '.join(doc_lines(p.facts, note))}")
        if layout.exceptions:
            listed = ", ".join(self._module.value(name) for name, _ in layout.exceptions)
            notes.append(f"May raise {listed}.")
        return names.docstring((*lines, *([""] if lines and notes else []), *notes))

    def _parameters(self, layout: CallLayout, calling: bool) -> tuple[ParameterView, ...]:
        """Returns the parameters of a method of the proxy (if `calling` is True) or of a handler.
        The parameters of a handler have no defaults, because the runtime passes a value for every
        parameter."""
        values = self._inputs(layout)
        missing = first_missing([each.value for each in values])
        return tuple(
            ParameterView(
                name,
                self._in_class(self._lowering.hint(each.node, sending=calling)),
                self._missing(each) if calling and i >= missing else "",
            )
            for i, (name, each) in enumerate(
                zip(self._parameter_names(layout), values, strict=True)
            )
        )

    def _proxy_member(self, layout: CallLayout) -> ProxyMemberView:
        member = self._member(layout)
        doc = self._doc(layout)
        getter = isinstance(member, Attribute) and layout.kind is CallKind.GETTER
        streams = isinstance(member, Attribute) and getter and member.streams_out
        if streams and isinstance(member, Attribute):
            rate = member.stream.rate_hz if member.stream else None
            if rate:
                doc = (*doc, *([""] if doc else []), f"Published {rate:g} times a second.")
        return ProxyMemberView(
            streams,
            self._method_name(layout),
            self._parameters(layout, calling=True),
            self._in_class(self._result_hint(layout)),
            self._in_class(self._feedback_hint(layout)),
            doc,
            self._constant(layout),
        )

    def _run(self, layout: CallLayout) -> str:
        """Returns the name of the parameter through which a handler gets its gecos.Execution."""
        return LocalNames(self._parameter_names(layout)).fresh("run")

    def _handler(self, layout: CallLayout) -> HandlerView:
        member = self._member(layout)
        parameters = self._parameters(layout, calling=False)
        if isinstance(member, Operation) and member.cancelable:
            feedback = self._in_class(self._feedback_hint(layout))
            run = ParameterView(self._run(layout), f"{self._execution()}[{feedback}]", "")
            parameters = (*parameters, run)
        return HandlerView(
            self._method_name(layout),
            parameters,
            self._in_class(self._result_hint(layout, sending=True)),
            self._doc(layout) or (f"Handles calls of `{short_name(layout)}`.",),
        )

    def _execution(self) -> str:
        """Returns the name that the generated module uses for gecos.Execution."""
        return "_Execution"

    def _inward(self, attribute: Attribute) -> InwardView:
        hint = self._lowering.hint(self._sample(attribute).node)
        doc = type_doc(attribute.facts, value_note(attribute.unit, attribute.range))
        rate = attribute.stream.rate_hz if attribute.stream else None
        if rate:
            doc = (*doc, *([""] if doc else []), f"Takes {rate:g} samples a second.")
        return InwardView(
            self.constants.name(self._name, attribute.name),
            names.method_name(attribute.name),
            hint,
            self._in_class(hint),
            self._inward_table(attribute),
            doc or (f"The samples of {attribute.name}, from clients to the servant.",),
        )

    def _publisher(self, attribute: Attribute, getter: CallLayout) -> PublisherView:
        hint = self._lowering.hint(self._outputs(getter)[0].node, sending=True)
        return PublisherView(
            names.publisher(attribute.name),
            f"Publishes a sample of `{attribute.name}`.",
            self._in_class(hint),
            self._in_class("float | None"),
            f"0x{getter.code:08X}",
            self._constant(getter),
            names.lender(attribute.name) if self._in_place(attribute) else "",
        )

    def _event(self, event: Attribute) -> EventView:
        hint = self._lowering.hint(self._sample(event).node)
        return EventView(
            self._event_constant(event),
            names.method_name(event.name),
            hint,
            self._in_class(hint),
            self._event_table(event),
            type_doc(event.facts) or (f"The events `{event.name}`.",),
        )

    def _event_publisher(self, event: Attribute) -> PublisherView:
        return PublisherView(
            names.publisher(event.name),
            f"Sends the event `{event.name}` to all subscribers.",
            self._in_class(self._lowering.hint(self._sample(event).node, sending=True)),
            self._in_class("float | None"),
            f"0x{self._layout.stream(event.scoped_name).code:08X}",
            self._event_constant(event),
            "",
        )

    def _event_constant(self, event: Attribute) -> str:
        return self.constants.name(self._name, event.name)
