"""Structs and exceptions."""

from __future__ import annotations

from dataclasses import replace

from gidl.model import (
    ExceptionStruct,
    Member,
    Struct,
)
from gidl.targets.naming import value_note
from gidl.targets.python import names
from gidl.targets.python.lower import Slot
from gidl.targets.python.values.names import (
    ValueNames,
    type_doc,
)
from gidl.targets.python.values.plan import Plan
from gidl.targets.python.values.views import (
    FieldView,
    StructView,
)
from gidl.targets.reach import type_reaches


class Structs(ValueNames):
    def _struct(self, struct: Struct, stands_for: str = "") -> StructView:
        members = self._model.all_members(struct)
        is_exception = isinstance(struct, ExceptionStruct)
        words = self._lowering.words(struct)
        slots = [
            Slot(f"self.{names.member_name(m.name, words)}", f"{struct.simple_name}.{m.name}",
                 m.type, m.optional, m.range)
            for m in members
        ]  # fmt: skip
        arrays = any(self._lowering.holds_array(m.type) for m in members)
        known = self._model.has(struct.name)
        layout = self._lowering.layout.structs.get(struct.name)
        plan = Plan(
            self._lowering, self._constants, struct, members, slots, self._name(struct), words
        )
        by_hand = is_exception or arrays
        return StructView(
            "struct",
            self._name(struct),
            "(_DeclaredError)" if is_exception else "",
            "@_dataclass(slots=True, eq=False)" if by_hand else "@_dataclass(slots=True)",
            struct.name,
            is_exception,
            type_doc(struct.facts),
            tuple(self._field(m, words) for m in members),
            tuple(plan.run_views()),
            tuple(plan.encode_body()),
            tuple(plan.decode_body(known and type_reaches(self._model, struct.name, struct.name))),
            "" if layout is None else f"0x{layout.fingerprint & (1 << 64) - 1:016X}",
            tuple(self._comparisons(members, words)) if arrays and not is_exception else (),
            tuple(self._member_shape(m, words) for m in members),
            self._plan(struct, plan.missing),
            stands_for,
        )

    def _plan(self, struct: Struct, missing: int) -> str:
        steps = self._lowering.plan(struct)
        if steps is None:
            return ""
        rest = [f"missing={missing}"] if missing else []
        return ", ".join([*steps, *rest, *(["open=True"] if struct.is_appendable else [])])

    def _twin(self, struct: Struct, mapped: str) -> StructView:
        """What the declared members look like where a hand-written type has their bytes."""
        bare = replace(struct, name=f"_{struct.simple_name}Layout", maps_to=None)
        return self._struct(bare, mapped)

    def _member_shape(self, member: Member, words: frozenset[str]) -> str:
        shape = self._lowering.shape(member.type, member.optional)
        name = names.member_name(member.name, words)
        attribute = f', attribute="{name}"' if name != member.name else ""
        secret = ", secret=True" if member.secret else ""
        return f'_shapes.Member("{member.name}", {shape}{attribute}{secret})'

    def _comparisons(self, members: tuple[Member, ...], words: frozenset[str]) -> list[str]:
        lines = []
        for m in members:
            name = names.member_name(m.name, words)
            if self._lowering.holds_array(m.type):
                lines.append(f"_wire.same(self.{name}, other.{name})")
            else:
                lines.append(f"self.{name} == other.{name}")
        return lines

    def _field(self, member: Member, words: frozenset[str]) -> FieldView:
        default, made = self._lowering.initial(member)
        if member.secret:
            kind = "default_factory" if made else "default"
            default = f"_field({kind}={default}, repr=False)"
        elif made:
            default = f"_field(default_factory={default})"
        elif default.endswith(")"):
            default = f"_field(default={default})"
        note = value_note(member.unit, member.range, getattr(member.type, "bound", None))
        return FieldView(
            names.member_name(member.name, words),
            self._lowering.hint(member.type, member.optional),
            default,
            type_doc(member.facts, note),
        )
