"""Handlers of servants, their callers, and publishers of streams."""

from __future__ import annotations

from dataclasses import replace

from gidl.languages import CPP_WORDS
from gidl.model import (
    Attribute,
    Operation,
)
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    first_missing,
    parameter_value,
    short_name,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.calls.facts import CallFacts, hex32, request_name, why_not
from gidl.targets.cpp.calls.views import (
    HandlerView,
    PublisherView,
)
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.lower import Slot
from gidl.targets.cpp.lower.statements import block, conjunction, indented, or_at_end, quoted
from gidl.targets.groups import call as called
from gidl.targets.groups import group
from gidl.targets.naming import (
    LocalNames,
    value_note,
)
from gidl.type_names import escaped
from gidl.wire_layout import CallKind, CallLayout


class ServerSide(CallFacts):
    def _handler(self, call: CallLayout) -> HandlerView:
        member = self._member(call)
        if isinstance(member, Operation):
            name, values = (
                escaped(member.name, CPP_WORDS),
                [parameter_value(p) for p in member.inputs],
            )
            doc = self._operation_doc(member)
        elif call.kind is CallKind.SETTER:
            name, values = self._setter_name(member), [attribute_value(member)]
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        else:
            name, values = escaped(member.name, CPP_WORDS), []
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        parameters = [f"{t} {n}" for t, n, _ in self._parameters(values)]
        execution = ""
        if isinstance(member, Operation) and member.cancelable:
            feedback = self._lowering.type(member.feedback) if member.feedback else ""
            execution = f"gecos::Execution<{feedback}>"
            run = LocalNames(escaped(v.name, CPP_WORDS) for v in values).fresh("run")
            parameters.append(f"{execution}& {run}")
        returns = f"gecos::Result<{self._result_type(call, member)}>"
        return HandlerView(
            doc,
            returns,
            name,
            group(parameters),
            self._caller_name(call),
            request_name(self._slots(call.request, "")),
            hex32(call.code),
            call.name,
            tuple(self._handler_body(call, member, name, values, execution)),
        )

    def _handler_body(
        self,
        call: CallLayout,
        member: Operation | Attribute,
        name: str,
        values: list[CallValue],
        execution: str,
    ) -> list[str]:
        slots = self._slots(call.request, short_name(call).removesuffix("="))
        taken = {slot.expression for slot in slots}
        local = LocalNames(taken)
        source, result, run, request = (
            local.fresh("from"), local.fresh("result"), local.fresh("run"), request_name(slots),
        )  # fmt: skip
        lines = []
        if values:
            lines += self._read_arguments(values, slots, source, request, call)
        arguments = [slot.expression for slot in slots]
        if execution:
            lines.append(f"{execution} {run}({request});")
            arguments.append(run)
        lines.append(f"const auto {result} = this->{name}({', '.join(arguments)});")
        declared = group((quoted(name) for name, _ in call.exceptions), "{", "}")
        failed = called(f"{request}.fail", f"{result}.error()", declared)
        lines.append(f"if (!{result}) return {failed};")
        lines += self._answer(call, member, result, request, taken)
        return lines

    def _read_arguments(
        self,
        values: list[CallValue],
        slots: list[Slot],
        source: str,
        request: str,
        call: CallLayout,
    ) -> list[str]:
        lines = [f"gecos::wire::Decoder {source}({request}.arguments());"]
        required = first_missing(values)
        taken = LocalNames({s.expression for s in slots} | {source, request})
        terms = []
        for i, (value, slot) in enumerate(zip(values, slots, strict=True)):
            initial = "{}"
            if value.default is not None and not value.optional:
                initial = f" = {self._default(value)}"
            used = self._lowering.type(value.type, value.optional)
            lines.append(f"{used} {slot.expression}{initial};")
            term = self._lowering.decode(slot, source, taken)
            if i >= required:
                term = or_at_end(source, term)
            terms.append(term)
        read = taken.fresh("read")
        expression = conjunction(terms)
        expression[0] = f"const bool {read} = {expression[0].removeprefix('return ')}"
        lines += expression
        lines += block(
            f"if (!{read})",
            [f"return {fail(request, 'BadParameter', f'{source}.error().message()')};"],
        )
        return lines

    def _answer(
        self,
        call: CallLayout,
        member: Operation | Attribute,
        result: str,
        request: str,
        taken: set[str],
    ) -> list[str]:
        if not call.reply:
            return [f"{request}.finish(0, [](gecos::wire::Encoder&) {{}});"]
        local = LocalNames(taken | {result, request})
        size, to, value = local.fresh("size"), local.fresh("to"), local.fresh("value")
        lines = [f"const auto& {value} = *{result};"]
        lines += self._checked_answer(call, value, request, LocalNames(taken | {result, request}))
        if len(call.reply) > 1:
            return [
                *lines,
                f"{request}.finish({value}.encoded_size(),",
                f"            [&](gecos::wire::Encoder& {to}) {{ {value}.encode({to}); }});",
            ]
        slot = Slot(value, short_name(call), call.reply[0].node)
        always, more = self._lowering.size(slot, size, LocalNames(taken | {size, value}))
        size_text = str(always)
        if more:
            lines += [f"std::size_t {size} = {always};", *more]
            size_text = size
        writes = self._lowering.encode(slot, to, LocalNames(taken | {to, value}))
        if len(writes) == 1:
            lines.append(
                f"{request}.finish({size_text}, [&](gecos::wire::Encoder& {to}) {{ {writes[0]} }});"
            )
        else:
            lines += [
                f"{request}.finish({size_text}, [&](gecos::wire::Encoder& {to}) {{",
                *indented(writes),
                "});",
            ]
        return lines

    def _checked_answer(
        self, call: CallLayout, value: str, request: str, local: LocalNames
    ) -> list[str]:
        """Refuses what a handler must not give."""
        wrong = local.fresh("wrong")
        if len(call.reply) > 1:
            if not self._lowering.have_checks(call.reply):
                return []
            place = self._layout.cpp_names.results[call.name]
            violation = names.absolute(replace(place, name="gecos_violation"))
            lines = [f"const std::string {wrong} = {violation}({value});"]
        else:
            slot = Slot(value, short_name(call), call.reply[0].node)
            lines = why_not(self._lowering.check(slot, local), wrong)
        if not lines:
            return []
        told = f'"the handler of {call.name} gave " + {wrong}'
        refusal = f"return {fail(request, 'Fault', told)};"
        return [*lines, *block(f"if (!{wrong}.empty())", [refusal])]

    def _publisher(self, attribute: Attribute, index: int) -> PublisherView:
        value = attribute_value(attribute)
        used = LocalNames(names.method_names(self._model, self._interface))
        name = used.fresh(f"publish_{attribute.name}")
        layout = self._layout.stream(attribute.scoped_name)
        slot = Slot("value", attribute.name, layout.sample.node)
        taken = {"value", "stamp_ns"}
        lines = ["if (gecos_publisher_ == nullptr) return;"]
        checks = self._lowering.check(slot, LocalNames({*taken, "wrong"}))
        if checks:
            lines += why_not(checks, "wrong")
            told = '"not published: " + wrong'
            lines += block(
                "if (!wrong.empty())",
                [
                    f"{called('gecos::log_error', quoted(attribute.scoped_name), told)};",
                    "return;",
                ],
            )
        always, more = self._lowering.size(slot, "size", LocalNames({*taken, "size"}))
        if layout.sample.fixed_size is not None:
            lines.append(f"std::array<std::byte, {always}> sample;")
        else:
            lines += (
                [f"std::size_t size = {always};", *more]
                if more
                else [f"const std::size_t size = {always};"]
            )
            lines.append("gecos::Bytes sample(size);")
        lines.append("gecos::wire::Encoder to(sample);")
        lines += self._lowering.encode(slot, "to", LocalNames({*taken, "size", "to", "sample"}))
        lines.append(
            called(
                "gecos_publisher_->publish",
                f"{self._type}::gecos_description().streams[{index}]",
                "sample",
                "stamp_ns",
            )
            + ";"
        )
        sample = f"{self._lowering.parameter(value.type, value.optional)} value"
        return PublisherView(name, attribute.name, sample, tuple(lines))


def fail(request: str, detail: str, text: str) -> str:
    failure = group([f"gecos::Detail::{detail}", text, "{}", "{}"], "{", "}")
    return called(f"{request}.fail", failure)
