"""Unions: their arms, how they are written and read."""

from __future__ import annotations

from gidl.model import Primitive, Union
from gidl.targets.groups import call, group
from gidl.targets.naming import LocalNames, value_note
from gidl.targets.python import names
from gidl.targets.python.lower import CODES, Slot, holds_array, indented
from gidl.targets.python.lower.types import quoted
from gidl.targets.python.values.names import LOCAL_WORDS, ValueNames, type_doc
from gidl.targets.python.values.views import ArmView, UnionView
from gidl.targets.reach import type_reaches
from gidl.wire_layout import UnionLayout
from gidl.wire_nodes import EnumNode, ScalarNode


class Unions(ValueNames):
    def _union(self, union: Union) -> UnionView:
        lowering = self._lowering
        layout = self._layout.unions[union.name]
        tag_default, _ = lowering.zero(layout.tag)
        hints: list[str] = []
        for arm in layout.arms:
            hints += [h for h in lowering.hint(arm.node).split(" | ") if h not in hints]
        return UnionView(
            "union",
            self._name(union),
            type_doc(union.facts),
            lowering.hint(layout.tag),
            tag_default,
            " | ".join([*hints, "None"]),
            tuple(self._arms(union, layout)),
            tuple(self._select(union, layout)),
            tuple(self._encode(union, layout)),
            tuple(self._decode(union, layout)),
            f"0x{layout.fingerprint & (1 << 64) - 1:016X}",
            any(holds_array(arm.node) for arm in layout.arms),
            tuple(i for i, case in enumerate(union.cases, start=1) if case.member.secret),
            lowering.shape(layout.tag),
            tuple(
                call("_shapes.Secret", shape) if case.member.secret else shape
                for case, arm in zip(union.cases, layout.arms, strict=True)
                for shape in [lowering.shape(arm.node)]
            ),
        )

    def _arms(self, union: Union, layout: UnionLayout) -> list[ArmView]:
        words = names.STRUCT_WORDS | {"tag", "value"}
        nodes = [layout.tag, *(arm.node for arm in layout.arms)]
        words = self._lowering.words_beside(nodes, words)
        called = [names.member_name(case.member.name, words) for case in union.cases]
        makers = LocalNames(called)
        return [
            ArmView(
                name,
                makers.fresh(f"make_{name}"),
                self._lowering.hint(arm.node),
                self._lowering.literal(case.labels[0], layout.tag) if case.labels else "",
                len(case.labels) != 1 or case.is_default,
                index,
                type_doc(case.member.facts, value_note(case.member.unit, case.member.range)),
            )
            for index, (case, arm, name) in enumerate(
                zip(union.cases, layout.arms, called, strict=True), start=1
            )
        ]

    def _encode(self, union: Union, layout: UnionLayout) -> list[str]:
        lowering, tag = self._lowering, layout.tag
        label = quoted(f"{union.simple_name}.tag")
        char = isinstance(tag, ScalarNode) and tag.primitive is Primitive.CHAR
        boolean = isinstance(tag, ScalarNode) and tag.primitive is Primitive.BOOLEAN
        number = "_wire.char(self.tag)[0]" if char else "int(self.tag)" if boolean else "self.tag"
        why = quoted("its tag does not select the arm that it holds")
        refusal = call("_wire.EncodeError", quoted(union.simple_name), why)
        written = call("_wire.number", number, quoted(_tag_code(layout)), label)
        lines = [
            "_arm = self._arm(self.tag)",
            "value: _Any = self.value",
            "if (value is None) != (_arm == 0):",
            f"    raise {refusal}",
            call("out.append", written),
        ]
        if isinstance(tag, EnumNode):
            kind = lowering.module.value(tag.name)
            lines.append(call("_wire.expect_enumerator", "self.tag", kind, label))
        slots = _slots(union, layout)
        used = {home.name for slot in slots for home in lowering.used(slot.node)}
        for index, slot in enumerate(slots, start=1):
            local = LocalNames(LOCAL_WORDS | used | {"value"})
            lines += [
                f'out.append(b"\\1" if _arm == {index} else b"\\0")',
                f"if _arm == {index}:",
                *indented(lowering.encode(slot, local)),
            ]
        return lines

    def _decode(self, union: Union, layout: UnionLayout) -> list[str]:
        lines = self._decode_tag(union, layout)
        lines += ["_arm = cls._arm(tag)", "value: _Any = None"]
        for index, slot in enumerate(_slots(union, layout), start=1):
            lines += [
                f"if {call('source.arm', f'_arm == {index}', quoted(slot.label))}:",
                f"    value = {self._lowering.decode(slot)}",
            ]
        if layout.appendable:
            lines.append("source.offset = source.end")
        lines.append("return cls(tag, value)")
        if type_reaches(self._model, union.name, union.name):
            lines = [f'source.enter("{union.simple_name}")', *lines]
            lines.insert(-1, "source.leave()")
        return lines

    def _decode_tag(self, union: Union, layout: UnionLayout) -> list[str]:
        node, code, label = layout.tag, _tag_code(layout), f"{union.simple_name}.tag"
        if isinstance(node, EnumNode):
            return [f"tag = {self._lowering.decode(Slot('', label, node))}"]
        size = {"i": 4, "q": 8, "Q": 8}[code]
        kind = node.primitive
        lines = [f"number: int = {call('source.number', quoted(code), quoted(label))}"]
        limits = (0, 1) if kind is Primitive.BOOLEAN else (0, 255)
        if kind.is_integer:
            limits = kind.integer_limits
        if not (kind.is_integer and kind.size == size):
            problem = "_wire.DecodeProblem.UNKNOWN_UNION_TAG"
            refuse = call("source.refuse", problem, quoted(label), f"source.offset - {size}")
            lines += [f"if not {limits[0]} <= number <= {limits[1]}:", f"    {refuse}"]
        made = {Primitive.BOOLEAN: "number == 1", Primitive.CHAR: "chr(number)"}.get(kind, "number")
        return [*lines, f"tag = {made}"]

    def _select(self, union: Union, layout: UnionLayout) -> list[str]:
        boolean = isinstance(layout.tag, ScalarNode) and layout.tag.primitive is Primitive.BOOLEAN
        lines, otherwise = [], "return 0"
        for index, case in enumerate(union.cases, start=1):
            if case.is_default:
                otherwise = f"return {index}"
                continue
            labels = [self._lowering.literal(v, layout.tag) for v in case.labels]
            if boolean:
                test = " or ".join("tag" if text == "True" else "not tag" for text in labels)
            elif len(labels) == 1:
                test = f"tag == {labels[0]}"
            else:
                test = f"tag in {group(labels)}"
            lines += [f"if {test}:", f"    return {index}"]
        return [*lines, otherwise]


def _slots(union: Union, layout: UnionLayout) -> list[Slot]:
    """The arms."""
    return [
        Slot("value", f"{union.simple_name}.{arm.name}", arm.node, case.member.secret)
        for case, arm in zip(union.cases, layout.arms, strict=True)
    ]


def _tag_code(layout: UnionLayout) -> str:
    if isinstance(layout.tag, ScalarNode) and layout.tag.primitive is Primitive.UINT64:
        return "Q"
    return CODES[layout.wire_tag]
