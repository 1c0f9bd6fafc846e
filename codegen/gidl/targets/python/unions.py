"""Builds the views of unions: their arms and layout steps."""

from __future__ import annotations

from gidl.model import Union, UnionCase
from gidl.targets.groups import call
from gidl.targets.naming import LocalNames, value_note
from gidl.targets.python import names
from gidl.targets.python.name_lookup import ValueNames, type_doc
from gidl.targets.python.type_text import quoted
from gidl.targets.python.type_views import ArmView, UnionView
from gidl.targets.reach import type_reaches
from gidl.wire.wire_layout import FieldLayout, UnionLayout


class Unions(ValueNames):
    def _union(self, union: Union) -> UnionView:
        lowering = self._lowering
        layout = self._layout.unions[union.name]
        tag_default, _ = lowering.zero(layout.tag)
        hints: list[str] = []
        for arm in layout.arms:
            hints += [h for h in lowering.hint(arm.node).split(" | ") if h not in hints]
        name = self._name(union)
        described = [
            f"0x{layout.fingerprint & (1 << 64) - 1:016X}",
            lowering.step(layout.tag),
            *(
                self._arm_step(case, arm, layout)
                for case, arm in zip(union.cases, layout.arms, strict=True)
            ),
            *(["open=True"] if layout.appendable else []),
            *(["deep=True"] if type_reaches(self._model, union.name, union.name) else []),
            *([f"label={quoted(union.simple_name)}"] if union.simple_name != name else []),
        ]
        return UnionView(
            "union",
            name,
            call("_layout.union", *described),
            type_doc(union.facts),
            lowering.hint(layout.tag),
            tag_default,
            " | ".join([*hints, "None"]),
            tuple(self._arms(union, layout)),
        )

    def _arm_step(self, case: UnionCase, arm: FieldLayout, layout: UnionLayout) -> str:
        """Returns the layout step of an arm. A step that lists no tags is the step of the default
        arm. Every tag that no other arm lists selects the default arm."""
        labels = () if case.is_default else case.labels
        tags = [self._lowering.literal(value, layout.tag) for value in labels]
        step = self._lowering.step(arm.node, case.member.secret)
        return call("_layout.arm", quoted(arm.name), step, *tags)

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
