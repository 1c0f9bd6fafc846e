"""Methods of client proxies."""

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
    parameter_value,
    short_name,
)
from gidl.targets.cpp.calls.facts import CallFacts
from gidl.targets.cpp.calls.views import (
    MethodView,
)
from gidl.targets.cpp.lower.statements import block, conjunction, indented
from gidl.targets.naming import (
    LocalNames,
    doc_lines,
    value_note,
)
from gidl.type_names import escaped
from gidl.wire_layout import CallKind, CallLayout


class Client(CallFacts):
    def _method(self, call: CallLayout) -> MethodView:
        member = self._member(call)
        if isinstance(member, Operation):
            name, values = (
                escaped(member.name, CPP_WORDS),
                [parameter_value(p) for p in member.inputs],
            )
            doc = self._operation_doc(member)
        elif call.kind is CallKind.SETTER:
            name, values = self._setter_name(member), [attribute_value(member)]
            note = value_note(member.unit, member.range)
            doc = doc_lines(member.facts, note) or (f"Sets {member.name}.",)
        else:
            name, values = escaped(member.name, CPP_WORDS), []
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        returns = f"gecos::Command<{self._command_types(call, member)}>"
        parameters = self._parameters(values)
        taken = {n for _, n, _ in parameters}
        body = self._call_body(call, values, taken, returns, member)
        return MethodView(
            doc,
            returns,
            name,
            ", ".join(f"{t} {n}{d}" for t, n, d in parameters),
            ", ".join(f"{t} {n}" for t, n, _ in parameters),
            tuple(body),
        )

    def _call_body(
        self,
        call: CallLayout,
        values: list[CallValue],
        taken: set[str],
        returns: str,
        member: Operation | Attribute,
    ) -> list[str]:
        slots = self._slots(values, short_name(call).removesuffix("="))
        local = LocalNames(taken)
        wrong, size, to = local.fresh("wrong"), local.fresh("size"), local.fresh("to")
        used = taken | {wrong, size, to}
        lines: list[str] = []
        checks = [line for s in slots for line in self._lowering.check(s, LocalNames(used))]
        if checks:
            lines += [f"const std::string {wrong} = [&]() -> std::string {{", *indented(checks)]
            lines += ["  return {};", "}();"]
            lines += block(
                f"if (!{wrong}.empty())",
                [
                    f"return {returns}(gecos::session::ended(",
                    f"    {{gecos::Detail::BadParameter, {wrong}, {{}}, {{}}}})"
                    f"{self._decode_argument(call, member)});",
                ],
            )
        constant, sizes = 0, []
        for slot in slots:
            always, more = self._lowering.size(slot, size, LocalNames(used))
            constant += always
            sizes += more
        size_text = str(constant)
        if sizes:
            lines += [f"std::size_t {size} = {constant};", *sizes]
            size_text = size
        writes = [line for s in slots for line in self._lowering.encode(s, to, LocalNames(used))]
        table = f"{self._prefix}_operations[{self._index(call)}]"
        if writes:
            lines += [
                f"return {returns}(gecos_session_->call(",
                f"    {table}, {size_text},",
                f"    [&](gecos::wire::Encoder& {to}) {{",
                *(f"      {line}" for line in writes),
                f"    }}, gecos_options_){self._decode_argument(call, member)});",
            ]
        else:
            lines += [
                f"return {returns}(gecos_session_->call(",
                f"    {table}, 0, [](gecos::wire::Encoder&) {{}}, gecos_options_)"
                f"{self._decode_argument(call, member)});",
            ]
        return lines

    def _decode_argument(self, call: CallLayout, member: Operation | Attribute) -> str:
        values = self._reply(call, member)
        if not values:
            return ""
        owner = short_name(call)
        return ",\n        " + self._decode_lambda(values, self._result_type(call, member), owner)

    def _decode_lambda(self, values: list[CallValue], result: str, owner: str) -> str:
        if len(values) > 1:
            terms = [["value.decode(from)"]]
        else:
            value = replace(values[0], name="value")
            (slot,) = self._slots([value], owner)
            slot = replace(slot, label=owner)
            terms = [self._lowering.decode(slot, "from", LocalNames({"value", "from"}))]
        lines = conjunction(terms)
        head = f"[](gecos::wire::Decoder& from, {result}& value)"
        if len(lines) == 1:
            return f"{head} {{ {lines[0]} }}"
        inner = "\n".join(f"          {line}" for line in lines)
        return f"{head} {{\n{inner}\n        }}"

    def _subscribing(self, attribute: Attribute, index: int) -> MethodView:
        value = attribute_value(attribute)
        used = self._lowering.type(value.type, value.optional)
        decode = self._decode_lambda([value], used, attribute.name)
        rate = attribute.stream.rate_hz if attribute.stream else None
        note = f"Samples of {attribute.name}"
        note += f", {rate:g} a second." if rate else "."
        return MethodView(
            (note,),
            f"tl::expected<gecos::Stream<{used}>, gecos::Failure>",
            escaped(attribute.name, CPP_WORDS),
            "gecos::StreamTag",
            "gecos::StreamTag",
            (
                f"auto core = gecos_session_->subscribe({self._prefix}_streams[{index}]);",
                "if (!core) return tl::unexpected(std::move(core.error()));",
                f"return gecos::Stream<{used}>(std::move(*core),\n        {decode});",
            ),
        )
