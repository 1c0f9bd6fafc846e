"""What the templates of `<file>_client.{hpp,cpp}` and `<file>_server.{hpp,cpp}` print."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gidl.model import (
    Attribute,
    File,
    Interface,
    Model,
    Operation,
)
from gidl.policy import OnLoss, OnNew, Qos, QualityClass, Reliability
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    first_missing,
    parameter_value,
    refuse_unsupported,
    reply_values,
    result_struct,
    short_name,
    stream_attributes,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.lower import Lowering, Slot, block, indented
from gidl.targets.cpp.types_view import conjunction, or_at_end
from gidl.targets.naming import (
    LocalNames,
    doc_lines,
    escaped,
    snake_case,
    source_stem,
    value_note,
)
from gidl.wire_layout import CallKind, CallLayout

LARGEST_ON_SHM = frozenset(("shm", "can"))


@dataclass(frozen=True, slots=True)
class OperationRow:
    """A line of the table that the session reads."""

    code: str
    name: str
    kind: str
    status: str
    safety: str
    presence: str
    idempotent: str
    cancelable: str
    parallel: str
    ordered: str
    on_new: str
    on_loss: str
    quality: str
    hash: str


@dataclass(frozen=True, slots=True)
class StreamRow:
    code: str
    name: str
    status: str
    rate: str
    largest: str
    quality: str


@dataclass(frozen=True, slots=True)
class MethodView:
    """A method of a client proxy."""

    doc: tuple[str, ...]
    returns: str
    name: str
    declared: str  # parameters with defaults
    defined: str  # parameters without
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HandlerView:
    """What the implementer of a server writes, and the function that calls it."""

    doc: tuple[str, ...]
    returns: str
    name: str
    parameters: str
    caller: str  # "gecos_call_move"
    request: str  # name of its parameter
    code: str
    operation: str  # "robcl::Manipulator::move"
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PublisherView:
    name: str
    stream: str  # its IDL name
    parameter: str
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class CaseView:
    code: str
    caller: str
    name: str


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    scoped_name: str
    doc: tuple[str, ...]
    version: str
    hash: str
    prefix: str  # of its tables: "manipulator"
    client_bases: str
    server_bases: str
    bases: tuple[str, ...]  # scoped names of every interface it also is
    operations: tuple[OperationRow, ...]
    streams: tuple[StreamRow, ...]
    quality: str
    methods: tuple[MethodView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]
    cases: tuple[CaseView, ...]  # inherited ones too, by code


@dataclass(frozen=True, slots=True)
class InterfacesNamespace:
    name: str
    interfaces: tuple[InterfaceView, ...]


@dataclass(frozen=True, slots=True)
class InterfacesView:
    source: str
    types_header: str
    client_header: str
    server_header: str
    client_includes: tuple[str, ...]
    server_includes: tuple[str, ...]
    namespaces: tuple[InterfacesNamespace, ...]


def interfaces_view(lowering: Lowering, file: File) -> InterfacesView:
    model = lowering.model
    stem = source_stem(file.path)
    others = [path for path in file.includes if _has_interface(model, path)]
    spaces: list[InterfacesNamespace] = []
    for declaration in file.declarations:
        if not isinstance(declaration, Interface):
            continue
        scope = "::".join(names.scope_of(model, declaration.name))
        view = _InterfaceBuilder(lowering, declaration).view()
        if spaces and spaces[-1].name == scope:
            spaces[-1] = replace(spaces[-1], interfaces=(*spaces[-1].interfaces, view))
        else:
            spaces.append(InterfacesNamespace(scope, (view,)))
    return InterfacesView(
        file.path,
        f"{stem}_types.hpp",
        f"{stem}_client.hpp",
        f"{stem}_server.hpp",
        tuple(sorted(f"{source_stem(path)}_client.hpp" for path in others)),
        tuple(sorted(f"{source_stem(path)}_server.hpp" for path in others)),
        tuple(spaces),
    )


def _has_interface(model: Model, path: str) -> bool:
    return any(file.path == path and file.has_interface for file in model.files)


class _InterfaceBuilder:
    def __init__(self, lowering: Lowering, interface: Interface) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self._interface = interface
        self._members = {m.scoped_name: m for m in self._model.all_interface_members(interface)}
        self._calls = sorted(
            self._layout.all_calls(self._model, interface), key=lambda call: call.code
        )
        self._name = names.simple_name(self._model, interface.name)
        self._prefix = snake_case(self._name)
        self._methods = LocalNames(names.method_names(self._model, interface))

    def view(self) -> InterfaceView:
        interface = self._interface
        refuse_unsupported(interface)
        streams = stream_attributes(self._model, self._layout, interface)
        methods: list[MethodView] = []
        handlers: list[HandlerView] = []
        for call in self._layout.interfaces[interface.name].calls:
            methods.append(self._method(call))
            handlers.append(self._handler(call))
            member = self._member(call)
            if (
                call.kind is CallKind.GETTER
                and isinstance(member, Attribute)
                and member.streams_out
            ):
                methods.append(self._subscribing(member, streams.index(member)))
        own = [s for s in streams if s.interface == interface.name]
        bases = [names.full_name(self._model, base) for base in interface.bases]
        return InterfaceView(
            names.simple_name(self._model, interface.name),
            interface.name,
            doc_lines(interface.facts),
            interface.facts.version or "",
            _hex64(self._layout.interfaces[interface.name].hash),
            self._prefix,
            ", ".join(f"public virtual {base}" for base in bases or ["gecos::Object"]),
            ", ".join(
                f"public virtual {base}"
                for base in [f"{b}Servant" for b in bases] or ["gecos::Servant"]
            ),
            interface.all_bases,
            tuple(self._row(call) for call in self._calls),
            tuple(self._stream_row(attribute) for attribute in streams),
            quality(interface.qos),
            tuple(methods),
            tuple(handlers),
            tuple(self._publisher(s, streams.index(s)) for s in own),
            tuple(
                CaseView(_hex32(c.code), self._caller_name(c), short_name(c)) for c in self._calls
            ),
        )

    def _member(self, call: CallLayout) -> Operation | Attribute:
        return self._members[call.name.removesuffix("=")]

    def _index(self, call: CallLayout) -> int:
        return self._calls.index(call)

    # -- tables ------------------------------------------------------------------------------------

    def _row(self, call: CallLayout) -> OperationRow:
        member = self._member(call)
        if isinstance(member, Operation):
            status, presence = member.access.name, member.needs_presence
            safety, cancelable, ordered = member.safety, member.cancelable, member.ordered
            idempotent = member.idempotent
            kind = "Operation"
        else:
            setter = call.kind is CallKind.SETTER
            status = (member.write_access if setter else member.read_access).name
            presence = setter and member.write_needs_presence
            safety = cancelable = ordered = False
            idempotent = member.idempotent or not setter
            kind = "Setter" if setter else "Getter"
        return OperationRow(
            _hex32(call.code), short_name(call), kind, status.capitalize(),
            _bool(safety), _bool(presence), _bool(idempotent), _bool(cancelable),
            _bool(member.parallel), _bool(ordered), _on_new(member.on_new),
            "Finish" if member.on_loss is OnLoss.FINISH else "Stop",
            quality(member.qos), _hex64(call.hash),
        )  # fmt: skip

    def _stream_row(self, attribute: Attribute) -> StreamRow:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        return StreamRow(
            _hex32(layout.code),
            attribute.name,
            attribute.read_access.name.capitalize(),
            repr(float(attribute.stream.rate_hz or 0)),
            str(layout.sample.fixed_size or 0),
            quality(attribute.qos),
        )

    # -- client ------------------------------------------------------------------------------------

    def _method(self, call: CallLayout) -> MethodView:
        member = self._member(call)
        if isinstance(member, Operation):
            name, values = (
                escaped(member.name, names.KEYWORDS),
                [parameter_value(p) for p in member.inputs],
            )
            doc = self._operation_doc(member)
        elif call.kind is CallKind.SETTER:
            name, values = self._setter_name(member), [attribute_value(member)]
            note = value_note(member.unit, member.range)
            doc = doc_lines(member.facts, note) or (f"Sets {member.name}.",)
        else:
            name, values = escaped(member.name, names.KEYWORDS), []
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

    def _operation_doc(self, operation: Operation) -> tuple[str, ...]:
        doc = list(
            doc_lines(operation.facts, value_note(operation.result_unit, operation.result_range))
        )
        for p in operation.parameters:
            note = value_note(p.unit, p.range)
            if note or p.facts.doc:
                text = " ".join(doc_lines(p.facts, note))
                doc.append(f"@param {escaped(p.name, names.KEYWORDS)} {text}")
        if operation.raises:
            raised = ", ".join(names.full_name(self._model, name) for name in operation.raises)
            doc.append(f"May fail with {raised}.")
        return tuple(doc)

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
                    escaped(value.name, names.KEYWORDS),
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
        assert isinstance(member, Operation)
        struct = result_struct(self._layout, member)
        assert struct is not None
        return names.full_name_of(self._model, struct.name)

    def _command_types(self, call: CallLayout, member: Operation | Attribute) -> str:
        result = self._result_type(call, member)
        if isinstance(member, Operation) and member.feedback is not None:
            return f"{result}, {self._lowering.type(member.feedback)}"
        return result

    def _slots(self, values: list[CallValue], owner: str) -> list[Slot]:
        return [
            Slot(escaped(v.name, names.KEYWORDS), f"{owner}.{v.name}", v.type, v.optional, v.range)
            for v in values
        ]

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
            escaped(attribute.name, names.KEYWORDS),
            "gecos::StreamTag",
            "gecos::StreamTag",
            (
                f"auto core = gecos_session_->subscribe({self._prefix}_streams[{index}]);",
                "if (!core) return tl::unexpected(std::move(core.error()));",
                f"return gecos::Stream<{used}>(std::move(*core),\n        {decode});",
            ),
        )

    # -- server ------------------------------------------------------------------------------------

    def _caller_name(self, call: CallLayout) -> str:
        short = short_name(call)
        if short.endswith("="):
            return f"gecos_set_{short.removesuffix('=')}"
        return f"gecos_call_{short}"

    def _handler(self, call: CallLayout) -> HandlerView:
        member = self._member(call)
        if isinstance(member, Operation):
            name, values = (
                escaped(member.name, names.KEYWORDS),
                [parameter_value(p) for p in member.inputs],
            )
            doc = self._operation_doc(member)
        elif call.kind is CallKind.SETTER:
            name, values = self._setter_name(member), [attribute_value(member)]
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        else:
            name, values = escaped(member.name, names.KEYWORDS), []
            doc = doc_lines(member.facts, value_note(member.unit, member.range))
        parameters = [f"{t} {n}" for t, n, _ in self._parameters(values)]
        execution = ""
        if isinstance(member, Operation) and member.cancelable:
            feedback = self._lowering.type(member.feedback) if member.feedback else ""
            execution = f"gecos::Execution<{feedback}>"
            run = LocalNames(escaped(v.name, names.KEYWORDS) for v in values).fresh("run")
            parameters.append(f"{execution}& {run}")
        returns = f"gecos::Result<{self._result_type(call, member)}>"
        return HandlerView(
            doc,
            returns,
            name,
            ", ".join(parameters),
            self._caller_name(call),
            request_name(self._slots(values, "")),
            _hex32(call.code),
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
        slots = self._slots(values, short_name(call).removesuffix("="))
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
        lines.append(f"if (!{result}) return {request}.fail({result}.error().failure());")
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
            [
                f"return {request}.fail({{gecos::Detail::BadParameter, "
                f"{source}.error().message(), {{}}, {{}}}});"
            ],
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
        values = self._reply(call, member)
        if not values:
            return [f"{request}.finish(0, [](gecos::wire::Encoder&) {{}});"]
        local = LocalNames(taken | {result, request})
        size, to, value_name = local.fresh("size"), local.fresh("to"), local.fresh("value")
        lines = [f"const auto& {value_name} = *{result};"]
        if len(values) > 1:
            return [
                *lines,
                f"{request}.finish({value_name}.encoded_size(),",
                f"            [&](gecos::wire::Encoder& {to}) {{ {value_name}.encode({to}); }});",
            ]
        slot = Slot(
            value_name, short_name(call), values[0].type, values[0].optional, values[0].range
        )
        checks = self._lowering.check(slot, LocalNames(taken | {result, request, value_name}))
        if checks:
            wrong = local.fresh("wrong")
            lines += [f"const std::string {wrong} = [&]() -> std::string {{", *indented(checks)]
            lines += ["  return {};", "}();"]
            lines += block(
                f"if (!{wrong}.empty())",
                [
                    f"return {request}.fail({{gecos::Detail::Fault, "
                    f'"the handler of {call.name} gave " + {wrong}, {{}}, {{}}}});'
                ],
            )
        always, more = self._lowering.size(slot, size, LocalNames(taken | {size, value_name}))
        size_text = str(always)
        if more:
            lines += [f"std::size_t {size} = {always};", *more]
            size_text = size
        writes = self._lowering.encode(slot, to, LocalNames(taken | {to, value_name}))
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

    def _publisher(self, attribute: Attribute, index: int) -> PublisherView:
        value = attribute_value(attribute)
        used = LocalNames(names.method_names(self._model, self._interface))
        name = used.fresh(f"publish_{attribute.name}")
        slot = Slot("value", attribute.name, value.type, value.optional, value.range)
        taken = {"value", "stamp_ns"}
        lines = ["if (gecos_publisher_ == nullptr) return;"]
        checks = self._lowering.check(slot, LocalNames(taken))
        if checks:
            lines += ["const std::string wrong = [&]() -> std::string {", *indented(checks)]
            lines += ["  return {};", "}();"]
            lines += block(
                "if (!wrong.empty())",
                [
                    f'gecos::log_error("{attribute.scoped_name}", "not published: " + wrong);',
                    "return;",
                ],
            )
        layout = self._layout.stream(attribute.scoped_name)
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
            f"gecos_publisher_->publish({self._name}::gecos_description().streams[{index}],"
            " sample, stamp_ns);"
        )
        return PublisherView(
            name, attribute.name, self._lowering.parameter(value.type, value.optional), tuple(lines)
        )


def request_name(slots: list[Slot]) -> str:
    """What a handler's caller calls the incoming call: parameters have their own names."""
    return LocalNames(slot.expression for slot in slots).fresh("call")


def quality(qos: Qos) -> str:
    """Designated initialisers of gecos::qos::Quality; only what was asked for."""
    terms = []
    if qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        word = "SoftRealtime" if qos.quality_class is QualityClass.SOFT_REALTIME else "HardRealtime"
        terms.append(f".line = gecos::qos::Class::{word}")
    if qos.reliability is Reliability.BEST_EFFORT:
        terms.append(".reliability = gecos::qos::Reliability::BestEffort")
    for name in ("deadline", "start_by", "latency", "lifespan"):
        value = getattr(qos, f"{name}_ns")
        if value is not None:
            terms.append(f".{name} = gecos::Duration{{{value}}}")
    if qos.depth is not None:
        terms.append(f".depth = {qos.depth}")
    if qos.media is not None and set(qos.media) <= LARGEST_ON_SHM:
        terms.append(".shm_only_media = true")
    return "{" + ", ".join(terms) + "}"


def _on_new(value: OnNew) -> str:
    return value.value.capitalize()


def _bool(value: bool) -> str:
    return "true" if value else "false"


def _hex32(value: int) -> str:
    return f"0x{value:08x}"


def _hex64(value: int) -> str:
    return f"0x{value & 0xFFFFFFFFFFFFFFFF:016x}"
