"""What client and server must agree on: names, parameters and results of each call."""

from __future__ import annotations

import re

from gidl.languages import PYTHON_WORDS
from gidl.model import Attribute, Interface, Operation, Struct
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    parameter_value,
    reply_values,
    result_struct,
    short_name,
)
from gidl.targets.naming import LocalNames
from gidl.targets.python import names
from gidl.targets.python.calls.views import (
    FunctionView,
)
from gidl.targets.python.lower import Lowering
from gidl.wire_layout import CallKind, CallLayout


class CallFacts:
    def __init__(
        self, lowering: Lowering, interface: Interface, constants: names.Constants
    ) -> None:
        self.interface = interface
        self.constants = constants  # of all interfaces of the file
        self.used_types: set[str] = set()
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout
        self._name = names.type_name(self._model, interface.name)
        self._members = {m.scoped_name: m for m in interface.members}
        self._functions: list[FunctionView] = []
        self._beside = {names.method_name(m.name) for m in interface.members}
        self.hidden: set[str] = set()

    def _member(self, call: CallLayout) -> Operation | Attribute:
        return self._members[call.name.removesuffix("=")]

    def _constant(self, call: CallLayout) -> str:
        short = short_name(call)
        words = ("set", short.removesuffix("=")) if short.endswith("=") else (short,)
        return self.constants.name(self._name, *words)

    def _function(self, call: CallLayout, what: str) -> str:
        return f"{self._constant(call).lower()}_{what}"

    def _method_name(self, call: CallLayout) -> str:
        member = self._member(call)
        if call.kind is CallKind.SETTER:
            return names.method_names(self._model, self.interface).fresh(f"set_{member.name}")
        return names.method_name(member.name)

    def _inputs(self, call: CallLayout) -> list[CallValue]:
        member = self._member(call)
        if isinstance(member, Operation):
            return [parameter_value(p) for p in member.inputs]
        return [attribute_value(member)] if call.kind is CallKind.SETTER else []

    def _parameter_names(self, call: CallLayout) -> list[str]:
        """Of the inputs, in order: what else a body names is none of them."""
        inputs = self._inputs(call)
        local = LocalNames(PYTHON_WORDS | {"out"} | self._type_names(inputs))
        return [local.fresh(value.name) for value in inputs]

    def _type_names(self, values: list[CallValue]) -> set[str]:
        """Of the types that codecs of the values name."""
        used = {name for value in values for name in self._lowering.imports(value.type)}
        return {names.type_name(self._model, name) for name in used}

    def _outputs(self, call: CallLayout) -> list[CallValue]:
        member = self._member(call)
        if isinstance(member, Operation):
            return reply_values(member, call)
        return [] if call.kind is CallKind.SETTER else [attribute_value(member)]

    def _in_class(self, hint: str) -> str:
        """The hint where members hide names: an operation `list` is no type, so `_list_` is."""

        def other(found: re.Match[str]) -> str:
            if found[0] not in self._beside:
                return found[0]
            self.hidden.add(found[0])
            return f"_{found[0]}_"

        return re.sub(r"(?<![.\w])[A-Za-z]\w*", other, hint)

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

    def _stream_constant(self, attribute: Attribute) -> str:
        return self.constants.name(self._name, attribute.name, "stream")
