"""Members of proxies, handlers and publishers of servants."""

from __future__ import annotations

from gidl.model import Attribute, Operation
from gidl.targets.calls import first_missing, short_name
from gidl.targets.groups import call, group
from gidl.targets.naming import LocalNames, doc_lines, value_note
from gidl.targets.python import names
from gidl.targets.python.calls.bodies import Bodies
from gidl.targets.python.calls.views import (
    HandlerView,
    ProxyMemberView,
    PublisherView,
)
from gidl.targets.python.values.names import LOCAL_WORDS, type_doc
from gidl.wire_layout import CallKind, CallLayout


class Members(Bodies):
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

    def _parameters(self, layout: CallLayout, calling: bool) -> list[str]:
        """Of a proxy, or of a handler, which gets every one."""
        values = self._inputs(layout)
        missing = first_missing([each.value for each in values])
        texts = []
        called = self._parameter_names(layout)
        for i, (name, each) in enumerate(zip(called, values, strict=True)):
            default = f" = {self._missing(each)}" if calling and i >= missing else ""
            hint = self._in_class(self._lowering.hint(each.node, sending=calling))
            texts.append(f"{name}: {hint}{default}")
        return texts

    def _proxy_member(self, layout: CallLayout) -> ProxyMemberView:
        member = self._member(layout)
        result = self._in_class(self._result_hint(layout))
        feedback = self._in_class(self._feedback_hint(layout))
        name = self._method_name(layout)
        if isinstance(member, Attribute) and member.streams_out and layout.kind is CallKind.GETTER:
            rate = member.stream.rate_hz if member.stream else None
            doc = self._doc(layout)
            if rate:
                doc = (*doc, *([""] if doc else []), f"Published {rate:g} times a second.")
            stream = self._stream_constant(member)
            made = call("_StreamAttribute", "self", self._constant(layout), stream)
            head = f"def {name}(self) -> _StreamAttribute[{result}]:"
            return ProxyMemberView(True, head, doc, (f"return {made}",))
        command = f"_Command[{result}]" if feedback == "None" else f"_Command[{result}, {feedback}]"
        parameters = group(["self", *self._parameters(layout, calling=True)])
        values = self._inputs(layout)
        inputs = self._parameter_names(layout)
        taken = LocalNames(LOCAL_WORDS | self._type_names(values) | set(inputs))
        lines = []
        label = short_name(layout).removesuffix("=")
        out = "[]"
        if values:
            out = "out"
            lines.append("out: _Parts = []")
            for x, each in zip(inputs, values, strict=True):
                slot = each.slot(x, f"{label}.{each.value.name}")
                lines += self._lowering.encode(slot, taken)
        lines.append(f"return {call('self._gecos_call', self._constant(layout), out)}")
        return ProxyMemberView(
            False, f"def {name}{parameters} -> {command}:", self._doc(layout), tuple(lines)
        )

    def _handler_head(self, layout: CallLayout) -> str:
        member = self._member(layout)
        parameters = ["self", *self._parameters(layout, calling=False)]
        if isinstance(member, Operation) and member.cancelable:
            feedback = self._in_class(self._feedback_hint(layout))
            parameters.append(f"{self._run(layout)}: _Execution[{feedback}]")
        result = self._in_class(self._result_hint(layout, sending=True))
        return f"def {self._method_name(layout)}{group(parameters)} -> {result}:"

    def _run(self, layout: CallLayout) -> str:
        """What a handler calls its execution."""
        return LocalNames(self._parameter_names(layout)).fresh("run")

    def _handler(self, layout: CallLayout) -> HandlerView:
        return HandlerView(
            f"0x{layout.code:08X}",
            self._constant(layout),
            self._method_name(layout),
            self._arguments(layout),
            self._writer(layout),
            self._handler_head(layout),
            self._doc(layout) or (f"Answers {short_name(layout)}.",),
        )

    def _publisher(self, attribute: Attribute) -> PublisherView:
        sample = self._sample(attribute)
        code = self._layout.stream(attribute.scoped_name).code
        local = LocalNames(LOCAL_WORDS | self._type_names([sample]) | {"value", "stamp"})
        hint = self._in_class(self._lowering.hint(sample.node, sending=True))
        stamp = self._in_class("float | None")
        parameters = group(["self", f"value: {hint}", f"stamp: {stamp} = None"])
        return PublisherView(
            f"def {names.publisher(attribute.name)}{parameters} -> None:",
            f"A new sample of `{attribute.name}`, measured at `stamp` (Unix time in s; now).",
            (
                "out: _Parts = []",
                *self._lowering.encode(sample.slot("value", attribute.name), local),
                f"self._gecos_publish(0x{code:08X}, out, stamp)",
            ),
        )
