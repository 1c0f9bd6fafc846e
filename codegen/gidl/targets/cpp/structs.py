"""Builds the views of structs and exceptions: their members and the bodies of their codecs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gidl.model import (
    ExceptionStruct,
    Interface,
    Member,
    Operation,
    Struct,
)
from gidl.model.bulk import are_octets
from gidl.names.type_names import TypeName
from gidl.targets.calls import result_struct
from gidl.targets.cpp import names
from gidl.targets.cpp.comments import doc_lines
from gidl.targets.cpp.definition_order import held
from gidl.targets.cpp.lowering import Lowering
from gidl.targets.cpp.name_lookup import ValueNames
from gidl.targets.cpp.statements import conjunction, joined_puts, or_at_end
from gidl.targets.cpp.type_text import Slot
from gidl.targets.cpp.type_views import (
    CodecView,
    FieldView,
    PrintView,
    StructView,
    bound_of,
    printed,
    unit_of,
)
from gidl.targets.groups import call
from gidl.targets.naming import (
    value_note,
)
from gidl.targets.reach import type_reaches
from gidl.wire.wire_layout import FieldLayout
from gidl.wire.wire_nodes import ScalarNode


@dataclass(frozen=True, slots=True)
class Content:
    """The members that a codec encodes and decodes, with their wire fields."""

    owner: str  # name of the struct or operation in error messages
    members: tuple[Member, ...]  # members of bases come first
    fields: tuple[FieldLayout, ...]
    appendable: bool
    recursive: bool


class Structs(ValueNames):
    def _struct(self, struct: Struct, incomplete: frozenset[str] = frozenset()) -> StructView:
        layout = self._layout.structs[struct.name]
        base = ""
        if struct.base is not None:
            base = f" : {self._lowering.named(struct.base)}"
        content = Content(
            struct.simple_name,
            self._model.all_members(struct),
            layout.fields,
            layout.appendable,
            type_reaches(self._model, struct.name, struct.name),
        )
        return StructView(
            "struct",
            self._name(struct),
            struct.name,
            doc_lines(struct.facts, "exception" if isinstance(struct, ExceptionStruct) else ""),
            base,
            tuple(self._field(m, incomplete) for m in struct.members),
            f"0x{layout.fingerprint & (1 << 64) - 1:016x}",
            self._struct_codec(content),
            printed(
                self._name(struct),
                [self._print(m) for m in content.members],
                _mistaken_unit(content) if isinstance(struct, ExceptionStruct) else "",
            ),
        )

    def results_of(self, interface: Interface) -> Iterator[tuple[TypeName, StructView]]:
        """Yields the name and the view of the struct of results, for each operation of `interface`
        that has several results."""
        for operation in interface.operations:
            if len(self._layout.call(operation.scoped_name).reply) > 1:
                yield self._result(operation)

    def _result(self, operation: Operation) -> tuple[TypeName, StructView]:
        place = self._layout.cpp_names.results[operation.scoped_name]
        struct = result_struct(self._layout, operation)
        fields = self._layout.call(operation.scoped_name).reply
        return place, StructView(
            "struct",
            place.name,
            struct.name,
            doc_lines(struct.facts),
            "",
            tuple(self._field(m) for m in struct.members),
            "",
            self._struct_codec(Content(operation.name, struct.members, fields, True, False)),
            printed(place.name, [self._print(m) for m in struct.members]),
        )

    def _field(self, member: Member, incomplete: frozenset[str] = frozenset()) -> FieldView:
        note = [
            value_note(member.unit or unit_of(member.type), member.range, bound_of(member.type))
        ]
        if member.optional:
            note.append("optional")
        return FieldView(
            self._lowering.type(member.type, member.optional),
            names.member_name(member.name),
            "" if held(self._model, member.type) & incomplete else self._lowering.initial(member),
            doc_lines(member.facts, ", ".join(n for n in note if n)),
        )

    def _print(self, member: Member) -> PrintView:
        value = "" if member.secret else names.member_name(member.name)
        unit = f" {member.unit}" if member.unit and not member.secret else ""
        return PrintView(f"{member.name}=", value, unit)

    def _struct_codec(self, content: Content) -> CodecView:
        lowering = self._lowering
        slots = [
            Slot(
                names.member_name(m.name),
                f"{content.owner}.{m.name}",
                field.node,
                m.bulk and are_octets(self._model, m),
            )
            for m, field in zip(content.members, content.fields, strict=True)
        ]
        taken = {slot.expression for slot in slots}
        local = names.Locals(taken)
        writer, reader = local.fresh("to"), local.fresh("from")
        encode = [
            line
            for s in slots
            for line in lowering.encode(s, writer, names.Locals(taken | {writer}))
        ]
        return CodecView(
            writer if encode else "",
            reader,
            tuple(self._size_body(slots, taken)),
            tuple(joined_puts(encode, writer)),
            tuple(self._decode_body(content, slots, reader, taken)),
            tuple(self._check_body(slots)) if lowering.have_checks(content.fields) else (),
        )

    def _size_body(self, slots: list[Slot], taken: set[str]) -> list[str]:
        total = names.Locals(taken).fresh("size")
        statements, whole = self._lowering.whole_size(slots, total, taken)
        return [*statements, f"return {whole};"]

    def _decode_body(
        self, content: Content, slots: list[Slot], reader: str, taken: set[str]
    ) -> list[str]:
        members = content.members
        required = len(members)
        if content.appendable:
            while required and _may_be_missing(members[required - 1]):
                required -= 1
        terms = []
        for i, slot in enumerate(slots):
            lines = self._lowering.decode(slot, reader, names.Locals(taken | {reader}))
            if i >= required:
                lines = or_at_end(reader, lines)
            terms.append(lines)
        if content.appendable:
            terms.append([f"gecos::wire::skip_rest({reader})"])
        body = conjunction(terms)
        reset = [
            f"{slot.expression} = {missing_value(self._lowering, member)};"
            for slot, member in list(zip(slots, members, strict=True))[required:]
        ]
        if content.recursive:
            guard = names.Locals(taken | {reader}).fresh("guard")
            reset[0:0] = [
                f'const gecos::wire::DepthGuard {guard}({reader}, "{content.owner}");',
                f"if (!{guard}) return false;",
            ]
        return [*reset, *body]

    def _check_body(self, slots: list[Slot]) -> list[str]:
        lines: list[str] = []
        for slot in slots:
            there = replace(slot, expression=f"value.{slot.expression}")
            lines += self._lowering.check(there, names.Locals({"value"}))
        return [*lines, "return {};"]


def _may_be_missing(member: Member) -> bool:
    return member.optional or member.default is not None


def missing_value(lowering: Lowering, member: Member) -> str:
    """Returns the C++ value that a member gets if an older writer has not sent this member."""
    if member.optional:
        return "std::nullopt"
    assert member.default is not None
    return lowering.literal(member.default, member.type)


def _mistaken_unit(content: Content) -> str:
    """Returns the C++ text of a call of gecos::wire::mistaken_unit, for an exception whose members
    `value`, `lower` and `upper` are numbers with units. Returns an empty text for other exceptions.
    In a running program, the call returns a question such as "is the value in degrees?", which the
    generated code appends to the text of the exception. If an optional member of the exception has
    a value, the object computed `value` itself. The generated code then appends no question,
    because nobody has entered `value` in another unit."""
    found = {m.name: (m, f.node) for m, f in zip(content.members, content.fields, strict=True)}
    wanted = ("value", "lower", "upper")
    members, nodes = zip(*(found.get(name, (None, None)) for name in wanted), strict=True)
    number = all(isinstance(node, ScalarNode) and node.primitive.is_number for node in nodes)
    if not number or not all(member.unit for member in members):
        return ""
    values = [f"value.{name}" for name in wanted]
    question = call("gecos::wire::mistaken_unit", *values, f'"{members[0].unit}"')
    optional = [f"value.{names.member_name(m.name)}" for m in content.members if m.optional]
    return f"{' || '.join(optional)} ? std::string_view() : {question}" if optional else question
