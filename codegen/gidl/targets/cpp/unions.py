"""Builds the views of unions: their arms and the bodies of their codecs."""

from __future__ import annotations

from dataclasses import replace

from gidl.model import (
    Member,
    Primitive,
    PrimitiveType,
    Union,
)
from gidl.names.languages import CPP_UNION_WORDS
from gidl.names.type_names import escaped
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.name_lookup import ValueNames
from gidl.targets.cpp.names import Locals
from gidl.targets.cpp.statements import block, conjunction, returning
from gidl.targets.cpp.type_text import PRIMITIVES, Slot
from gidl.targets.cpp.type_views import ArmView, CodecView, UnionView, bound_of
from gidl.targets.groups import group
from gidl.targets.naming import (
    value_note,
)
from gidl.targets.reach import type_reaches
from gidl.wire.wire_nodes import EnumNode, ScalarNode


class Unions(ValueNames):
    def _union(self, union: Union) -> UnionView:
        lowering = self._lowering
        tag_type = lowering.type(union.discriminator)
        arms = []
        for index, case in enumerate(union.cases):
            several = len(case.labels) != 1 or case.is_default
            label = lowering.literal(case.labels[0], union.discriminator) if case.labels else ""
            arms.append(
                ArmView(
                    escaped(case.member.name, CPP_UNION_WORDS),
                    lowering.type(case.member.type),
                    lowering.parameter(case.member.type),
                    index + 1,
                    label,
                    several,
                    case.member.secret,
                    doc_lines(
                        case.member.facts,
                        value_note(case.member.unit, case.member.range, bound_of(case.member.type)),
                    ),
                )
            )
        layout = self._layout.unions[union.name]
        initial = self._initial_tag(union)
        return UnionView(
            "union",
            self._name(union),
            union.name,
            doc_lines(union.facts),
            tag_type,
            initial,
            "std::variant" + group(["std::monostate", *(a.type for a in arms)], "<", ">"),
            tuple(arms),
            " || ".join(f"arm == {a.index}" for a in arms if a.secret),
            tuple(self._select(union)),
            f"0x{layout.fingerprint & 0xFFFFFFFFFFFFFFFF:016x}",
            self._union_codec(union, arms),
        )

    def _initial_tag(self, union: Union) -> str:
        dummy = Member("tag", union.discriminator, union.facts)
        return self._lowering.initial(dummy)

    def _select(self, union: Union) -> list[str]:
        """Returns C++ statements that return the number of the arm that `tag` selects, counted from
        1, or 0 if `tag` selects no arm. The number is the index of the arm in the std::variant."""
        boolean = self._model.target(union.discriminator) == PrimitiveType(Primitive.BOOLEAN)
        lines, otherwise = [], "return 0;"
        for index, case in enumerate(union.cases):
            if case.is_default:
                otherwise = f"return {index + 1};"
            labels = [self._lowering.literal(v, union.discriminator) for v in case.labels]
            if labels and not case.is_default:
                if boolean:
                    test = " || ".join("tag" if label == "true" else "!tag" for label in labels)
                else:
                    test = " || ".join(f"tag == {label}" for label in labels)
                lines.append(f"if ({test}) return {index + 1};")
        return [*lines, otherwise]

    def _union_codec(self, union: Union, arms: list[ArmView]) -> CodecView:
        lowering = self._lowering
        layout = self._layout.unions[union.name]
        tag_node, wire_type = layout.tag, PRIMITIVES[layout.wire_tag]
        total = layout.wire_tag.size + len(arms)
        size: list[str] = []
        check: list[str] = []
        char = isinstance(tag_node, ScalarNode) and tag_node.primitive is Primitive.CHAR
        number = "static_cast<unsigned char>(tag)" if char else "tag"
        encode = [f"to.put(static_cast<{wire_type}>({number}));"]
        tag_label = f"{union.simple_name}.tag"
        terms = [self._decode_tag(tag_node, tag_label, wire_type)]
        check.append(f"if (value.value.index() != {self._name(union)}::gecos_arm(value.tag)) {{")
        check.append(f'  return gecos::wire::wrong_arm("{union.simple_name}");')
        check.append("}")
        for arm, field in zip(arms, layout.arms, strict=True):
            held = f"std::get<{arm.index}>(value)"
            label = f"{union.simple_name}.{field.name}"
            slot = Slot("arm", label, field.node)
            always, more = lowering.size(slot, "size", Locals({"size", "arm"}))
            inner = [f"size += {always};"] if always else []
            if more:
                inner = [*inner, f"const auto& arm = {held};", *more]
            if inner:
                size += block(f"if (value.index() == {arm.index})", inner)
            encode.append(f"to.put(value.index() == {arm.index});")
            writes = lowering.encode(slot, "to", Locals({"to", "arm"}))
            encode += block(
                f"if (value.index() == {arm.index})", [f"const auto& arm = {held};", *writes]
            )
            reads = lowering.decode(slot, "from", Locals({"from", "arm"}))
            there = f'gecos::wire::get_arm(from, gecos_arm(tag) == {arm.index}, "{label}")'
            if_there = [f"({there} &&", f" (gecos_arm(tag) != {arm.index} ||"]
            lambda_lines = [
                "  [&](auto& arm) {",
                *(f"    {x}" for x in returning(reads)),
                f"  }}(value.emplace<{arm.index}>())))",
            ]
            terms.append([*if_there, *lambda_lines])
            checks = lowering.check(replace(slot, expression="arm"), Locals({"arm", "value"}))
            if checks:
                check += block(
                    f"if (value.value.index() == {arm.index})",
                    [f"const auto& arm = std::get<{arm.index}>(value.value);", *checks],
                )
        if union.extensibility.value == "appendable":
            terms.append(["gecos::wire::skip_rest(from)"])
        size_body = [f"std::size_t size = {total};", *size, "return size;"]
        decode = ["value = std::monostate{};", *conjunction(terms)]
        if type_reaches(self._model, union.name, union.name):
            decode[0:0] = [
                f'const gecos::wire::DepthGuard guard(from, "{union.simple_name}");',
                "if (!guard) return false;",
            ]
        return CodecView(
            "to", "from", tuple(size_body), tuple(encode), tuple(decode), (*check, "return {};")
        )

    def _decode_tag(self, tag: ScalarNode | EnumNode, label: str, wire_type: str) -> list[str]:
        if isinstance(tag, EnumNode):
            return [f'{self._lowering.function(tag.name, "decode_enum")}(from, tag, "{label}")']
        return [f'gecos::wire::get_tag<{wire_type}>(from, tag, "{label}")']
