"""Functions that read requests and replies, and write replies."""

from __future__ import annotations

from gidl.languages import PYTHON_WORDS
from gidl.targets.calls import (
    CallValue,
    first_missing,
    short_name,
)
from gidl.targets.naming import LocalNames
from gidl.targets.python import names
from gidl.targets.python.calls.facts import CallFacts
from gidl.targets.python.calls.views import (
    FunctionView,
)
from gidl.targets.python.lower import Slot
from gidl.targets.python.values.names import LOCAL_WORDS
from gidl.wire_layout import CallLayout
from gidl.wire_nodes import AppendableNode, StructNode


class Bodies(CallFacts):
    def _reader(self, call: CallLayout) -> str:
        """Reads the reply body."""
        values = self._outputs(call)
        if not values:
            return "_nothing"
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
        self._functions.append(FunctionView(f"def {name}(source: _Decoder) -> {hint}:", body))
        return name

    def _arguments(self, call: CallLayout) -> str:
        """Reads the request body."""
        values = self._inputs(call)
        if not values:
            return "_no_arguments"
        name = self._function(call, "arguments")
        label = short_name(call).removesuffix("=")
        required = first_missing(values)
        local = LocalNames(LOCAL_WORDS | PYTHON_WORDS | self._type_names(values))
        lines, variables, hints = [], [], []
        for i, value in enumerate(values):
            slot = Slot("", f"{label}.{value.name}", value.type, value.optional, value.range)
            variable, hint = local.fresh(value.name), self._hint(value)
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
        head = f"def {name}(source: _Decoder) -> tuple[{', '.join(hints)}]:"
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
            return "_no_result"
        name = self._function(call, "result")
        hint = self._result_hint(call)
        struct = self._result_struct(call)
        if struct is not None:
            kind = names.type_name(self._model, struct.name)
            writes = [f'_wire.put(value, {kind}, out, "{short_name(call)}")']
        else:
            v = values[0]
            local = LocalNames(LOCAL_WORDS | self._type_names(values) | {"value"})
            slot = Slot("value", short_name(call), v.type, v.optional, v.range)
            writes = self._lowering.encode(slot, local)
        body = ("out: _Parts = []", *writes, "return out")
        self._functions.append(FunctionView(f"def {name}(value: {hint}) -> _Parts:", body))
        return name
