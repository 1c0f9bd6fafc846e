"""Builds the view of `<file>_calls.hpp`: the arguments and the result of each call, as structs that
list their members (gecos/wire/layout.hpp)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby

from gidl.files.names import source_stem
from gidl.model import Attribute, File, Interface, Operation
from gidl.names.type_names import TypeName
from gidl.targets.calls import (
    CallValue,
    attribute_value,
    first_missing,
    members_of,
    parameter_value,
    reply_values,
    short_name,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.includes import system_headers
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.ranges import bounds, limits_text
from gidl.targets.cpp.statements import quoted
from gidl.targets.cpp.structs import Structs
from gidl.targets.cpp.type_text import PRIMITIVES
from gidl.targets.cpp.type_views import FieldView
from gidl.targets.groups import WIDTH, call, flat, group
from gidl.wire.wire_layout import CallKind, CallLayout, FieldLayout, min_size_of
from gidl.wire.wire_nodes import (
    AppendableNode,
    ArrayNode,
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


@dataclass(frozen=True, slots=True)
class ListedView:
    """A generated struct, and the generated function that lists the members of the struct. From
    this list, the runtime derives the codec of the struct."""

    name: str
    doc: str
    fields: tuple[FieldView, ...]
    head: str  # head of the function that lists the members
    body: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ResultView:
    """The result of a call. gidl generates no struct for this result: its type is an instance of a
    class template of the runtime, which contains the codec."""

    name: str
    type: str


@dataclass(frozen=True, slots=True)
class CallsNamespace:
    name: str
    structs: tuple[ListedView, ...]
    results: tuple[ResultView, ...]


@dataclass(frozen=True, slots=True)
class CallsView:
    source: str  # "robcl/gripper.gidl"
    types_header: str
    system: tuple[str, ...]
    namespaces: tuple[CallsNamespace, ...]


def calls_view(lowering: Lowering, file: File) -> CallsView:
    structs = _Calls(lowering)
    parts = [
        (place, view)
        for declaration in file.declarations
        if isinstance(declaration, Interface)
        for place, view in structs.of(declaration)
    ]
    spaces = tuple(
        _namespace(scope, [view for _, view in run])
        for scope, run in groupby(parts, key=lambda part: part[0].scope)
    )
    return CallsView(
        file.path,
        f"{source_stem(file.path)}_types.hpp",
        tuple(sorted(system_headers(_texts(view for _, view in parts)))),
        spaces,
    )


def _namespace(scope: tuple[str, ...], views: list[ListedView | ResultView]) -> CallsNamespace:
    return CallsNamespace(
        "::".join(scope),
        tuple(view for view in views if isinstance(view, ListedView)),
        tuple(view for view in views if isinstance(view, ResultView)),
    )


def _texts(views: Iterator[ListedView | ResultView]) -> Iterator[str]:
    for view in views:
        if isinstance(view, ResultView):
            yield view.type
        else:
            yield from (f"{each.type} {each.initial}" for each in view.fields)


@dataclass(frozen=True, slots=True)
class _Step:
    """The encoding of a value: a class of the namespace gecos::layout, and the arguments of its
    constructor."""

    type: str
    arguments: tuple[str, ...] = ()
    # True if the C++ type of the value already implies this encoding.
    default: bool = field(default=False, kw_only=True)

    @property
    def value(self) -> str:
        return f"{self.type}{{{', '.join(self.arguments)}}}"


_PLAIN = _Step("gecos::layout::Plain", default=True)


class _Calls(Structs):
    def of(self, interface: Interface) -> Iterator[tuple[TypeName, ListedView | ResultView]]:
        members = {m.scoped_name: m for m in interface.members}
        table = self._layout.cpp_names
        for each in self._layout.interfaces[interface.name].calls:
            member = members[each.name.removesuffix("=")]
            name = short_name(each).removesuffix("=")
            if each.request:
                does = f"setting `{name}`" if each.kind is CallKind.SETTER else f"`{name}`"
                takes = (
                    [parameter_value(p) for p in member.inputs]
                    if isinstance(member, Operation)
                    else [attribute_value(member)]
                )
                place = table.arguments[each.name]
                doc = f"The arguments of {does}."
                yield place, self._listed(place, doc, name, takes, each.request)
            if len(each.reply) == 1:
                place = table.results[each.name]
                yield place, self._result_of(place, name, each, member)

    def _result_of(
        self, place: TypeName, name: str, layout: CallLayout, member: Operation | Attribute
    ) -> ListedView | ResultView:
        if isinstance(member, Operation):
            value = reply_values(member, layout)[0]
        else:
            value = replace(attribute_value(member), name="result")
        step = self._step(layout.reply[0].node, inside=False, secret=value.secret)
        if step.arguments or value.name != "result":
            return self._listed(place, f"The result of `{name}`.", name, [value], layout.reply)
        held = [self._lowering.type(value.type, value.optional)]
        return ResultView(
            place.name,
            "gecos::layout::Result" + group(held + [step.type] * (not step.default), "<", ">"),
        )

    def _listed(
        self,
        place: TypeName,
        doc: str,
        owner: str,
        values: Sequence[CallValue],
        fields: tuple[FieldLayout, ...],
    ) -> ListedView:
        members = members_of(values)
        taken = {names.member_name(m.name) for m in members}
        local = names.Locals(taken)
        each, value = local.fresh("each"), local.fresh("self")
        terms: list[str] = []
        for i, (member, layout) in enumerate(zip(members, fields, strict=True)):
            if i == first_missing(values):
                terms.append(f"{each}.may_end()")
            step = self._step(layout.node, inside=False, secret=member.secret)
            given = [
                quoted(f"{owner}.{member.name}"),
                f"{value}.{names.member_name(member.name)}",
            ]
            terms.append(call(each, *given, *([] if step.default else [step.value])))
        return ListedView(
            place.name,
            doc,
            tuple(self._field(m) for m in members),
            f"static bool gecos_members(auto& {each}, auto& {value})",
            tuple(_conjunction(terms)),
        )

    def _step(self, node: Node, inside: bool, secret: bool = False) -> _Step:
        """Returns the encoding of a value. `inside` tells that the value is an element of a
        sequence or map. The encoding of a struct or union then contains the smallest size of such
        a value in bytes, because the decoder of a sequence or map must know this size."""
        if secret:
            step = self._step(node, inside)
            arguments = (step.value,) if step.arguments else ()
            return _Step(f"gecos::layout::Secret<{step.type}>", arguments)
        match node:
            case ScalarNode(primitive=primitive, limits=limits):
                if limits is None or not bounds(node):
                    return _PLAIN
                return _Step(
                    f"gecos::layout::Ranged<{PRIMITIVES[primitive]}>",
                    (bounds(node), limits_text(node)),
                )
            case StringNode(bound):
                return _PLAIN if bound is None else _Step(f"gecos::layout::Text<{bound}>")
            case AppendableNode() | UnionNode(appendable=True):
                return _Step("gecos::layout::Block")
            case StructNode() | UnionNode() | ObjectNode():
                least = min_size_of(self._model, node)
                return _Step(f"gecos::layout::Value<{least}>") if inside else _PLAIN
            case OptionalNode(element):
                return _around("Optional", [self._step(element, inside=False)])
            case ArrayNode(element, dimensions):
                step = self._step(element, inside)
                for _ in dimensions:
                    step = _around("Array", [step])
                return step
            case SequenceNode(element, bound):
                return _around("Items", [self._step(element, inside=True)], bound)
            case MapNode(key, value, bound):
                steps = [self._step(key, inside=True), self._step(value, inside=True)]
                return _around("Entries", steps, bound)
            case _:
                return _PLAIN


def _around(name: str, steps: list[_Step], bound: int | None = None) -> _Step:
    inner = [step.type for step in steps] + [str(bound)] * (bound is not None)
    given = any(step.arguments for step in steps)
    return _Step(
        f"gecos::layout::{name}<{', '.join(inner)}>",
        tuple(step.value for step in steps) if given else (),
        default=bound is None and all(step.default for step in steps),
    )


def _conjunction(terms: list[str]) -> list[str]:
    """Returns the statement `return a && b;` in lines that contain as many terms as fit."""
    lines = [f"return {terms[0]}"]
    for term in terms[1:]:
        if len(flat(lines[-1])) + len(flat(term)) + 12 > WIDTH:
            lines[-1] += " &&"
            lines.append(f"       {term}")
        else:
            lines[-1] += f" && {term}"
    lines[-1] += ";"
    return lines
