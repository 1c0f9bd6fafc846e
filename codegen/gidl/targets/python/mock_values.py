"""Names in a Python mock, and the values that the methods of the mock return."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

from gidl.model import Bitset, EnumDeclaration, Primitive, Union, Value
from gidl.targets import samples
from gidl.targets.groups import call, clauses, group
from gidl.targets.naming import LocalNames
from gidl.targets.python import names
from gidl.targets.python.layout_steps import Lowering
from gidl.targets.python.type_text import DTYPES, bulk_code, is_octet
from gidl.wire.wire_nodes import (
    AppendableNode,
    ArrayNode,
    EnumNode,
    MapNode,
    Node,
    ObjectNode,
    OptionalNode,
    ScalarNode,
    SequenceNode,
    StringNode,
    StructNode,
    UnionNode,
)


class OwnNames:
    """The names that a mock needs for itself. They differ from the names in `taken`, which are the
    names of parameters and methods. The names of types are chosen later, and then differ from the
    names in this class."""

    def __init__(self, taken: Iterable[str]) -> None:
        free = LocalNames(taken)
        self.modules = {
            word: free.fresh(word)
            for word in ("gecos", "np", "npt", "builtins", "contextlib", "threading", "time")
        }
        self.words = {
            word: free.fresh(word) for word in ("Callable", "NamedTuple", "Beat", "publish", "main")
        }

    def __getitem__(self, word: str) -> str:
        return self.modules.get(word) or self.words[word]

    @property
    def all(self) -> set[str]:
        return {*self.modules.values(), *self.words.values()}


def plain_hint(hint: str, own: OwnNames, hidden: Collection[str]) -> str:
    """Returns the type hint `hint` as in hand-written code. A builtin such as `list` becomes
    `builtins.list` if a method of the mock has the same name."""

    def other(found: re.Match[str]) -> str:
        return f"{own['builtins']}.{found[0]}" if found[0] in hidden else found[0]

    hint = re.sub(r"(?<![.\w])[A-Za-z]\w*", other, hint)
    return re.sub(r"\b_(npt?)\.", lambda found: f"{own[found[1]]}.", hint)


class MockValues:
    def __init__(self, lowering: Lowering, own: OwnNames) -> None:
        self._own = own
        self._lowering = lowering
        self._module = lowering.module
        self._model = lowering.model
        self._layout = lowering.layout

    def _builtin(self, word: str, hidden: Collection[str]) -> str:
        return f"{self._own['builtins']}.{word}" if word in hidden else word

    def _value(self, node: Node, default: Value | None = None, hidden: Collection[str] = ()) -> str:
        """Returns an expression for the value that a mock returns. The expression uses no builtin
        whose name is in `hidden`, because a parameter has this name."""
        if default is not None and not isinstance(node, OptionalNode):
            return self._lowering.literal(default, node)
        match node:
            case ScalarNode(Primitive.BOOLEAN):
                return "False"
            case ScalarNode(Primitive.CHAR):
                return '"\\0"'
            case ScalarNode(kind, limits):
                return repr(samples.number(kind, limits))
            case StringNode():
                return '""'
            case MapNode():
                return "{}"
            case SequenceNode(element):
                if is_octet(element):
                    return 'b""'
                code = bulk_code(element)
                np = self._own["np"]
                return call(f"{np}.empty", "0", f"{np}.{DTYPES[code]}") if code else "[]"
            case ArrayNode(element, dimensions):
                return self._array(element, dimensions, hidden)
            case EnumNode(name):
                declaration = self._model.find(name)
                mine = self._module.value(name)
                if isinstance(declaration, EnumDeclaration):
                    return f"{mine}.{names.enumerator(declaration.initial.name)}"
                return f"{mine}()" if isinstance(declaration, Bitset) else f"{mine}(0)"
            case UnionNode(name):
                return self._union(name, hidden)
            case StructNode(name) | AppendableNode(name):
                return self._struct(name, hidden)
            case ObjectNode(name):
                return f"{self._module.value(name)}()"
            case OptionalNode():
                return "None"

    def _array(self, element: Node, dimensions: tuple[int, ...], hidden: Collection[str]) -> str:
        if is_octet(element) and len(dimensions) == 1:
            return f"{self._builtin('bytes', hidden)}({dimensions[0]})"
        text = self._value(element, None, hidden)
        code = bulk_code(element)
        if code:
            sizes = group(map(str, dimensions)) if dimensions[1:] else str(dimensions[0])
            np = self._own["np"]
            return call(f"{np}.full", sizes, text, f"{np}.{DTYPES[code]}")
        for size in reversed(dimensions):
            each = f"for _ in {self._builtin('range', hidden)}({size})"
            text = clauses([text, each], "[", "]")
        return text

    def _struct(self, name: str, hidden: Collection[str]) -> str:
        struct = self._model.struct(name)
        mine = self._module.value(name)
        if struct.maps_to is not None:
            return f"{mine}()"
        words = self._lowering.words(struct)
        members = zip(
            self._model.all_members(struct), self._layout.structs[name].fields, strict=True
        )
        given = [
            f"{names.member_name(m.name, words)}={self._value(field.node, m.default, hidden)}"
            for m, field in members
            if not m.optional
            and m.default is None
            and not samples.is_made_by_default(self._model, field.node, alone=False)
        ]
        return call(mine, *given)

    def _union(self, name: str, hidden: Collection[str]) -> str:
        union = self._model.find(name)
        assert isinstance(union, Union)
        layout = self._layout.unions[name]
        case = samples.arm_of(union)
        arm = self._value(layout.arms[union.cases.index(case)].node, None, hidden)
        tag = (
            self._lowering.literal(case.labels[0], layout.tag)
            if case.labels
            else self._value(layout.tag, None, hidden)
        )
        return call(self._module.value(name), tag, arm)
