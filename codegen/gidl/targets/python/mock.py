"""What the template of a mock server in Python prints."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from gidl.file_names import python_module
from gidl.model import (
    ArrayType,
    Attribute,
    Bitset,
    EnumDeclaration,
    Interface,
    MapType,
    NamedType,
    Operation,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Struct,
    Type,
    Union,
    Value,
)
from gidl.policy import Access
from gidl.targets import samples
from gidl.targets.calls import reply_values
from gidl.targets.naming import snake_case
from gidl.targets.python import names
from gidl.targets.python.calls.members import Members
from gidl.targets.python.imports import import_lines
from gidl.targets.python.lower import Lowering
from gidl.targets.python.lower.types import DTYPES, is_octet
from gidl.wire_layout import CallKind, CallLayout, node_of


@dataclass(frozen=True, slots=True)
class HeldView:
    """An attribute: what was set is what is got."""

    name: str
    hint: str
    value: str


@dataclass(frozen=True, slots=True)
class MethodView:
    head: str
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StreamView:
    publisher: str
    held: str
    period_ns: str
    rate: str


@dataclass(frozen=True, slots=True)
class MockView:
    name: str  # "MockRx90"
    base: str  # "Rx90Servant"
    scoped_name: str
    object: str  # what it is served as
    variable: str
    held: tuple[HeldView, ...]
    methods: tuple[MethodView, ...]
    streams: tuple[StreamView, ...]


@dataclass(frozen=True, slots=True)
class MocksView:
    source: str
    standard: tuple[str, ...]
    imports: tuple[str, ...]
    mocks: tuple[MockView, ...]
    publishes: bool


def mocks_view(lowering: Lowering, path: str, interfaces: Sequence[Interface]) -> MocksView:
    builders = [_Mock(lowering, interface) for interface in interfaces]
    mocks = tuple(builder.view() for builder in builders)
    modules: dict[str, set[str]] = {}
    for builder in builders:
        for name in builder.used:
            module = names.types_module(lowering.model, name)
            modules.setdefault(module, set()).add(names.value_name(lowering.model, name))
        home = python_module(lowering.model.file_of(builder.interface.name))
        modules.setdefault(home, set()).add(f"{builder.name}Servant")
        for module, words in builder.results.items():
            modules.setdefault(module, set()).update(words)
    text = "\n".join(
        [*(m.head for v in mocks for m in v.methods), *(h.hint for v in mocks for h in v.held)]
        + [line for v in mocks for m in v.methods for line in m.body]
        + [h.value for v in mocks for h in v.held]
    )
    imports = ["import gecos", *import_lines(modules)]
    for used, line in (("np.", "import numpy as np"), ("npt.", "import numpy.typing as npt")):
        if re.search(rf"\b{re.escape(used)}", text):
            imports.insert(1 if used == "np." else 2, line)
    publishes = any(v.streams for v in mocks)
    standard: list[str] = []
    if publishes:
        standard += [f"import {module}" for module in ("contextlib", "threading", "time")]
        standard += import_lines({"collections.abc": ["Callable"], "typing": ["NamedTuple"]})
    return MocksView(path, tuple(standard), tuple(imports), mocks, publishes)


class _Mock:
    def __init__(self, lowering: Lowering, interface: Interface) -> None:
        self.interface = interface
        self.used: set[str] = set()
        self.results: dict[str, set[str]] = {}
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self.name = names.type_name(self._model, interface.name)

    def view(self) -> MockView:
        held, methods, streams = [], [], []
        for interface in self._model.lineage(self.interface):
            facts = Members(self._lowering, interface, names.Constants())
            for call in self._layout.interfaces[interface.name].calls:
                member = facts._member(call)
                head = facts._handler(call).head
                methods.append(MethodView(_plain(head), tuple(self._body(facts, call, member))))
                if isinstance(member, Attribute) and call.kind is CallKind.GETTER:
                    hint = self._hint(member.type, member.optional)
                    value = self._value(member.type, member.optional, member.range, None)
                    held.append(HeldView(_held(member), hint, value))
                    if member.streams_out and member.stream is not None:
                        rate = member.stream.rate_hz
                        streams.append(
                            StreamView(
                                facts._publisher(member).head.split("(")[0].removeprefix("def "),
                                _held(member),
                                str(samples.nanoseconds(rate)),
                                f"{rate:g} a second" if rate else "no rate is declared: 1 a second",
                            )
                        )
            self.used |= facts.used_types & {d.name for d in self._model.declarations()}
            self.used |= facts.used_types & {names.OBJECT_REF}
        return MockView(
            f"Mock{self.name}", f"{self.name}Servant", self.interface.name,
            snake_case(self.interface.simple_name).upper(),
            f"mock_{snake_case(self.interface.simple_name)}",
            tuple(held), tuple(methods), tuple(streams),
        )  # fmt: skip

    def _body(self, facts: Members, call: CallLayout, member: Operation | Attribute) -> list[str]:
        if isinstance(member, Attribute):
            if call.kind is CallKind.GETTER:
                return [f"return self.{_held(member)}"]
            return [self._log(member.name, [("value", "value", member.secret)], setter=True),
                    f"self.{_held(member)} = value"]  # fmt: skip
        inputs = facts._inputs(call)
        called = dict(zip((v.name for v in inputs), facts._parameter_names(call), strict=True))
        lines = []
        if member.access is not Access.SENSOR or member.safety:
            told = [(p.name, called[p.name], p.secret) for p in member.inputs]
            lines.append(self._log(member.name, told))
        if member.cancelable:
            run = facts._handler(call).head.rpartition(": _Execution[")[0].rpartition(" ")[2]
            feedback = ""
            if member.feedback is not None:
                feedback = f", {self._value(member.feedback, False, None, None)}"
            lines.append(f"{run}.progress(1.0{feedback})")
        answers = []
        for v in reply_values(member, call):
            given = called.get(v.name)
            answers.append((v, given or self._value(v.type, v.optional, v.range, None)))
        struct = facts._result_struct(call)
        if struct is not None:
            kind = names.type_name(self._model, struct.name)
            home = python_module(self._model.file_of(member.interface)) + "_types"
            self.results.setdefault(home, set()).add(kind)
            words = self._lowering.words(struct)
            items = [f"    {names.member_name(v.name, words)}={text}," for v, text in answers]
            lines += [f"return {kind}(", *items, ")"]
        elif answers:
            lines.append(f"return {answers[0][1]}")
        return lines or ["pass"]

    def _log(self, name: str, told: list[tuple[str, str, bool]], setter: bool = False) -> str:
        shown = ", ".join(
            f"{word}=***" if secret else f"{word}={{{variable}!r}}"
            for word, variable, secret in told
        )
        what = f"{name} = {shown.removeprefix('value=')}" if setter else f"{name}({shown})"
        return f'print(f"{{self._mock_name}}: {what}", flush=True)'

    def _hint(self, used: Type, optional: bool) -> str:
        self.used |= self._lowering.imports(used)
        return _plain(self._lowering.hint(used, optional))

    def _value(
        self, used: Type, optional: bool, limits: Range | None, default: Value | None
    ) -> str:
        if optional:
            return "None"
        if default is not None:
            return self._lowering.literal(default, used)
        target = self._model.target(used)
        match target:
            case PrimitiveType(Primitive.BOOLEAN):
                return "False"
            case PrimitiveType(Primitive.CHAR):
                return '"\\0"'
            case PrimitiveType(kind):
                return repr(samples.number(kind, samples.limits_of(self._model, used, limits)))
            case StringType():
                return '""'
            case MapType():
                return "{}"
            case SequenceType(element):
                node = node_of(self._model, element)
                if is_octet(node):
                    return 'b""'
                code = self._lowering.bulk_code(node)
                return f"np.empty(0, np.{DTYPES[code]})" if code else "[]"
            case ArrayType(element, dimensions):
                return self._array(element, dimensions)
            case NamedType(name):
                return self._named(name)

    def _array(self, element: Type, dimensions: tuple[int, ...]) -> str:
        node = node_of(self._model, element)
        if is_octet(node) and len(dimensions) == 1:
            return f"bytes({dimensions[0]})"
        text = self._value(element, False, None, None)
        code = self._lowering.bulk_code(node)
        if code:
            shape = ", ".join(str(size) for size in dimensions)
            shape = f"({shape})" if len(dimensions) > 1 else shape
            return f"np.full({shape}, {text}, np.{DTYPES[code]})"
        for size in reversed(dimensions):
            text = f"[{text} for _ in range({size})]"
        return text

    def _named(self, name: str) -> str:
        declaration = self._model.find(name)
        mine = names.value_name(self._model, name)
        self.used.add(names.OBJECT_REF if isinstance(declaration, Interface) else name)
        match declaration:
            case EnumDeclaration():
                return f"{mine}.{names.enumerator(declaration.initial.name)}"
            case Struct(maps_to=None):
                words = self._lowering.words(declaration)
                given = [
                    f"{names.member_name(m.name, words)}="
                    + self._value(m.type, False, m.range, m.default)
                    for m in self._model.all_members(declaration)
                    if not m.optional
                    and m.default is None
                    and not samples.is_made_by_default(self._model, m.type, m.range, False)
                ]
                return f"{mine}({', '.join(given)})"
            case Union():
                case = samples.arm_of(declaration)
                arm = self._value(case.member.type, False, case.member.range, None)
                if case.labels:
                    self.used |= self._lowering.imports(declaration.discriminator)
                    tag = self._lowering.literal(case.labels[0], declaration.discriminator)
                else:
                    tag = self._value(declaration.discriminator, False, None, None)
                return f"{mine}({tag}, {arm})"
            case Bitset() | Interface() | Struct():
                return f"{mine}()"
            case _:
                return f"{mine}(0)"


def _plain(text: str) -> str:
    """As people write it: a mock is theirs."""
    text = text.replace("_Execution[", "gecos.Execution[")
    return re.sub(r"\b_(npt?)\.", r"\1.", text)


def _held(attribute: Attribute) -> str:
    return f"_held_{attribute.name}"
