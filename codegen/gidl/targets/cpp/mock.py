"""What the template of a mock server in C++ prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gidl.file_names import source_stem
from gidl.languages import CPP_WORDS
from gidl.model import (
    ArrayType,
    Attribute,
    EnumDeclaration,
    Interface,
    Model,
    NamedType,
    Operation,
    PrimitiveType,
    Range,
    Struct,
    Type,
    Union,
)
from gidl.policy import Access
from gidl.targets import samples
from gidl.targets.calls import CallValue, attribute_value, parameter_value, reply_values
from gidl.targets.cpp import names
from gidl.targets.cpp.calls.server import ServerSide
from gidl.targets.cpp.lower import Lowering
from gidl.targets.cpp.lower.statements import indented
from gidl.targets.naming import LocalNames, snake_case
from gidl.type_names import escaped
from gidl.wire_layout import CallKind, CallLayout, node_of


@dataclass(frozen=True, slots=True)
class HeldView:
    """An attribute: what was set is what is got."""

    name: str
    type: str
    value: tuple[str, ...]  # lines of its first value


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
    base: str  # "robcl::Rx90Servant"
    scoped_name: str
    object: str  # what it is served as
    variable: str
    held: tuple[HeldView, ...]
    methods: tuple[MethodView, ...]
    streams: tuple[StreamView, ...]


@dataclass(frozen=True, slots=True)
class MocksView:
    source: str
    header: str
    mocks: tuple[MockView, ...]
    publishes: bool
    logs: bool


def mocks_view(lowering: Lowering, path: str, interfaces: Sequence[Interface]) -> MocksView:
    mocks = tuple(_mock(lowering, interface) for interface in interfaces)
    lines = (line for v in mocks for method in v.methods for line in method.body)
    return MocksView(
        path,
        f"{source_stem(path)}_server.hpp",
        mocks,
        any(v.streams for v in mocks),
        any(line.startswith("mock_says(") for line in lines),
    )


def _mock(lowering: Lowering, interface: Interface) -> MockView:
    model = lowering.model
    held, methods, streams = [], [], []
    for base in model.lineage(interface):
        facts = _Facts(lowering, base)
        for call in lowering.layout.interfaces[base.name].calls:
            member = facts._member(call)
            methods.append(facts.method(call, member))
            if not (isinstance(member, Attribute) and call.kind is CallKind.GETTER):
                continue
            value = attribute_value(member)
            held.append(
                HeldView(
                    _held(member), lowering.type(value.type, value.optional),
                    tuple(sample(lowering, value)),
                )
            )  # fmt: skip
            if member.streams_out and member.stream is not None:
                rate = member.stream.rate_hz
                streams.append(
                    StreamView(
                        facts._publisher(member, 0).name,
                        _held(member),
                        str(samples.nanoseconds(rate)),
                        f"{rate:g} a second" if rate else "no rate is declared: 1 a second",
                    )
                )
    table = lowering.layout.cpp_names
    simple = table.types[interface.name].name
    return MockView(
        f"Mock{simple}", names.absolute(table.servants[interface.name]), interface.name,
        snake_case(simple).upper(), f"mock_{snake_case(simple)}",
        tuple(held), tuple(methods), tuple(streams),
    )  # fmt: skip


class _Facts(ServerSide):
    def method(self, call: CallLayout, member: Operation | Attribute) -> MethodView:
        handler = self._handler(call)
        if isinstance(member, Attribute):
            if call.kind is CallKind.GETTER:
                head = f"{handler.returns} {handler.name}() override"
                return MethodView(head, (f"return mock_got({_held(member)});",))
            head = f"{handler.returns} {handler.name}({handler.parameters}) override"
            told = "mock_secret" if member.secret else "value"
            body = (f'mock_says(mock_name_, "{member.name} =", {told});',
                    f"mock_set({_held(member)}, value);", "return {};")  # fmt: skip
            return MethodView(head, body)
        return self._operation(call, member)

    def _operation(self, call: CallLayout, member: Operation) -> MethodView:
        values = [parameter_value(p) for p in member.inputs]
        taken = {escaped(v.name, CPP_WORDS) for v in values}
        answers = reply_values(member, call)
        used = {v.name for v in answers} & {p.name for p in member.inputs}
        lines, told = [], []
        if member.access is not Access.SENSOR or member.safety:
            used |= {p.name for p in member.inputs if not p.secret}
            for p in member.inputs:
                shown = "mock_secret" if p.secret else escaped(p.name, CPP_WORDS)
                told += [f'"{p.name} ="', shown]
            words = ", ".join(["mock_name_", f'"{member.name}"', *told])
            lines.append(f"mock_says({words});")
        parameters = []
        for (kind, name, _), p in zip(self._parameters(values), member.inputs, strict=True):
            parameters.append(f"{kind} {name}" if p.name in used else f"{kind} /*{name}*/")
        local = LocalNames(taken)
        if member.cancelable:
            run = local.fresh("run")
            feedback = self._lowering.type(member.feedback) if member.feedback else ""
            parameters.append(f"gecos::Execution<{feedback}>& {run}")
            lines.append(f"{run}.progress(1.0{self._feedback(member)});")
        returns = f"gecos::Result<{self._result_type(call, member)}>"
        lines += self._answer_with(call, member, answers, taken)
        head = f"{returns} {escaped(member.name, CPP_WORDS)}({', '.join(parameters)}) override"
        return MethodView(head, tuple(lines))

    def _feedback(self, member: Operation) -> str:
        if member.feedback is None:
            return ""
        return f", {in_place(self._lowering, CallValue('feedback', member.feedback))}"

    def _answer_with(
        self, call: CallLayout, member: Operation, answers: list[CallValue], taken: set[str]
    ) -> list[str]:
        given = {p.name for p in member.inputs}
        if not answers:
            return ["return {};"]
        if len(answers) == 1:
            (only,) = answers
            name = escaped(only.name, CPP_WORDS)
            text = name if only.name in given else in_place(self._lowering, only)
            return [f"return {text};"]
        result = LocalNames(taken).fresh("mock_answer")
        lines = [f"{self._result_type(call, member)} {result};"]
        for v in answers:
            place = f"{result}.{names.member_name(v.name)}"
            if v.name in given:
                lines.append(f"{place} = {escaped(v.name, CPP_WORDS)};")
            elif not v.optional:
                lines += assigned(self._lowering, place, v.type, v.range, alone=False)
        return [*lines, f"return {result};"]


def sample(lowering: Lowering, value: CallValue) -> list[str]:
    """An initial value, as the lines behind a member's name."""
    if value.optional:
        return ["{}"]
    lines = assigned(lowering, "mock_value", value.type, value.range, alone=True)
    kind = lowering.type(value.type)
    if not lines:
        return ["{}"]
    if len(lines) == 1 and lines[0].startswith("mock_value = "):
        return [f"{{{lines[0].removeprefix('mock_value = ').removesuffix(';')}}}"]
    body = [f"{kind} mock_value{{}};", *lines, "return mock_value;"]
    return [" = [] {", *indented(body), "}()"]


def in_place(lowering: Lowering, value: CallValue) -> str:
    """The same as an expression."""
    kind = lowering.type(value.type, value.optional)
    first, *rest = sample(lowering, value)
    if not rest:
        return f"{kind}{first}"
    return "\n".join([first.removeprefix(" = "), *rest])


def assigned(
    lowering: Lowering, x: str, used: Type, limits: Range | None, alone: bool
) -> list[str]:
    """Statements that make of a value as C++ initialises it the one to answer with."""
    model: Model = lowering.model
    if samples.is_made_by_default(model, node_of(model, used, False, limits), alone):
        return []
    target = model.target(used)
    match target:
        case PrimitiveType(kind):
            number = samples.number(kind, samples.limits_of(model, used, limits))
            return [f"{x} = {lowering.literal(number, used)};"]
        case ArrayType(element, dimensions):
            item = LocalNames({x.partition(".")[0]}).fresh(f"each_{x.count('each')}")
            inner = assigned(lowering, item, element, None, alone)
            for size in dimensions[1:]:
                row = f"{item}_row{size}"
                inner = [f"for (auto& {item} : {row}) {{", *indented(inner), "}"]
                item = row
            return [f"for (auto& {item} : {x}) {{", *indented(inner), "}"]
        case NamedType(name):
            return _named(lowering, x, name)
        case _:
            raise AssertionError(target)


def _named(lowering: Lowering, x: str, name: str) -> list[str]:
    model = lowering.model
    declaration = model.find(name)
    match declaration:
        case EnumDeclaration():
            word = escaped(declaration.initial.name, CPP_WORDS)
            return [f"{x} = {lowering.named(name)}::{word};"]
        case Struct():
            lines = []
            for m in model.all_members(declaration):
                if not m.optional and m.default is None:
                    place = f"{x}.{names.member_name(m.name)}"
                    lines += assigned(lowering, place, m.type, m.range, alone=False)
            return lines
        case Union():
            case_ = samples.arm_of(declaration)
            index = declaration.cases.index(case_) + 1
            lines = []
            if case_.labels:
                tag = lowering.literal(case_.labels[0], declaration.discriminator)
                lines.append(f"{x}.tag = {tag};")
            lines.append(f"{x}.value.emplace<{index}>();")
            held = f"std::get<{index}>({x}.value)"
            return lines + assigned(lowering, held, case_.member.type, case_.member.range, True)
        case _:
            raise AssertionError(name)


def _held(attribute: Attribute) -> str:
    return f"held_{attribute.name}_"
