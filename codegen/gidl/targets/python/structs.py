"""Builds the views of structs, exceptions and results."""

from __future__ import annotations

from dataclasses import dataclass

from gidl.model import ExceptionStruct, Member, Operation, SequenceType, Struct
from gidl.targets.calls import result_struct
from gidl.targets.groups import call
from gidl.targets.naming import value_note
from gidl.targets.python import names
from gidl.targets.python.layout_steps import renamed, units_of
from gidl.targets.python.name_lookup import ValueNames, may_be_missing, type_doc
from gidl.targets.python.type_text import quoted
from gidl.targets.python.type_views import FieldView, StructView
from gidl.targets.reach import type_reaches
from gidl.wire.wire_layout import FieldLayout
from gidl.wire.wire_nodes import Node


@dataclass(frozen=True, slots=True)
class _Class:
    """A struct, the name of its class, and its members in the order of their encoding."""

    struct: Struct
    name: str
    label: str  # name of the struct in error messages
    members: tuple[Member, ...]
    fields: tuple[FieldLayout, ...]


class Structs(ValueNames):
    def _struct(self, struct: Struct) -> StructView:
        layout = self._layout.structs[struct.name]
        number = f"0x{layout.fingerprint & (1 << 64) - 1:016X}"
        members, name = self._model.all_members(struct), self._name(struct)
        printed = _Class(struct, name, struct.simple_name, members, layout.fields)
        terms = ["open=True"] if struct.is_appendable else []
        if isinstance(struct, ExceptionStruct):
            first = [quoted(struct.name), number]
            return self._view(printed, "exception", first, self._missing(printed) + terms)
        terms += ["deep=True"] if type_reaches(self._model, struct.name, struct.name) else []
        return self._view(printed, "struct", [number], self._missing(printed) + terms)

    def _twin(self, struct: Struct) -> StructView:
        """Returns the view of a class from which a hand-written class gets its layout. The view has
        the members of the struct that maps to the hand-written class."""
        called, members = self._name(struct), self._model.all_members(struct)
        fields = self._layout.structs[struct.name].fields
        label = f"_{struct.simple_name}Layout"
        printed = _Class(struct, f"_{called}Layout", label, members, fields)
        terms = ["open=True"] if struct.is_appendable else []
        return self._view(printed, "twin", [called], self._missing(printed) + terms)

    def _result(self, operation: Operation) -> StructView:
        """Returns the view of the result class of an operation with several results."""
        struct = result_struct(self._layout, operation)
        name = self._layout.python_names.results[operation.scoped_name].name
        fields = self._layout.call(operation.scoped_name).reply
        printed = _Class(struct, name, name, struct.members, fields)
        return self._view(printed, "result", [], self._missing(printed))

    def _missing(self, printed: _Class) -> list[str]:
        """Returns the argument that says how many of the last members an older writer may leave
        out."""
        members, count = printed.members, 0
        while printed.struct.is_appendable and count < len(members):
            if not may_be_missing(members[-1 - count]):
                break
            count += 1
        return [f"missing={count}"] if count else []

    def _view(self, printed: _Class, kind: str, first: list[str], terms: list[str]) -> StructView:
        struct = printed.struct
        nodes = [field.node for field in printed.fields]
        words = names.EXCEPTION_WORDS if kind == "exception" else names.STRUCT_WORDS
        words = self._lowering.words_beside(nodes, words)
        attributes = [names.member_name(m.name, words) for m in printed.members]
        steps = self._lowering.steps(zip(nodes, (m.secret for m in printed.members), strict=True))
        label = [f"label={quoted(printed.label)}"] if printed.label != printed.name else []
        declared = zip(attributes, (m.name for m in printed.members), strict=True)
        shown = printed.members if kind == "exception" else ()
        units = [(member.name, unit_of(member)) for member in shown if not member.secret]
        described = [*first, *steps, *terms, *label, *renamed(declared), *units_of(units)]
        return StructView(
            "struct",
            printed.name,
            kind,
            call(f"_layout.{kind}", *described),
            type_doc(struct.facts),
            tuple(
                self._field(member, attribute, node)
                for member, attribute, node in zip(printed.members, attributes, nodes, strict=True)
            ),
        )

    def _field(self, member: Member, attribute: str, node: Node) -> FieldView:
        default, made = self._lowering.initial(member, node)
        if made:
            default = call("_field", f"default_factory={default}")
        elif default.endswith(")"):
            default = call("_field", f"default={default}")
        note = value_note(member.unit, member.range, getattr(member.type, "bound", None))
        return FieldView(
            attribute, self._lowering.hint(node), default, type_doc(member.facts, note)
        )


def unit_of(member: Member) -> str | None:
    """The unit of a member, or of its elements."""
    used = member.type
    return member.unit or (used.unit if isinstance(used, SequenceType) else None)
