"""Facts that client and server code share: names, parameters and results of each call."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gidl.model import Attribute, Interface, Operation
from gidl.names.languages import PYTHON_WORDS
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    parameter_value,
    reply_values,
    short_name,
)
from gidl.targets.python import names
from gidl.targets.python.base_classes import class_bases
from gidl.targets.python.homes import Home
from gidl.targets.python.layout_steps import Lowering
from gidl.wire.wire_layout import CallKind, CallLayout, FieldLayout, node_of
from gidl.wire.wire_nodes import Node


@dataclass(frozen=True, slots=True)
class Passed:
    """A parameter, a result or the value of an attribute, and its node in the wire layout."""

    value: CallValue
    node: Node


class CallFacts:
    def __init__(
        self, lowering: Lowering, interface: Interface, constants: names.Constants
    ) -> None:
        self.interface = interface
        self.constants = constants  # names of the constants of all interfaces in the file
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self._module = lowering.module
        self._name = self._layout.python_names.types[interface.name].name
        self._members = {m.scoped_name: m for m in interface.members}
        self._beside = {name for m in interface.members for name in names.method_names(m)}
        self.hidden: set[str] = set()

    def _member(self, call: CallLayout) -> Operation | Attribute:
        return self._members[call.name.removesuffix("=")]

    def _constant(self, call: CallLayout) -> str:
        short = short_name(call)
        words = ("set", short.removesuffix("=")) if short.endswith("=") else (short,)
        return self.constants.name(self._name, *words)

    def _method_name(self, call: CallLayout) -> str:
        member = self._member(call)
        if call.kind is CallKind.SETTER:
            return names.setter(member.name)
        return names.method_name(member.name)

    def _inputs(self, call: CallLayout) -> list[Passed]:
        member = self._member(call)
        if isinstance(member, Operation):
            return _passed([parameter_value(p) for p in member.inputs], call.request)
        setter = call.kind is CallKind.SETTER
        return _passed([attribute_value(member)], call.request) if setter else []

    def _outputs(self, call: CallLayout) -> list[Passed]:
        member = self._member(call)
        if isinstance(member, Operation):
            return _passed(reply_values(member, call), call.reply)
        setter = call.kind is CallKind.SETTER
        return [] if setter else _passed([attribute_value(member)], call.reply)

    def _sample(self, attribute: Attribute) -> Passed:
        sample = self._layout.stream(attribute.scoped_name).sample
        return Passed(attribute_value(attribute), sample.node)

    def _parameter_names(self, call: CallLayout) -> list[str]:
        """Returns the names of the parameters, in order. A parameter does not get the name of a
        class that a type hint of these parameters uses."""
        inputs = self._inputs(call)
        words = self._lowering.words_beside([each.node for each in inputs], PYTHON_WORDS)
        return [names.member_name(each.value.name, words) for each in inputs]

    def _missing(self, each: Passed) -> str:
        """Returns the text of the default value that a parameter gets if an older caller leaves it
        out."""
        if each.value.optional or each.value.default is None:
            return "None"
        return self._lowering.literal(each.value.default, each.node)

    def _gives_several(self, call: CallLayout) -> bool:
        return call.name in self._layout.python_names.results

    def _in_class(self, hint: str) -> str:
        """Returns the type hint `hint` for use inside a class. If a method of the class is called
        `list`, it hides the type `list`, and the hint uses the alias `_list_`."""

        def other(found: re.Match[str]) -> str:
            if found[0] not in self._beside:
                return found[0]
            self.hidden.add(found[0])
            return f"_{found[0]}_"

        return re.sub(r"(?<![.\w])[A-Za-z]\w*", other, hint)

    def _result_hint(self, call: CallLayout, sending: bool = False) -> str:
        member = self._member(call)
        if self._gives_several(call):
            assert isinstance(member, Operation)
            return self._module.result(member)
        values = self._outputs(call)
        return self._lowering.hint(values[0].node, sending) if values else "None"

    def _feedback_node(self, member: Operation | Attribute) -> Node | None:
        if isinstance(member, Operation) and member.feedback is not None:
            return node_of(self._model, member.feedback)
        return None

    def _feedback_hint(self, call: CallLayout) -> str:
        node = self._feedback_node(self._member(call))
        return "None" if node is None else self._lowering.hint(node)


def classes_of(lowering: Lowering, interface: Interface) -> set[Home]:
    """Returns the generated classes that the proxy and the servant of an interface use: the types
    of values, and base classes."""
    model, layout, homes = lowering.model, lowering.layout, lowering.module.homes
    nodes: list[Node] = []
    found: set[Home] = set()
    for call in layout.interfaces[interface.name].calls:
        nodes += [field.node for field in (*call.request, *call.reply)]
        found |= {homes.value(name) for name, _ in call.exceptions}
    for stream in layout.interfaces[interface.name].streams:
        nodes.append(stream.sample.node)
    for operation in interface.operations:
        if operation.feedback is not None:
            nodes.append(node_of(model, operation.feedback))
        if operation.scoped_name in layout.python_names.results:
            found.add(homes.result(operation))
    for base in {*interface.bases, *class_bases(model, interface)}:
        found |= {homes.proxy(base), homes.servant(base)}
    return found.union(*(lowering.named(node) for node in nodes))


def _passed(values: list[CallValue], fields: tuple[FieldLayout, ...]) -> list[Passed]:
    return [Passed(v, field.node) for v, field in zip(values, fields, strict=True)]
