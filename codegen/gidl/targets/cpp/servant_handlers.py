"""Builds the views of servant handlers, of the code that calls them, and of stream publishers."""

from __future__ import annotations

from functools import cached_property

from gidl.model import (
    Attribute,
    Operation,
    SequenceType,
)
from gidl.model.bulk import stream_in_place
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    first_missing,
    parameter_value,
    short_name,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.call_facts import CallFacts, hex32
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.interface_views import (
    ArgumentView,
    HandlerView,
    InwardView,
    LendingView,
    PublisherView,
    ReadingView,
    ResultView,
    WritingView,
    Written,
)
from gidl.targets.cpp.statements import conjunction, joined_terms, or_at_end, quoted
from gidl.targets.cpp.type_text import Slot
from gidl.targets.groups import call as called
from gidl.targets.groups import group
from gidl.targets.naming import (
    LocalNames,
    value_note,
)
from gidl.wire.wire_layout import CallKind, CallLayout
from gidl.wire.wire_nodes import (
    AppendableNode,
    Node,
    ObjectNode,
    ScalarNode,
    StructNode,
    UnionNode,
)


def written(node: Node) -> Written:
    match node:
        case AppendableNode() | UnionNode(appendable=True):
            return "block"
        case ScalarNode(limits=None) | StructNode() | ObjectNode() | UnionNode():
            return "plain"
        case _:
            return "here"


class ServerSide(CallFacts):
    def _handler(self, call: CallLayout) -> HandlerView:
        member = self._member(call)
        if isinstance(member, Operation):
            name, values = (
                names.method_name(member.name),
                [parameter_value(p) for p in member.inputs],
            )
            doc = self._operation_doc(member)
        elif call.kind is CallKind.SETTER:
            name, values = self._setter_name(member), [attribute_value(member)]
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        else:
            name, values = names.method_name(member.name), []
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        parameters = [f"{t} {n}" for t, n, _ in self._parameters(values)]
        slots = self._slots(call.request, short_name(call).removesuffix("="))
        taken = {slot.expression for slot in slots}
        local = names.Locals(taken | {self._request})
        source, run, was_read = local.fresh("from"), local.fresh("run"), local.fresh("read")
        passed = [slot.expression for slot in slots]
        execution = ""
        if isinstance(member, Operation) and member.cancelable:
            feedback = self._lowering.type(member.feedback) if member.feedback else ""
            execution = f"gecos::Execution<{feedback}>"
            parameters.append(f"{execution}& {LocalNames(taken).fresh('run')}")
            passed.append(run)
        return HandlerView(
            doc,
            f"gecos::Result<{self._result_type(call, member)}>",
            name,
            group(parameters),
            hex32(call.code),
            short_name(call),
            tuple(map(self._argument, values, slots)),
            source,
            was_read,
            tuple(self._read(values, slots, source)),
            execution,
            run,
            group(passed),
            group((quoted(name) for name, _ in call.exceptions), "{", "}"),
            self._result_of(call, taken | {source, run}) if call.reply else None,
            call.name,
        )

    @cached_property
    def _request(self) -> str:
        """The name of the variable that holds the incoming call in the skeleton. No parameter has
        this name."""
        slots = [s for call in self._calls for s in self._slots(call.request, "")]
        return names.Locals(slot.expression for slot in slots).fresh("call")

    def _argument(self, value: CallValue, slot: Slot) -> ArgumentView:
        initial = "{}"
        if value.default is not None and not value.optional:
            initial = f" = {self._default(value)}"
        used = self._lowering.type(value.type, value.optional)
        return ArgumentView(used, slot.expression, initial)

    def _read(self, values: list[CallValue], slots: list[Slot], source: str) -> list[str]:
        required = first_missing(values)
        local = names.Locals({s.expression for s in slots} | {source, self._request})
        terms = []
        for i, slot in enumerate(slots):
            term = self._lowering.decode(slot, source, local)
            terms.append(or_at_end(source, term) if i >= required else term)
        return joined_terms(terms)

    def _result_of(self, call: CallLayout, taken: set[str]) -> ResultView:
        local = names.Locals(taken | {self._request})
        size, to, value = local.fresh("size"), local.fresh("to"), local.fresh("value")
        used = {*taken, self._request, value}

        def refused(why: str) -> str:
            return called(f"{self._request}.fail_result", quoted(call.name), why)

        if len(call.reply) > 1:
            encoded = (f"{value}.encode({to});",)
            return ResultView(
                "plain", value, (), WritingView((), f"{value}.encoded_size()", to, encoded)
            )
        node = call.reply[0].node
        slot = Slot(value, short_name(call), node)
        checks = self._lowering.check(slot, names.Locals({*used, size, to}), refused)
        return ResultView(
            written(node),
            value,
            tuple(checks),
            self._writing([slot], size, to, used),
        )

    def _inward(self, attribute: Attribute) -> InwardView:
        value = attribute_value(attribute)
        slot = Slot("value", attribute.name, self._layout.stream(attribute.scoped_name).sample.node)
        decoded = self._lowering.decode(slot, "from", names.Locals({"value", "from"}))
        note = f"The samples of {attribute.name} that clients send."
        return InwardView(
            doc_lines(attribute.facts, value_note(attribute.unit, attribute.range)) or (note,),
            names.method_name(attribute.name),
            f"gecos_inward_{attribute.name}_",
            self._lowering.type(value.type, value.optional),
            self._constant(self._stream_constants[attribute.name]),
            ReadingView("from", "value", tuple(conjunction([decoded]))),
        )

    def _publisher(self, attribute: Attribute) -> PublisherView:
        value = attribute_value(attribute)
        used = LocalNames(names.method_names(self._model, self._interface))
        layout = self._layout.stream(attribute.scoped_name)
        slot = Slot("value", attribute.name, layout.sample.node)
        taken = {"value", "stamp_ns"}

        def refused(why: str) -> str:
            return called("gecos_not_published", quoted(attribute.scoped_name), why)

        return PublisherView(
            used.fresh(f"publish_{attribute.name}"),
            f"Publishes a sample of `{attribute.name}`, measured at `stamp_ns`. Only one thread at "
            "a time may call it."
            if attribute.event is None
            else f"Sends the event `{attribute.name}`, which occurred at `stamp_ns`. Any thread "
            "may call it.",
            attribute.scoped_name,
            written(layout.sample.node),
            f"{self._lowering.parameter(value.type, value.optional)} value",
            self._constant(self._stream_constants[attribute.name]),
            tuple(self._lowering.check(slot, names.Locals({*taken, "size", "to"}), refused)),
            self._writing([slot], "size", "to", taken),
            self._lending(attribute, used),
        )

    def _lending(self, attribute: Attribute, used: LocalNames) -> LendingView | None:
        member = stream_in_place(self._model, attribute)
        if member is None:
            return None
        sequence = self._model.target(member.type)
        assert isinstance(sequence, SequenceType)
        most = "gecos::wire::npos" if sequence.bound is None else str(sequence.bound)
        return LendingView(
            used.fresh(f"lend_{attribute.name}"), names.member_name(member.name), most
        )
