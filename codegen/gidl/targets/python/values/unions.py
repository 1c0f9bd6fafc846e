"""Unions: their arms, how they are written and read."""

from __future__ import annotations

from gidl.model import (
    Member,
    Primitive,
    PrimitiveType,
    Union,
)
from gidl.targets.naming import LocalNames, value_note
from gidl.targets.python import names
from gidl.targets.python.lower import CODES, Slot, indented
from gidl.targets.python.values.names import (
    LOCAL_WORDS,
    ValueNames,
    type_doc,
    type_names,
)
from gidl.targets.python.values.views import (
    ArmView,
    UnionView,
)
from gidl.targets.reach import type_reaches
from gidl.wire_layout import node_of, wire_tag_of
from gidl.wire_nodes import EnumNode, ScalarNode


class Unions(ValueNames):
    def _union(self, union: Union) -> UnionView:
        lowering = self._lowering
        tag_node = node_of(self._model, union.discriminator)
        assert isinstance(tag_node, ScalarNode | EnumNode)
        tag_member = Member("tag", union.discriminator, union.facts)
        tag_default, _ = lowering.initial(tag_member)
        arms, encode, decode, hints = [], [], [], []
        code = CODES[wire_tag_of(tag_node)]
        label = f"{union.simple_name}.tag"
        char = isinstance(tag_node, ScalarNode) and tag_node.primitive is Primitive.CHAR
        boolean = isinstance(tag_node, ScalarNode) and tag_node.primitive is Primitive.BOOLEAN
        number = "_wire.char(self.tag)[0]" if char else "int(self.tag)" if boolean else "self.tag"
        if isinstance(tag_node, ScalarNode) and tag_node.primitive is Primitive.UINT64:
            code = "Q"
        encode += [
            "arm = self._arm(self.tag)",
            "value: _Any = self.value",
            "if (value is None) != (arm == 0):",
            f'    raise _wire.EncodeError("{union.simple_name}",'
            ' "its tag does not select the arm that it holds")',
            f'out.append(_wire.number({number}, "{code}", "{label}"))',
        ]
        if isinstance(tag_node, EnumNode):
            kind = names.type_name(self._model, tag_node.name)
            encode.append(f'_wire.expect_enumerator(self.tag, {kind}, "{label}")')
        decode += self._decode_tag(union, tag_node, code, label)
        decode += ["arm = cls._arm(tag)", "value: _Any = None"]
        for index, case in enumerate(union.cases, start=1):
            used = case.member.type
            arm_label = f"{union.simple_name}.{case.member.name}"
            hint = lowering.hint(used)
            hints += [h for h in hint.split(" | ") if h not in hints]
            several = len(case.labels) != 1 or case.is_default
            tag = lowering.literal(case.labels[0], union.discriminator) if case.labels else ""
            arms.append(
                ArmView(
                    names.member_name(case.member.name, names.STRUCT_WORDS | {"tag", "value"}),
                    hint, tag, several, index,
                    type_doc(case.member.facts, value_note(case.member.unit, case.member.range)),
                )
            )  # fmt: skip
            slot = Slot("value", arm_label, used, False, case.member.range)
            local = LocalNames(LOCAL_WORDS | type_names(lowering, [used]) | {"arm", "value"})
            encode += [
                f'out.append(b"\\1" if arm == {index} else b"\\0")',
                f"if arm == {index}:",
                *indented(lowering.encode(slot, local)),
            ]
            decode += [
                f'if source.arm(arm == {index}, "{arm_label}"):',
                f"    value = {lowering.decode(slot)}",
            ]
        if union.extensibility.value == "appendable":
            decode.append("source.offset = source.end")
        decode.append("return cls(tag, value)")
        if type_reaches(self._model, union.name, union.name):
            decode = [f'source.enter("{union.simple_name}")', *decode]
            decode.insert(-1, "source.leave()")
        fingerprint = lowering.layout.unions[union.name].fingerprint
        return UnionView(
            "union", self._name(union), type_doc(union.facts),
            lowering.hint(union.discriminator), tag_default,
            " | ".join([*hints, "None"]), tuple(arms), tuple(self._select(union)),
            tuple(encode), tuple(decode), f"0x{fingerprint & (1 << 64) - 1:016X}",
            any("_npt." in hint for hint in hints),
            lowering.shape(union.discriminator),
            tuple(lowering.shape(case.member.type) for case in union.cases),
        )  # fmt: skip

    def _decode_tag(
        self, union: Union, node: ScalarNode | EnumNode, code: str, label: str
    ) -> list[str]:
        if isinstance(node, EnumNode):
            slot = Slot("", label, union.discriminator)
            return [f"tag = {self._lowering.decode(slot)}"]
        size = {"i": 4, "q": 8, "Q": 8}[code]
        kind = node.primitive
        lines = [f'number: int = source.number("{code}", "{label}")']
        limits = (0, 1) if kind is Primitive.BOOLEAN else (0, 255)
        if kind.is_integer:
            limits = kind.integer_limits
        if not (kind.is_integer and kind.size == size):
            lines += [
                f"if not {limits[0]} <= number <= {limits[1]}:",
                f'    source.refuse(_wire.DecodeProblem.UNKNOWN_UNION_TAG, "{label}",'
                f" source.offset - {size})",
            ]
        made = {Primitive.BOOLEAN: "number == 1", Primitive.CHAR: "chr(number)"}.get(kind, "number")
        return [*lines, f"tag = {made}"]

    def _select(self, union: Union) -> list[str]:
        lines, otherwise = [], "return 0"
        for index, case in enumerate(union.cases, start=1):
            if case.is_default:
                otherwise = f"return {index}"
                continue
            labels = [self._lowering.literal(v, union.discriminator) for v in case.labels]
            boolean = self._model.target(union.discriminator) == PrimitiveType(Primitive.BOOLEAN)
            if boolean:
                test = " or ".join("tag" if text == "True" else "not tag" for text in labels)
            elif len(labels) == 1:
                test = f"tag == {labels[0]}"
            else:
                test = f"tag in ({', '.join(labels)})"
            lines += [f"if {test}:", f"    return {index}"]
        return [*lines, otherwise]
