"""Builds the view of a mock server in C++."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from gidl.files.names import source_stem
from gidl.model import (
    ArrayType,
    Attribute,
    EnumDeclaration,
    Interface,
    Model,
    NamedType,
    Operation,
    Range,
    Struct,
    Type,
    Union,
)
from gidl.model.policy import Access
from gidl.names.languages import CPP_TYPES, CPP_WORDS
from gidl.names.type_names import TypeName, escaped
from gidl.targets import samples
from gidl.targets.calls import CallValue, attribute_value, parameter_value, reply_values
from gidl.targets.cpp import names
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.servant_handlers import ServerSide
from gidl.targets.cpp.statements import indented, quoted
from gidl.targets.groups import group
from gidl.targets.naming import LocalNames, snake_case
from gidl.wire.wire_layout import CallKind, CallLayout, node_of
from gidl.wire.wire_nodes import ScalarNode


@dataclass(frozen=True, slots=True)
class HeldView:
    """An attribute of a mock. The mock's getter returns the value that was last set."""

    name: str
    type: str
    value: tuple[str, ...]  # lines of the initialiser


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
    name: str  # name of the class: "MockRx90"
    base: str  # base class: "robcl::Rx90Servant"
    scoped_name: str
    object: str  # name of the object that the mock serves
    variable: str
    own: OwnNames
    held: tuple[HeldView, ...]
    methods: tuple[MethodView, ...]
    streams: tuple[StreamView, ...]


@dataclass(frozen=True, slots=True)
class MocksView:
    source: str
    header: str
    space: str  # the namespace of the mocks
    mocks: tuple[MockView, ...]
    publishes: bool


@dataclass(frozen=True, slots=True)
class OwnNames:
    """Names that the class of a mock needs for itself. They differ from the names of the mock's
    methods and of the parameters of these methods."""

    mock: str
    streams: str
    held: Mapping[str, str]  # names of member variables, by attribute


def mocks_view(lowering: Lowering, path: str, interfaces: Sequence[Interface]) -> MocksView:
    table = lowering.layout.cpp_names
    top = {t.scope[0] if t.scope else t.name for t in (*table.types.values(), OWN_TYPE)}
    classes = LocalNames(
        {"Beat", "Mock", "Publishing"}.union(*(_words(lowering, i) for i in interfaces))
    )
    variables = LocalNames({"beats", "lab", "publishing", "serve", "server"})
    objects = LocalNames()
    mocks = []
    for interface in interfaces:
        simple = table.types[interface.name].name
        snake = snake_case(simple)
        mocks.append(
            _mock(
                lowering, interface, classes.fresh(f"Mock{simple}"),
                objects.fresh(snake.upper()), variables.fresh(f"mock_{snake}"),
            )
        )  # fmt: skip
    return MocksView(
        path,
        f"{source_stem(path)}_server.hpp",
        LocalNames(top).fresh("mocks"),
        tuple(mocks),
        any(v.streams for v in mocks),
    )


OWN_TYPE = TypeName(("gecos",), "")
"""Reserves the name `gecos`, the namespace of the runtime types that every mock uses. The namespace
of the mocks gets another name."""


def _words(lowering: Lowering, interface: Interface) -> set[str]:
    """Names of the methods and parameters of an interface."""
    found = CPP_TYPES.members(lowering.model, interface)
    called = partial(names.parameter_name, lowering.layout, interface)
    for base in lowering.model.with_bases(interface):
        found |= {called(p.name) for o in base.operations for p in o.parameters}
    return found


def _mock(
    lowering: Lowering, interface: Interface, name: str, served: str, variable: str
) -> MockView:
    model = lowering.model
    free = LocalNames(_words(lowering, interface))
    attributes = [m for m in model.all_interface_members(interface) if isinstance(m, Attribute)]
    own = OwnNames(
        free.fresh("mock_"),
        free.fresh("mock_streams"),
        {a.name: free.fresh(f"held_{a.name}_") for a in attributes},
    )
    held, methods, streams = [], [], []
    for base in model.with_bases(interface):
        facts = _Facts(lowering, base, own, interface)
        for call in lowering.layout.interfaces[base.name].calls:
            member = facts._member(call)
            methods.append(facts.method(call, member))
            if not (isinstance(member, Attribute) and call.kind is CallKind.GETTER):
                continue
            value = attribute_value(member)
            held.append(
                HeldView(
                    own.held[member.name], lowering.type(value.type, value.optional),
                    tuple(sample(lowering, value)),
                )
            )  # fmt: skip
            if member.streams_out and member.stream is not None:
                rate = member.stream.rate_hz
                streams.append(
                    StreamView(
                        facts._publisher(member).name,
                        own.held[member.name],
                        str(samples.nanoseconds(rate)),
                        f"{rate:g} a second" if rate else "no rate is declared: 1 a second",
                    )
                )
    servant = names.absolute(lowering.layout.cpp_names.servants[interface.name])
    return MockView(
        name, servant, interface.name, served, variable, own,
        tuple(held), tuple(methods), tuple(streams),
    )  # fmt: skip


class _Facts(ServerSide):
    """Builds the methods of `interface` in the mock of `mocked`. `mocked` is `interface` itself, or
    an interface that derives from it."""

    def __init__(
        self, lowering: Lowering, interface: Interface, own: OwnNames, mocked: Interface
    ) -> None:
        super().__init__(lowering, interface)
        self._own = own
        self._mocked = mocked

    def _parameter(self, name: str) -> str:
        return names.parameter_name(self._layout, self._mocked, name)

    def method(self, call: CallLayout, member: Operation | Attribute) -> MethodView:
        handler = self._handler(call)
        if isinstance(member, Attribute):
            held = self._own.held[member.name]
            if call.kind is CallKind.GETTER:
                head = f"{handler.returns} {handler.name}() override"
                return MethodView(head, (f"return {self._own.mock}.got({held});",))
            head = f"{handler.returns} {handler.name}{handler.parameters} override"
            value = self._parameter("value")
            told = _HIDDEN if member.secret else value
            body = (f'{self._own.mock}.says("{member.name} =", {told});',
                    f"{self._own.mock}.set({held}, {value});", "return {};")  # fmt: skip
            return MethodView(head, body)
        return self._operation(call, member)

    def _operation(self, call: CallLayout, member: Operation) -> MethodView:
        values = [parameter_value(p) for p in member.inputs]
        taken = {self._parameter(v.name) for v in values}
        answers = reply_values(member, call)
        used = {v.name for v in answers} & {p.name for p in member.inputs}
        lines, told = [], []
        if member.access is not Access.SENSOR or member.safety:
            used |= {p.name for p in member.inputs if not p.secret}
            for p in member.inputs:
                shown = _HIDDEN if p.secret else self._parameter(p.name)
                told += [f'"{p.name} ="', shown]
            lines.append(f"{self._own.mock}.says{group([quoted(member.name), *told])};")
        parameters = []
        for (kind, name, _), p in zip(self._parameters(values), member.inputs, strict=True):
            parameters.append(f"{kind} {name}" if p.name in used else f"{kind} /*{name}*/")
        local = names.Locals(taken)
        if member.cancelable:
            run = local.fresh("run")
            feedback = self._lowering.type(member.feedback) if member.feedback else ""
            parameters.append(f"gecos::Execution<{feedback}>& {run}")
            lines.append(f"{run}.progress(1.0{self._feedback(member, taken)});")
        returns = f"gecos::Result<{self._result_type(call, member)}>"
        lines += self._answer_with(call, member, answers, taken)
        head = f"{returns} {names.method_name(member.name)}{group(parameters)} override"
        return MethodView(head, tuple(lines))

    def _feedback(self, member: Operation, taken: set[str]) -> str:
        if member.feedback is None:
            return ""
        return f", {in_place(self._lowering, CallValue('feedback', member.feedback), taken)}"

    def _answer_with(
        self, call: CallLayout, member: Operation, answers: list[CallValue], taken: set[str]
    ) -> list[str]:
        given = {p.name for p in member.inputs}
        if not answers:
            return ["return {};"]
        if len(answers) == 1:
            (only,) = answers
            name = self._parameter(only.name)
            text = name if only.name in given else in_place(self._lowering, only, taken)
            return [f"return {text};"]
        result = _free("mock_answer", taken)
        lines = [f"{self._result_type(call, member)} {result};"]
        for v in answers:
            place = f"{result}.{names.member_name(v.name)}"
            if v.name in given:
                lines.append(f"{place} = {self._parameter(v.name)};")
            elif not v.optional:
                lines += assigned(self._lowering, place, v.type, v.range, alone=False)
        return [*lines, f"return {result};"]


def _free(wanted: str, taken: Collection[str]) -> str:
    """Returns a name for a local variable. No name in `taken` begins with this name, because nested
    loops make their variables from this name and a suffix."""
    while any(name.startswith(wanted) for name in taken):
        wanted += "_"
    return wanted


def sample(lowering: Lowering, value: CallValue, taken: Collection[str] = ()) -> list[str]:
    """Returns the initialiser of a member variable: the lines that follow the name of the
    variable."""
    if value.optional:
        return ["{}"]
    local = _free("mock_value", taken)
    lines = assigned(lowering, local, value.type, value.range, alone=True)
    kind = lowering.type(value.type)
    if not lines:
        return ["{}"]
    if len(lines) == 1 and lines[0].startswith(f"{local} = "):
        return [f"{{{lines[0].removeprefix(f'{local} = ').removesuffix(';')}}}"]
    body = [f"{kind} {local}{{}};", *lines, f"return {local};"]
    return [" = [] {", *indented(body), "}()"]


def in_place(lowering: Lowering, value: CallValue, taken: Collection[str]) -> str:
    """Returns an expression for the value that a mock returns for the parameter or result
    `value`."""
    kind = lowering.type(value.type, value.optional)
    first, *rest = sample(lowering, value, taken)
    if not rest:
        return f"{kind}{first}"
    return "\n".join([first.removeprefix(" = "), *rest])


def assigned(
    lowering: Lowering, x: str, used: Type, limits: Range | None, alone: bool
) -> list[str]:
    """Returns statements that change the variable `x` from its C++ default value to the value that
    the mock returns."""
    model: Model = lowering.model
    node = node_of(model, used, False, limits)
    if samples.is_made_by_default(model, node, alone):
        return []
    if isinstance(node, ScalarNode):
        number = samples.number(node.primitive, node.limits)
        return [f"{x} = {lowering.literal(number, used)};"]
    target = model.target(used)
    match target:
        case ArrayType(element, dimensions):
            item = f"{_variable(x)}_each"
            inner = assigned(lowering, item, element, limits, alone)
            for size in dimensions[1:]:
                row = f"{item}_row{size}"
                inner = [f"for (auto& {item} : {row}) {{", *indented(inner), "}"]
                item = row
            return [f"for (auto& {item} : {x}) {{", *indented(inner), "}"]
        case NamedType(name):
            return _named(lowering, x, name)
        case _:
            raise AssertionError(target)


def _variable(x: str) -> str:
    """Returns the variable that the expression `x` is a part of, for example "mock_value" for
    "std::get<1>(mock_value.origin.value).x"."""
    return x.rpartition("(")[2].partition(".")[0]


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


_HIDDEN = '"***"'
