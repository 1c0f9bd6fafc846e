"""Builds the view of a mock server in Python."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from gidl.model import Attribute, Direction, Interface, Operation
from gidl.model.policy import Access
from gidl.names.languages import PYTHON_CLASS_WORDS
from gidl.targets import samples
from gidl.targets.groups import call
from gidl.targets.naming import LocalNames, snake_case
from gidl.targets.python import names
from gidl.targets.python.homes import NamesAsUsed
from gidl.targets.python.imports import import_lines
from gidl.targets.python.interface_members import Members
from gidl.targets.python.interface_views import HandlerView
from gidl.targets.python.layout_steps import Lowering
from gidl.targets.python.mock_values import MockValues, OwnNames, plain_hint
from gidl.wire.wire_layout import CallKind, CallLayout
from gidl.wire.wire_nodes import Node


@dataclass(frozen=True, slots=True)
class HeldView:
    """An attribute of a mock. The getter of the attribute returns the value that was set last."""

    name: str
    hint: str
    value: str


@dataclass(frozen=True, slots=True)
class MethodView:
    handler: HandlerView
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StreamView:
    made: str
    rate: str


@dataclass(frozen=True, slots=True)
class MockView:
    name: str  # name of the class: "MockRx90"
    base: str  # base class: "Rx90Servant"
    scoped_name: str
    object: str  # name of the object that the mock serves
    variable: str
    beats: str  # name of the method that returns the mock's streams
    beats_hint: str
    held: tuple[HeldView, ...]
    methods: tuple[MethodView, ...]
    streams: tuple[StreamView, ...]


@dataclass(frozen=True, slots=True)
class MocksView:
    source: str
    own: OwnNames
    standard: tuple[str, ...]
    imports: tuple[str, ...]
    mocks: tuple[MockView, ...]
    publishes: bool


def mocks_view(lowering: Lowering, path: str, interfaces: Sequence[Interface]) -> MocksView:
    model, table = lowering.model, lowering.layout.python_names.types
    every = [m for i in interfaces for m in model.all_interface_members(i)]
    parameters = {p.name for m in every if isinstance(m, Operation) for p in m.parameters}
    parameters |= {f"{name}_" for name in parameters} | {"self", "name", "stamp", "value", "run"}
    methods = {name for member in every for name in names.method_names(member)}
    own = OwnNames(parameters | methods)
    mocks = {f"Mock{table[interface.name].name}" for interface in interfaces}
    taken = own.all | parameters | methods | mocks | {"print"}
    module = NamesAsUsed(lowering.module.homes, taken)
    printing = lowering.within(module)
    served = LocalNames()
    views = tuple(_Mock(printing, interface, own).view(served) for interface in interfaces)
    text = "\n".join(
        [each.hint for v in views for m in v.methods for each in m.handler.parameters]
        + [m.handler.result for v in views for m in v.methods]
        + [h.hint for v in views for h in v.held]
        + [v.beats_hint for v in views]
        + [line for v in views for m in v.methods for line in m.body]
        + [h.value for v in views for h in v.held]
    )
    publishes = any(v.streams for v in views)
    imports = [_imported("gecos", own["gecos"])]
    for word, module_name in (("np", "numpy"), ("npt", "numpy.typing")):
        if re.search(rf"\b{own[word]}\.", text):
            imports.append(_imported(module_name, own[word]))
    needed = ["builtins"] if re.search(rf"\b{own['builtins']}\.", text) else []
    standard: list[str] = []
    needed += ["contextlib", "threading", "time"] if publishes else []
    standard += [_imported(word, own[word]) for word in needed]
    if publishes:
        callable_, named_tuple = (_as(word, own[word]) for word in ("Callable", "NamedTuple"))
        standard += import_lines({"collections.abc": [callable_], "typing": [named_tuple]})
    return MocksView(
        path, own, tuple(standard), (*imports, *import_lines(module.imports())), views, publishes
    )


def _imported(module: str, called: str) -> str:
    return f"import {_as(module, called)}"


def _as(name: str, called: str) -> str:
    return name if name == called else f"{name} as {called}"


class _Facts(Members):
    """Prints the heads of the methods of a mock as in hand-written code, without private names,
    because users edit the mocks that gidl writes."""

    def __init__(self, lowering: Lowering, interface: Interface, own: OwnNames) -> None:
        super().__init__(lowering, interface, names.Constants())
        self._own_names = own

    def hidden_by(self, methods: set[str]) -> None:
        """Sets the names of all methods of the mock's class. These methods may hide builtins."""
        self._beside = methods

    def _in_class(self, hint: str) -> str:
        return plain_hint(hint, self._own_names, self._beside & PYTHON_CLASS_WORDS)

    def _execution(self) -> str:
        return f"{self._own_names['gecos']}.Execution"


class _Mock(MockValues):
    def __init__(self, lowering: Lowering, interface: Interface, own: OwnNames) -> None:
        self.interface = interface
        super().__init__(lowering, own)
        self._name = self._layout.python_names.types[interface.name].name
        members = self._model.all_interface_members(interface)
        self._methods = {name for member in members for name in names.method_names(member)}

    def view(self, served: LocalNames) -> MockView:
        """Returns the view of the mock. `served` has the names under which the earlier mocks of the
        file are served."""
        held, methods, streams = [], [], []
        for interface in self._model.with_bases(self.interface):
            facts = _Facts(self._lowering, interface, self._own)
            facts.hidden_by(self._methods)
            for layout in self._layout.interfaces[interface.name].calls:
                member = facts._member(layout)
                body = tuple(self._body(facts, layout, member))
                methods.append(MethodView(facts._handler(layout), body))
                if isinstance(member, Attribute) and layout.kind is CallKind.GETTER:
                    node = layout.reply[0].node
                    held.append(HeldView(_held(member), self._hint(node), self._value(node)))
                    if member.streams_out and member.stream is not None:
                        streams.append(self._stream(member, member.stream.rate_hz))
        called = served.fresh(snake_case(self._name))
        beats = LocalNames(self._methods).fresh("mock_streams")
        hint = plain_hint(
            f"list[{self._own['Beat']}]", self._own, self._methods & PYTHON_CLASS_WORDS
        )
        return MockView(
            f"Mock{self._name}",
            self._module.servant(self.interface.name),
            self.interface.name,
            called.upper(),
            f"mock_{called}",
            beats,
            hint,
            tuple(held),
            tuple(methods),
            tuple(streams),
        )

    def _stream(self, attribute: Attribute, rate: float | None) -> StreamView:
        published = call(
            f"self.{names.publisher(attribute.name)}", f"self.{_held(attribute)}", "stamp"
        )
        period = str(samples.nanoseconds(rate))
        return StreamView(
            call(self._own["Beat"], period, f"lambda stamp: {published}"),
            f"{rate:g} a second" if rate else "no rate is declared: 1 a second",
        )

    def _body(self, facts: _Facts, layout: CallLayout, member: Operation | Attribute) -> list[str]:
        if isinstance(member, Attribute):
            if layout.kind is CallKind.GETTER:
                return [f"return self.{_held(member)}"]
            told = [("value", "value", member.secret)]
            log = self._log(member.name, told, (), setter=True)
            return [log, f"self.{_held(member)} = value"]
        inputs = [each.value.name for each in facts._inputs(layout)]
        called = dict(zip(inputs, facts._parameter_names(layout), strict=True))
        hidden = called.values()
        lines = []
        if member.access is not Access.SENSOR or member.safety:
            told = [(p.name, called[p.name], p.secret) for p in member.inputs]
            lines.append(self._log(member.name, told, hidden))
        if member.cancelable:
            node = facts._feedback_node(member)
            feedback = [] if node is None else [self._value(node, hidden=hidden)]
            lines.append(call(f"{facts._run(layout)}.progress", "1.0", *feedback))
        outputs = facts._outputs(layout)
        given_back = {p.name for p in member.parameters if p.direction is Direction.INOUT}
        answers = [
            called[each.value.name]
            if each.value.name in given_back
            else self._value(each.node, hidden=hidden)
            for each in outputs
        ]
        if facts._gives_several(layout):
            nodes = [each.node for each in outputs]
            words = self._lowering.words_beside(nodes, names.STRUCT_WORDS)
            items = [
                f"    {names.member_name(each.value.name, words)}={text},"
                for each, text in zip(outputs, answers, strict=True)
            ]
            lines += [f"return {self._module.result(member)}(", *items, ")"]
        elif answers:
            lines.append(f"return {answers[0]}")
        return lines or ["pass"]

    def _log(
        self,
        name: str,
        told: list[tuple[str, str, bool]],
        hidden: Collection[str],
        setter: bool = False,
    ) -> str:
        shown = ", ".join(
            f"{word}=***" if secret else f"{word}={{{variable}!r}}"
            for word, variable, secret in told
        )
        what = f"{name} = {shown.removeprefix('value=')}" if setter else f"{name}({shown})"
        text = f'f"{{self._mock_name}}: {what}"'
        return call(self._builtin("print", hidden), text, "flush=True")

    def _hint(self, node: Node) -> str:
        return plain_hint(self._lowering.hint(node, sending=True), self._own, ())


def _held(attribute: Attribute) -> str:
    return f"_held_{attribute.name}"
