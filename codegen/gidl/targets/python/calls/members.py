"""Members of proxies, handlers and publishers of servants."""

from __future__ import annotations

from gidl.model import Attribute, Operation
from gidl.targets.calls import (
    attribute_value,
    first_missing,
    short_name,
)
from gidl.targets.naming import LocalNames, value_note
from gidl.targets.python import names
from gidl.targets.python.calls.bodies import Bodies
from gidl.targets.python.calls.views import (
    HandlerView,
    ProxyMemberView,
    PublisherView,
)
from gidl.targets.python.lower import Slot
from gidl.targets.python.values.names import LOCAL_WORDS, type_doc
from gidl.wire_layout import CallKind, CallLayout


class Members(Bodies):
    def _doc(self, call: CallLayout) -> tuple[str, ...]:
        member = self._member(call)
        if isinstance(member, Attribute):
            doc = type_doc(member.facts, value_note(member.unit, member.range))
            if call.kind is CallKind.SETTER and not doc:
                return (f"Sets {member.name}.",)
            return doc
        lines = list(type_doc(member.facts, value_note(member.result_unit, member.result_range)))
        notes = []
        called = {
            v.name: x for v, x in zip(self._inputs(call), self._parameter_names(call), strict=True)
        }
        for p in member.parameters:
            note = value_note(p.unit, p.range)
            if note or p.facts.doc:
                notes.append(f"{called.get(p.name, p.name)}: {' '.join(type_doc(p.facts, note))}")
        if call.exceptions:
            listed = ", ".join(names.type_name(self._model, name) for name, _ in call.exceptions)
            notes.append(f"May raise {listed}.")
        return (*lines, *([""] if lines and notes else []), *notes)

    def _parameters(self, call: CallLayout, defaults: bool) -> list[str]:
        values = self._inputs(call)
        missing = first_missing(values)
        texts = []
        for i, (name, value) in enumerate(zip(self._parameter_names(call), values, strict=True)):
            default = f" = {self._missing(value)}" if defaults and i >= missing else ""
            texts.append(f"{name}: {self._in_class(self._hint(value))}{default}")
        return texts

    def _proxy_member(self, call: CallLayout) -> ProxyMemberView:
        member = self._member(call)
        result = self._in_class(self._result_hint(call))
        feedback = self._in_class(self._feedback_hint(call))
        name = self._method_name(call)
        if isinstance(member, Attribute) and member.streams_out and call.kind is CallKind.GETTER:
            rate = member.stream.rate_hz if member.stream else None
            doc = self._doc(call)
            if rate:
                doc = (*doc, *([""] if doc else []), f"Published {rate:g} times a second.")
            stream = self._stream_constant(member)
            return ProxyMemberView(
                True,
                f"def {name}(self) -> _StreamAttribute[{result}]:",
                doc,
                (f"return _StreamAttribute(self, {self._constant(call)}, {stream})",),
            )
        command = f"_Command[{result}]" if feedback == "None" else f"_Command[{result}, {feedback}]"
        parameters = ", ".join(["self", *self._parameters(call, defaults=True)])
        values = self._inputs(call)
        inputs = self._parameter_names(call)
        taken = LocalNames(LOCAL_WORDS | self._type_names(values) | set(inputs))
        lines = []
        label = short_name(call).removesuffix("=")
        out = "[]"
        if values:
            out = "out"
            lines.append("out: _Parts = []")
            for x, v in zip(inputs, values, strict=True):
                slot = Slot(x, f"{label}.{v.name}", v.type, v.optional, v.range)
                lines += self._lowering.encode(slot, taken)
        lines.append(f"return self._gecos_call({self._constant(call)}, {out})")
        return ProxyMemberView(
            False, f"def {name}({parameters}) -> {command}:", self._doc(call), tuple(lines)
        )

    def _handler(self, call: CallLayout) -> HandlerView:
        member = self._member(call)
        parameters = ["self", *self._parameters(call, defaults=False)]
        if isinstance(member, Operation) and member.cancelable:
            run = LocalNames(p.partition(":")[0] for p in parameters).fresh("run")
            parameters.append(f"{run}: _Execution[{self._in_class(self._feedback_hint(call))}]")
        name = self._method_name(call)
        result = self._in_class(self._result_hint(call))
        return HandlerView(
            f"0x{call.code:08X}",
            self._constant(call),
            name,
            self._arguments(call),
            self._writer(call),
            f"def {name}({', '.join(parameters)}) -> {result}:",
            self._doc(call) or (f"Answers {short_name(call)}.",),
        )

    def _publisher(self, attribute: Attribute) -> PublisherView:
        value = attribute_value(attribute)
        name = names.method_names(self._model, self.interface).fresh(f"publish_{attribute.name}")
        slot = Slot("value", attribute.name, value.type, value.optional, value.range)
        code = self._layout.stream(attribute.scoped_name).code
        local = LocalNames(LOCAL_WORDS | self._type_names([value]) | {"value", "stamp"})
        hint = self._in_class(self._hint(value))
        body = [
            "out: _Parts = []",
            *self._lowering.encode(slot, local),
            f"self._gecos_publish(0x{code:08X}, out, stamp)",
        ]
        stamp = self._in_class("float | None")
        return PublisherView(
            f"def {name}(self, value: {hint}, stamp: {stamp} = None) -> None:",
            f"A new sample of `{attribute.name}`, measured at `stamp` (Unix time in s; now).",
            tuple(body),
        )
