"""Methods of client proxies."""

from __future__ import annotations

from gidl.languages import CPP_WORDS
from gidl.model import (
    Attribute,
    Operation,
)
from gidl.targets.calls import (
    attribute_value,
    parameter_value,
    short_name,
)
from gidl.targets.cpp.calls.facts import CallFacts, why_not
from gidl.targets.cpp.calls.views import (
    MethodView,
)
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.lower import Slot
from gidl.targets.cpp.lower.statements import block, conjunction
from gidl.targets.groups import flat, group
from gidl.targets.naming import (
    LocalNames,
    value_note,
)
from gidl.type_names import escaped
from gidl.wire_layout import CallKind, CallLayout, FieldLayout


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
        body = self._call_body(call, taken, returns, member)
        return MethodView(
            doc,
            returns,
            name,
            group(f"{t} {n}{d}" for t, n, d in parameters),
            group(f"{t} {n}" for t, n, _ in parameters),
            tuple(body),
        )

    def _call_body(
        self,
        call: CallLayout,
        taken: set[str],
        returns: str,
        member: Operation | Attribute,
    ) -> list[str]:
        slots = self._slots(call.request, short_name(call).removesuffix("="))
        local = LocalNames(taken)
        wrong, size, to = local.fresh("wrong"), local.fresh("size"), local.fresh("to")
        used = taken | {wrong, size, to}
        decode = self._decode_argument(call, member, taken)
        lines: list[str] = []
        checks = [line for s in slots for line in self._lowering.check(s, LocalNames(used))]
        if checks:
            lines += why_not(checks, wrong)
            lines += block(
                f"if (!{wrong}.empty())",
                [
                    f"return {returns}(gecos::session::ended(",
                    f"    {{gecos::Detail::BadParameter, {wrong}, {{}}, {{}}}}){decode});",
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
        table = f"gecos_description().operations[{self._index(call)}]"
        if writes:
            lines += [
                f"return {returns}(gecos_session_->call(",
                f"    {table}, {size_text},",
                f"    [&](gecos::wire::Encoder& {to}) {{",
                *(f"      {line}" for line in writes),
                f"    }}, gecos_options_){decode});",
            ]
        else:
            lines += [
                f"return {returns}(gecos_session_->call(",
                f"    {table}, 0, [](gecos::wire::Encoder&) {{}}, gecos_options_){decode});",
            ]
        return lines

    def _decode_argument(
        self, call: CallLayout, member: Operation | Attribute, taken: set[str]
    ) -> str:
        if not call.reply:
            return ""
        result = self._result_type(call, member)
        return ",\n        " + self._decode_lambda(call.reply, result, short_name(call), taken)

    def _decode_lambda(
        self, reply: tuple[FieldLayout, ...], result: str, owner: str, taken: set[str]
    ) -> str:
        local = LocalNames(taken)
        value, source = local.fresh("value"), local.fresh("from")
        if len(reply) > 1:
            terms = [[f"{value}.decode({source})"]]
        else:
            slot = Slot(value, owner, reply[0].node)
            terms = [self._lowering.decode(slot, source, LocalNames({*taken, value, source}))]
        lines = conjunction(terms)
        head = f"[](gecos::wire::Decoder& {source}, {result}& {value})"
        if len(lines) == 1 and len(flat(head + lines[0])) < 86:
            return f"{head} {{ {lines[0]} }}"
        inner = "\n".join(f"          {line}" for line in lines)
        return f"{head} {{\n{inner}\n        }}"

    def _subscribing(self, attribute: Attribute, index: int) -> MethodView:
        value = attribute_value(attribute)
        used = self._lowering.type(value.type, value.optional)
        sample = self._layout.stream(attribute.scoped_name).sample
        decode = self._decode_lambda((sample,), used, attribute.name, set())
        rate = attribute.stream.rate_hz if attribute.stream else None
        note = f"Samples of {attribute.name}"
        note += f", {rate:g} a second." if rate else "."
        return MethodView(
            (note,),
            f"tl::expected<gecos::Stream<{used}>, gecos::Failure>",
            escaped(attribute.name, CPP_WORDS),
            group(["gecos::StreamTag"]),
            group(["gecos::StreamTag"]),
            (
                f"auto core = gecos_session_->subscribe(gecos_description().streams[{index}]);",
                "if (!core) return tl::unexpected(std::move(core.error()));",
                f"return gecos::Stream<{used}>(std::move(*core),\n        {decode});",
            ),
        )
