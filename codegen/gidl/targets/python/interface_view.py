"""What the template of `<file>.py` prints: client proxies and servants."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gidl.model import Attribute, Facts, File, Interface, Operation, Struct
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
)
from gidl.targets.naming import LocalNames, doc_lines, escaped, value_note
from gidl.targets.python import names
from gidl.targets.python.imports import export_order, import_lines
from gidl.targets.python.lower import Lowering, Slot
from gidl.targets.python.types_view import LOCAL_WORDS
from gidl.wire_layout import CallKind, CallLayout
from gidl.wire_nodes import AppendableNode, StructNode


@dataclass(frozen=True, slots=True)
class FunctionView:
    """A reader or writer of a body, as a function of the module."""

    head: str  # "def _device_mount_arguments(source: Decoder) -> tuple[str, Frame]:"
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MethodTableView:
    """The constant that says how an operation is called."""

    name: str  # "_DEVICE_MOUNT"
    type: str  # "Method[None, None]"
    operation: tuple[str, ...]  # arguments of Operation(...)
    arguments: tuple[str, ...]  # what follows it


@dataclass(frozen=True, slots=True)
class StreamTableView:
    name: str
    arguments: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ProxyMemberView:
    is_stream: bool
    head: str
    doc: tuple[str, ...]
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class HandlerView:
    code: str
    table: str
    method: str
    arguments: str
    result: str
    head: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PublisherView:
    head: str
    doc: str
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class InterfaceView:
    name: str
    constant: str  # "_DEVICE"
    scoped_name: str
    version: str
    hash: str
    doc: tuple[str, ...]
    client_bases: str
    server_bases: str
    base_proxies: tuple[str, ...]  # classes whose operations it inherits
    base_servants: tuple[str, ...]
    bases: tuple[str, ...]
    quality: str
    functions: tuple[FunctionView, ...]
    methods: tuple[MethodTableView, ...]
    streams: tuple[StreamTableView, ...]
    members: tuple[ProxyMemberView, ...]
    handlers: tuple[HandlerView, ...]
    publishers: tuple[PublisherView, ...]


@dataclass(frozen=True, slots=True)
class InterfacesView:
    source: str
    doc: tuple[str, ...]
    has_interfaces: bool
    standard: tuple[str, ...]  # import lines of the standard library
    imports: tuple[str, ...]
    numpy: bool
    exported: tuple[str, ...]
    interfaces: tuple[InterfaceView, ...]


def interfaces_view(lowering: Lowering, file: File, types: tuple[str, ...]) -> InterfacesView:
    builders = [_Builder(lowering, d) for d in file.declarations if isinstance(d, Interface)]
    views = tuple(builder.view() for builder in builders)
    text = "\n".join(_all_text(view) for view in views)
    doc = tuple(line for view in views[:1] for line in view.doc)
    servants = [f"{view.name}Servant" for view in views]
    modules = _imports(lowering, file, builders)
    if types:
        modules[f"{names.module_of(file.path)}_types"] = set(types)
    for module, words in _RUNTIME:
        modules.setdefault(module, set()).update(word for word in words if _uses(text, word))
    standard = {"abc": ["abstractmethod"] if "def " in text else [], "typing": ["ClassVar"]}
    if views:
        standard["collections.abc"] = ["Mapping"]
    if "npt." in text:
        standard["typing"].append("TYPE_CHECKING")
    return InterfacesView(
        file.path,
        doc or (f"Types of {file.path}.",),
        bool(views),
        tuple(import_lines(standard)) if views else (),
        tuple(import_lines(modules)),
        "npt." in text,
        tuple(sorted([*types, *(view.name for view in views), *servants], key=export_order)),
        views,
    )


def _all_text(view: InterfaceView) -> str:
    """Everything that the template prints of it, for finding out which names are used."""
    parts: list[str] = [view.client_bases, view.server_bases, view.quality]
    for function in view.functions:
        parts += [function.head, *function.body]
    for method in view.methods:
        parts += [method.type, "Operation(", *method.operation, *method.arguments]
    for stream in view.streams:
        parts += ["OutwardStream(", *stream.arguments]
    for member in view.members:
        parts += [member.head, *member.body]
    for handler in view.handlers:
        parts += ["Handler(", handler.head, handler.arguments, handler.result]
    for publisher in view.publishers:
        parts += [publisher.head, *publisher.body]
    return "\n".join([*parts, "Interface("])


def _uses(text: str, word: str) -> bool:
    return re.search(rf"\b{word}\b", text) is not None


_RUNTIME = (
    ("gecos", ("wire",)),
    ("gecos.command", ("Command",)),
    ("gecos.execution", ("Execution",)),
    (
        "gecos.interface",
        (
            "Access", "Handler", "Interface", "Kind", "Method", "OnLoss", "OnNew", "Operation",
            "OutwardStream", "Quality", "QualityClass", "no_arguments", "no_result", "nothing",
        ),
    ),
    ("gecos.proxy", ("Object", "StreamAttribute")),
    ("gecos.servant", ("Servant",)),
    ("gecos.wire", ("Decoder", "Parts")),
)  # fmt: skip


def _imports(lowering: Lowering, file: File, builders: list[_Builder]) -> dict[str, set[str]]:
    """Types and base classes that live in other generated modules."""
    model = lowering.model
    modules: dict[str, set[str]] = {}
    for builder in builders:
        for name in builder.used_types:
            home = model.file_of(name) if model.has(name) else file.path
            if home != file.path:
                module = f"{names.module_of(home)}_types"
                modules.setdefault(module, set()).add(names.type_name(model, name))
        for base in builder.interface.bases:
            if model.file_of(base) != file.path:
                module = names.module_of(model.file_of(base))
                simple = names.type_name(model, base)
                modules.setdefault(module, set()).update((simple, f"{simple}Servant"))
    return modules


def _doc_lines(facts: Facts, note: str = "") -> tuple[str, ...]:
    return names.docstring(doc_lines(facts, note))


class _Builder:
    def __init__(self, lowering: Lowering, interface: Interface) -> None:
        self.interface = interface
        self.used_types: set[str] = set()
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self._name = names.type_name(self._model, interface.name)
        self._members = {m.scoped_name: m for m in interface.members}
        self._functions: list[FunctionView] = []

    def view(self) -> InterfaceView:
        interface = self.interface
        refuse_unsupported(interface)
        methods, members, handlers = [], [], []
        for call in self._layout.interfaces[interface.name].calls:
            methods.append(self._table(call))
            members.append(self._proxy_member(call))
            handlers.append(self._handler(call))
        streamed = [a for a in interface.attributes if a.streams_out]
        bases = [names.type_name(self._model, base) for base in interface.bases]
        return InterfaceView(
            self._name,
            names.constant(self._name),
            interface.name,
            interface.facts.version or "",
            f"0x{self._layout.interfaces[interface.name].hash:016X}",
            _doc_lines(interface.facts),
            ", ".join(bases or ["Object"]),
            ", ".join([f"{base}Servant" for base in bases] or ["Servant"]),
            tuple(bases),
            tuple(f"{base}Servant" for base in bases),
            interface.all_bases,
            quality(interface.qos),
            tuple(self._functions),
            tuple(methods),
            tuple(self._stream_table(a) for a in streamed),
            tuple(members),
            tuple(handlers),
            tuple(self._publisher(a) for a in streamed),
        )

    def _member(self, call: CallLayout) -> Operation | Attribute:
        return self._members[call.name.removesuffix("=")]

    # -- names -------------------------------------------------------------------------------------

    def _constant(self, call: CallLayout) -> str:
        short = short_name(call)
        words = ("set", short.removesuffix("=")) if short.endswith("=") else (short,)
        return names.constant(self._name, *words)

    def _function(self, call: CallLayout, what: str) -> str:
        return f"{self._constant(call).lower()}_{what}"

    def _method_name(self, call: CallLayout) -> str:
        member = self._member(call)
        if call.kind is CallKind.SETTER:
            return names.method_names(self._model, self.interface).fresh(f"set_{member.name}")
        return escaped(member.name, names.KEYWORDS)

    def _inputs(self, call: CallLayout) -> list[CallValue]:
        member = self._member(call)
        if isinstance(member, Operation):
            return [parameter_value(p) for p in member.inputs]
        return [attribute_value(member)] if call.kind is CallKind.SETTER else []

    def _outputs(self, call: CallLayout) -> list[CallValue]:
        member = self._member(call)
        if isinstance(member, Operation):
            return reply_values(member, call)
        return [] if call.kind is CallKind.SETTER else [attribute_value(member)]

    def _result_struct(self, call: CallLayout) -> Struct | None:
        member = self._member(call)
        return result_struct(self._layout, member) if isinstance(member, Operation) else None

    def _hint(self, value: CallValue) -> str:
        self.used_types |= self._lowering.imports(value.type)
        return self._lowering.hint(value.type, value.optional)

    def _result_hint(self, call: CallLayout) -> str:
        struct = self._result_struct(call)
        if struct is not None:
            return names.type_name(self._model, struct.name)
        values = self._outputs(call)
        return self._hint(values[0]) if values else "None"

    def _feedback_hint(self, call: CallLayout) -> str:
        member = self._member(call)
        if isinstance(member, Operation) and member.feedback is not None:
            self.used_types |= self._lowering.imports(member.feedback)
            return self._lowering.hint(member.feedback)
        return "None"

    # -- tables ------------------------------------------------------------------------------------

    def _table(self, call: CallLayout) -> MethodTableView:
        member = self._member(call)
        arguments = [self._reader(call)]
        feedback = self._feedback_hint(call)
        raises = [name for name, _ in call.exceptions]
        self.used_types |= set(raises)
        if feedback != "None":
            arguments.append(f"feedback={feedback}.decode")
        if raises:
            listed = "".join(f"{names.type_name(self._model, name)}, " for name in raises)
            arguments.append(f"raises=({listed.rstrip(' ') if len(raises) == 1 else listed[:-2]})")
        result = self._result_hint(call)
        return MethodTableView(
            self._constant(call),
            f"Method[{result}, {feedback}]",
            tuple(self._operation_arguments(call, member)),
            tuple(arguments),
        )

    def _operation_arguments(self, call: CallLayout, member: Operation | Attribute) -> list[str]:
        """Only what differs from the defaults of gecos.interface.Operation, and the access."""
        lines = [f"code=0x{call.code:08X}", f'name="{short_name(call)}"']
        setter = call.kind is CallKind.SETTER
        if isinstance(member, Attribute):
            lines.append(f"kind=Kind.{'SETTER' if setter else 'GETTER'}")
            access = member.write_access if setter else member.read_access
            presence = setter and member.write_needs_presence
            idempotent = member.idempotent or not setter
        else:
            access, presence, idempotent = member.access, member.needs_presence, member.idempotent
        lines.append(f"access=Access.{access.name}")
        flags = {"presence": presence, "idempotent": idempotent, "parallel": member.parallel}
        if isinstance(member, Operation):
            flags |= {"safety": member.safety, "cancelable": member.cancelable}
            flags |= {"ordered": member.ordered}
        lines += [
            f"{name}={value}" for name, value in flags.items() if value != (name == "presence")
        ]
        if member.on_new is not OnNew.QUEUE:
            lines.append(f"on_new=OnNew.{member.on_new.name}")
        if member.on_loss is not OnLoss.STOP:
            lines.append(f"on_loss=OnLoss.{member.on_loss.name}")
        terms = quality(member.qos)
        if terms != "Quality()":
            lines.append(f"quality={terms}")
        return [*lines, f"hash=0x{call.hash:016X}"]

    def _stream_table(self, attribute: Attribute) -> StreamTableView:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        lines = [f"code=0x{layout.code:08X}", f'name="{attribute.name}"']
        lines.append(f"access=Access.{attribute.read_access.name}")
        lines.append(f"rate_hz={float(attribute.stream.rate_hz or 0)!r}")
        lines.append(f"largest={layout.sample.fixed_size or 0}")
        terms = quality(attribute.qos)
        if terms != "Quality()":
            lines.append(f"quality={terms}")
        return StreamTableView(self._stream_constant(attribute), tuple(lines))

    def _stream_constant(self, attribute: Attribute) -> str:
        return names.constant(self._name, attribute.name, "stream")

    # -- bodies ------------------------------------------------------------------------------------

    def _reader(self, call: CallLayout) -> str:
        """Reads the reply body."""
        values = self._outputs(call)
        if not values:
            return "nothing"
        struct = self._result_struct(call)
        if struct is not None:
            return f"{names.type_name(self._model, struct.name)}.decode"
        node = call.reply[0].node
        value = values[0]
        hint = self._hint(value)
        if isinstance(node, StructNode):
            return f"{hint}.decode"
        slot = Slot("", short_name(call), value.type, value.optional, value.range)
        name = self._function(call, "reply")
        expression = self._lowering.decode(slot)
        body: tuple[str, ...] = (f"return {expression}",)
        if not isinstance(node, AppendableNode):
            body = (f"value: {hint} = {expression}", "return value")
        self._functions.append(FunctionView(f"def {name}(source: Decoder) -> {hint}:", body))
        return name

    def _arguments(self, call: CallLayout) -> str:
        """Reads the request body."""
        values = self._inputs(call)
        if not values:
            return "no_arguments"
        name = self._function(call, "arguments")
        label = short_name(call).removesuffix("=")
        required = first_missing(values)
        local = LocalNames(LOCAL_WORDS | {names.type_name(self._model, n) for n in self.used_types})
        lines, variables, hints = [], [], []
        for i, value in enumerate(values):
            slot = Slot("", f"{label}.{value.name}", value.type, value.optional, value.range)
            variable, hint = local.fresh(escaped(value.name, names.KEYWORDS)), self._hint(value)
            expression = self._lowering.decode(slot)
            variables.append(variable)
            hints.append(hint)
            if i < required:
                lines.append(f"{variable}: {hint} = {expression}")
            else:
                lines.append(f"{variable}: {hint} = {self._missing(value)}")
                lines += ["if source.offset < source.end:", f"    {variable} = {expression}"]
        comma = "," if len(variables) == 1 else ""
        lines.append(
            f"return ({', '.join(variables)}{comma})" if comma else f"return {', '.join(variables)}"
        )
        head = f"def {name}(source: Decoder) -> tuple[{', '.join(hints)}]:"
        self._functions.append(FunctionView(head, tuple(lines)))
        return name

    def _missing(self, value: CallValue) -> str:
        if value.optional or value.default is None:
            return "None"
        return self._lowering.literal(value.default, value.type)

    def _writer(self, call: CallLayout) -> str:
        """Writes the reply body."""
        values = self._outputs(call)
        if not values:
            return "no_result"
        name = self._function(call, "result")
        hint = self._result_hint(call)
        if self._result_struct(call) is not None:
            writes = ["value.encode(out)"]
        else:
            v = values[0]
            slot = Slot("value", short_name(call), v.type, v.optional, v.range)
            writes = self._lowering.encode(slot, LocalNames(LOCAL_WORDS | {"value"}))
        body = ("out: Parts = []", *writes, "return out")
        self._functions.append(FunctionView(f"def {name}(value: {hint}) -> Parts:", body))
        return name

    # -- client ------------------------------------------------------------------------------------

    def _doc(self, call: CallLayout) -> tuple[str, ...]:
        member = self._member(call)
        if isinstance(member, Attribute):
            doc = _doc_lines(member.facts, value_note(member.unit, member.range))
            if call.kind is CallKind.SETTER and not doc:
                return (f"Sets {member.name}.",)
            return doc
        lines = list(_doc_lines(member.facts, value_note(member.result_unit, member.result_range)))
        notes = []
        for p in member.parameters:
            note = value_note(p.unit, p.range)
            if note or p.facts.doc:
                notes.append(
                    f"{escaped(p.name, names.KEYWORDS)}: " + " ".join(_doc_lines(p.facts, note))
                )
        if call.exceptions:
            listed = ", ".join(names.type_name(self._model, name) for name, _ in call.exceptions)
            notes.append(f"May raise {listed}.")
        return (*lines, *([""] if lines and notes else []), *notes)

    def _parameters(self, call: CallLayout, defaults: bool) -> list[str]:
        values = self._inputs(call)
        missing = first_missing(values)
        texts = []
        for i, value in enumerate(values):
            default = f" = {self._missing(value)}" if defaults and i >= missing else ""
            texts.append(f"{escaped(value.name, names.KEYWORDS)}: {self._hint(value)}{default}")
        return texts

    def _proxy_member(self, call: CallLayout) -> ProxyMemberView:
        member = self._member(call)
        result, feedback = self._result_hint(call), self._feedback_hint(call)
        name = self._method_name(call)
        if isinstance(member, Attribute) and member.streams_out and call.kind is CallKind.GETTER:
            rate = member.stream.rate_hz if member.stream else None
            doc = self._doc(call)
            if rate:
                doc = (*doc, *([""] if doc else []), f"Published {rate:g} times a second.")
            stream = self._stream_constant(member)
            return ProxyMemberView(
                True,
                f"def {name}(self) -> StreamAttribute[{result}]:",
                doc,
                (f"return StreamAttribute(self, {self._constant(call)}, {stream})",),
            )
        command = f"Command[{result}]" if feedback == "None" else f"Command[{result}, {feedback}]"
        parameters = ", ".join(["self", *self._parameters(call, defaults=True)])
        values = self._inputs(call)
        taken = LocalNames(
            LOCAL_WORDS - {"out"} | {escaped(v.name, names.KEYWORDS) for v in values}
        )
        lines = []
        label = short_name(call).removesuffix("=")
        out = "[]"
        if values:
            out = "out"
            lines.append("out: Parts = []")
            for v in values:
                x = escaped(v.name, names.KEYWORDS)
                slot = Slot(x, f"{label}.{v.name}", v.type, v.optional, v.range)
                lines += self._lowering.encode(slot, taken)
        lines.append(f"return self._gecos_call({self._constant(call)}, {out})")
        return ProxyMemberView(
            False, f"def {name}({parameters}) -> {command}:", self._doc(call), tuple(lines)
        )

    # -- server ------------------------------------------------------------------------------------

    def _handler(self, call: CallLayout) -> HandlerView:
        member = self._member(call)
        parameters = ["self", *self._parameters(call, defaults=False)]
        if isinstance(member, Operation) and member.cancelable:
            run = LocalNames(p.partition(":")[0] for p in parameters).fresh("run")
            parameters.append(f"{run}: Execution[{self._feedback_hint(call)}]")
        name = self._method_name(call)
        return HandlerView(
            f"0x{call.code:08X}",
            self._constant(call),
            name,
            self._arguments(call),
            self._writer(call),
            f"def {name}({', '.join(parameters)}) -> {self._result_hint(call)}:",
            self._doc(call) or (f"Answers {short_name(call)}.",),
        )

    def _publisher(self, attribute: Attribute) -> PublisherView:
        value = attribute_value(attribute)
        name = names.method_names(self._model, self.interface).fresh(f"publish_{attribute.name}")
        slot = Slot("value", attribute.name, value.type, value.optional, value.range)
        code = self._layout.stream(attribute.scoped_name).code
        body = [
            "out: Parts = []",
            *self._lowering.encode(slot, LocalNames(LOCAL_WORDS | {"value", "stamp"})),
            f"self._gecos_publish(0x{code:08X}, out, stamp)",
        ]
        return PublisherView(
            f"def {name}(self, value: {self._hint(value)}, stamp: float | None = None) -> None:",
            f"A new sample of `{attribute.name}`, measured at `stamp` (Unix time in s; now).",
            tuple(body),
        )


def quality(qos: Qos) -> str:
    terms = []
    if qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        assert qos.quality_class is not None
        terms.append(f"line=QualityClass.{qos.quality_class.name}")
    if qos.reliability is Reliability.BEST_EFFORT:
        terms.append("best_effort=True")
    for name in ("deadline_ns", "start_by_ns", "latency_ns", "lifespan_ns", "depth"):
        value = getattr(qos, name)
        if value is not None:
            terms.append(f"{name}={value}")
    if qos.media is not None and set(qos.media) <= {"shm", "can"}:
        terms.append("shm_only_media=True")
    return f"Quality({', '.join(terms)})"
