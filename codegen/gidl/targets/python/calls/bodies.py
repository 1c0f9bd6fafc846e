"""Functions that read requests and replies, and write replies."""

from __future__ import annotations

from gidl.languages import PYTHON_WORDS
from gidl.targets.calls import first_missing, short_name
from gidl.targets.groups import call, group
from gidl.targets.naming import LocalNames
from gidl.targets.python.calls.facts import CallFacts, Passed
from gidl.targets.python.calls.views import FunctionView
from gidl.targets.python.lower.types import quoted
from gidl.targets.python.values.names import LOCAL_WORDS
from gidl.wire_layout import CallLayout
from gidl.wire_nodes import AppendableNode, StructNode


class Bodies(CallFacts):
    def _reader(self, layout: CallLayout) -> str:
        """Reads the reply body."""
        values = self._outputs(layout)
        if not values:
            return "_nothing"
        hint = self._result_hint(layout)
        node = values[0].node
        if self._gives_several(layout) or isinstance(node, StructNode):
            return f"{hint}.decode"
        name = self._function(layout, "reply")
        expression = self._lowering.decode(values[0].slot("", short_name(layout)))
        body: tuple[str, ...] = (f"return {expression}",)
        if not isinstance(node, AppendableNode):
            body = (f"value: {hint} = {expression}", "return value")
        self._functions.append(FunctionView(f"def {name}(source: _Decoder) -> {hint}:", body))
        return name

    def _arguments(self, layout: CallLayout) -> str:
        """Reads the request body."""
        values = self._inputs(layout)
        if not values:
            return "_no_arguments"
        name = self._function(layout, "arguments")
        label = short_name(layout).removesuffix("=")
        required = first_missing([each.value for each in values])
        local = LocalNames(LOCAL_WORDS | PYTHON_WORDS | self._type_names(values))
        lines, variables, hints = [], [], []
        for i, each in enumerate(values):
            variable, hint = local.fresh(each.value.name), self._lowering.hint(each.node)
            expression = self._lowering.decode(each.slot("", f"{label}.{each.value.name}"))
            variables.append(variable)
            hints.append(hint)
            if i < required:
                lines.append(f"{variable}: {hint} = {expression}")
            else:
                lines.append(f"{variable}: {hint} = {self._missing(each)}")
                lines += ["if source.offset < source.end:", f"    {variable} = {expression}"]
        given = ", ".join(variables)
        if len(variables) == 1:
            given = f"({given},)"
        elif len(given) > 85:
            given = group(variables)
        lines.append(f"return {given}")
        head = f"def {name}(source: _Decoder) -> tuple{group(hints, '[', ']')}:"
        self._functions.append(FunctionView(head, tuple(lines)))
        return name

    def _missing(self, each: Passed) -> str:
        if each.value.optional or each.value.default is None:
            return "None"
        return self._lowering.literal(each.value.default, each.node)

    def _writer(self, layout: CallLayout) -> str:
        """Writes the reply body."""
        values = self._outputs(layout)
        if not values:
            return "_no_result"
        name = self._function(layout, "result")
        hint = self._result_hint(layout, sending=True)
        if self._gives_several(layout):
            writes = [call("_wire.put", "value", hint, "out", quoted(short_name(layout)))]
        else:
            local = LocalNames(LOCAL_WORDS | self._type_names(values) | {"value"})
            writes = self._lowering.encode(values[0].slot("value", short_name(layout)), local)
        body = ("out: _Parts = []", *writes, "return out")
        self._functions.append(FunctionView(f"def {name}(value: {hint}) -> _Parts:", body))
        return name
