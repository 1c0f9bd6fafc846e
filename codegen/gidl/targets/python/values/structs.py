"""Structs and exceptions."""

from __future__ import annotations

from gidl.model import ExceptionStruct, Member, Operation, Struct
from gidl.targets.calls import result_struct
from gidl.targets.groups import call
from gidl.targets.naming import value_note
from gidl.targets.python import names
from gidl.targets.python.lower import Slot, holds_array
from gidl.targets.python.values.names import ValueNames, type_doc
from gidl.targets.python.values.plan import Class, Plan
from gidl.targets.python.values.views import FieldView, StructView
from gidl.targets.reach import type_reaches
from gidl.wire_layout import FieldLayout
from gidl.wire_nodes import Node


class Structs(ValueNames):
    def _struct(self, struct: Struct) -> StructView:
        layout = self._layout.structs[struct.name]
        members = self._model.all_members(struct)
        label = struct.simple_name
        printed = self._class(struct, members, layout.fields, self._name(struct), label)
        recursive = type_reaches(self._model, struct.name, struct.name)
        return self._view(printed, layout.fingerprint, recursive)

    def _twin(self, struct: Struct) -> StructView:
        """What the declared members look like where a hand-written type has their bytes."""
        fields = self._layout.structs[struct.name].fields
        members = self._model.all_members(struct)
        called = self._name(struct)
        name, label = f"_{called}Layout", f"_{struct.simple_name}Layout"
        return self._view(self._class(struct, members, fields, name, label), stands_for=called)

    def _result(self, operation: Operation) -> StructView:
        """What an operation gives that gives several values."""
        struct = result_struct(self._layout, operation)
        assert struct is not None
        name = self._layout.python_names.results[operation.scoped_name].name
        fields = self._layout.call(operation.scoped_name).reply
        return self._view(self._class(struct, struct.members, fields, name, name))

    def _class(
        self,
        struct: Struct,
        members: tuple[Member, ...],
        fields: tuple[FieldLayout, ...],
        name: str,
        label: str,
    ) -> Class:
        exception = isinstance(struct, ExceptionStruct)
        words = names.EXCEPTION_WORDS if exception else names.STRUCT_WORDS
        words = self._lowering.words_beside([f.node for f in fields], words)
        attributes = tuple(names.member_name(m.name, words) for m in members)
        slots = tuple(
            Slot(f"self.{attribute}", f"{label}.{m.name}", field.node, m.secret)
            for m, field, attribute in zip(members, fields, attributes, strict=True)
        )
        return Class(struct, name, members, attributes, slots)

    def _view(
        self,
        printed: Class,
        fingerprint: int | None = None,  # none for what is no declared type
        recursive: bool = False,
        stands_for: str = "",
    ) -> StructView:
        struct = printed.struct
        is_exception = isinstance(struct, ExceptionStruct)
        arrays = any(holds_array(slot.node) for slot in printed.slots)
        by_hand = is_exception or arrays
        plan = Plan(self._lowering, self._constants, printed)
        each = list(zip(printed.members, printed.attributes, printed.slots, strict=True))
        return StructView(
            "struct",
            printed.name,
            "(_DeclaredError)" if is_exception else "",
            "@_dataclass(slots=True, eq=False)" if by_hand else "@_dataclass(slots=True)",
            struct.name,
            is_exception,
            type_doc(struct.facts),
            tuple(self._field(m, attribute, slot.node) for m, attribute, slot in each),
            tuple(plan.run_views()),
            tuple(plan.encode_body()),
            tuple(plan.decode_body(recursive)),
            "" if fingerprint is None else f"0x{fingerprint & (1 << 64) - 1:016X}",
            tuple(_comparisons(printed)) if arrays and not is_exception else (),
            tuple(
                self._lowering.member_shape(m.name, attribute, slot.node, m.secret)
                for m, attribute, slot in each
            ),
            "" if fingerprint is None else self._plan(struct, plan.missing),
            stands_for,
        )

    def _plan(self, struct: Struct, missing: int) -> str:
        steps = self._lowering.plan(struct)
        if steps is None:
            return ""
        rest = [f"missing={missing}"] if missing else []
        rest += ["open=True"] if struct.is_appendable else []
        return call("@_plans.planned", *steps, *rest)

    def _field(self, member: Member, attribute: str, node: Node) -> FieldView:
        default, made = self._lowering.initial(member, node)
        if member.secret:
            kind = "default_factory" if made else "default"
            default = call("_field", f"{kind}={default}", "repr=False")
        elif made:
            default = call("_field", f"default_factory={default}")
        elif default.endswith(")"):
            default = call("_field", f"default={default}")
        note = value_note(member.unit, member.range, getattr(member.type, "bound", None))
        return FieldView(
            attribute, self._lowering.hint(node), default, type_doc(member.facts, note)
        )


def _comparisons(printed: Class) -> list[str]:
    lines = []
    for name, slot in zip(printed.attributes, printed.slots, strict=True):
        if holds_array(slot.node):
            lines.append(f"_wire.same(self.{name}, other.{name})")
        else:
            lines.append(f"self.{name} == other.{name}")
    return lines
