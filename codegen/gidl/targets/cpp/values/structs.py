"""Structs and exceptions: their members and the bodies of their codecs."""

from __future__ import annotations

from dataclasses import replace

from gidl.model import (
    ExceptionStruct,
    Member,
    Struct,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.lower import Lowering, Slot
from gidl.targets.cpp.lower.statements import conjunction, joined_puts, or_at_end
from gidl.targets.cpp.values.names import ValueNames
from gidl.targets.cpp.values.views import (
    CodecView,
    FieldView,
    PrintView,
    StructView,
    bound_of,
    separated,
    unit_of,
)
from gidl.targets.naming import (
    LocalNames,
    doc_lines,
    value_note,
)
from gidl.targets.reach import type_reaches


class Structs(ValueNames):
    def _struct(self, struct: Struct) -> StructView:
        layout = self._layout.structs.get(struct.name)
        base = ""
        if struct.base is not None:
            base = f" : {names.full_name(self._model, struct.base)}"
        fingerprint = f"0x{layout.fingerprint & (1 << 64) - 1:016x}" if layout else ""
        members = self._model.all_members(struct)
        return StructView(
            "struct",
            self._name(struct),
            struct.name,
            doc_lines(struct.facts, "exception" if isinstance(struct, ExceptionStruct) else ""),
            base,
            tuple(self._field(m) for m in struct.members),
            fingerprint,
            self._struct_codec(struct, members),
            separated([self._print(m) for m in members]),
        )

    def _field(self, member: Member) -> FieldView:
        note = [
            value_note(member.unit or unit_of(member.type), member.range, bound_of(member.type))
        ]
        if member.optional:
            note.append("optional")
        return FieldView(
            self._lowering.type(member.type, member.optional),
            names.member_name(member.name),
            self._lowering.initial(member),
            doc_lines(member.facts, ", ".join(n for n in note if n)),
        )

    def _print(self, member: Member) -> PrintView:
        value = "" if member.secret else names.member_name(member.name)
        unit = f" {member.unit}" if member.unit and not member.secret else ""
        return PrintView(f"{member.name}=", value, unit)

    def _struct_codec(self, struct: Struct, members: tuple[Member, ...]) -> CodecView:
        lowering = self._lowering
        taken = {names.member_name(m.name) for m in members}
        slots = [
            Slot(
                names.member_name(m.name),
                f"{struct.simple_name}.{m.name}",
                m.type,
                m.optional,
                m.range,
            )
            for m in members
        ]
        local = LocalNames(taken)
        writer, reader = local.fresh("to"), local.fresh("from")
        encode = [
            line for s in slots for line in lowering.encode(s, writer, LocalNames(taken | {writer}))
        ]
        return CodecView(
            writer if encode else "",
            reader,
            tuple(self._size_body(slots, taken)),
            tuple(joined_puts(encode, writer)),
            tuple(self._decode_body(struct, members, slots, reader, taken)),
            tuple(self._check_body(slots)) if lowering.struct_has_checks(struct) else (),
        )

    def _size_body(self, slots: list[Slot], taken: set[str]) -> list[str]:
        total = LocalNames(taken).fresh("size")
        constant, lines = 0, []
        for slot in slots:
            always, more = self._lowering.size(slot, total, LocalNames(taken | {total}))
            constant += always
            lines += more
        if not lines:
            return [f"return {constant};"]
        return [f"std::size_t {total} = {constant};", *lines, f"return {total};"]

    def _decode_body(
        self,
        struct: Struct,
        members: tuple[Member, ...],
        slots: list[Slot],
        reader: str,
        taken: set[str],
    ) -> list[str]:
        required = len(members)
        if struct.is_appendable:
            while required and _may_be_missing(members[required - 1]):
                required -= 1
        terms = []
        for i, slot in enumerate(slots):
            lines = self._lowering.decode(slot, reader, LocalNames(taken | {reader}))
            if i >= required:
                lines = or_at_end(reader, lines)
            terms.append(lines)
        if struct.is_appendable:
            terms.append([f"gecos::wire::skip_rest({reader})"])
        body = conjunction(terms)
        reset = [
            f"{slot.expression} = {missing_value(self._lowering, member)};"
            for slot, member in list(zip(slots, members, strict=True))[required:]
        ]
        if self._model.has(struct.name) and type_reaches(self._model, struct.name, struct.name):
            guard = LocalNames(taken | {reader}).fresh("guard")
            reset[0:0] = [
                f'const gecos::wire::DepthGuard {guard}({reader}, "{struct.simple_name}");',
                f"if (!{guard}) return false;",
            ]
        return [*reset, *body]

    def _check_body(self, slots: list[Slot]) -> list[str]:
        lines: list[str] = []
        for slot in slots:
            there = replace(slot, expression=f"value.{slot.expression}")
            lines += self._lowering.check(there, LocalNames({"value"}))
        return [*lines, "return {};"]


def _may_be_missing(member: Member) -> bool:
    return member.optional or member.default is not None


def missing_value(lowering: Lowering, member: Member) -> str:
    """What an older writer's absent member becomes."""
    if member.optional:
        return "std::nullopt"
    assert member.default is not None
    return lowering.literal(member.default, member.type)
