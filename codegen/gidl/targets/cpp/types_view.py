"""What the templates of `<file>_types.{hpp,cpp}` print."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    ExceptionStruct,
    File,
    Interface,
    Member,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Type,
    Typedef,
    Union,
)
from gidl.targets.cpp import names
from gidl.targets.cpp.lower import PRIMITIVES, Lowering, Slot, block
from gidl.targets.naming import (
    LocalNames,
    doc_lines,
    escaped,
    has_output,
    source_stem,
    value_note,
)
from gidl.targets.reach import named_types, type_reaches
from gidl.wire_layout import node_of, wire_tag_of
from gidl.wire_nodes import EnumNode, ScalarNode


@dataclass(frozen=True, slots=True)
class EnumeratorView:
    name: str
    value: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EnumView:
    kind: str  # "enum"
    name: str
    doc: tuple[str, ...]
    underlying: str
    enumerators: tuple[EnumeratorView, ...]
    unknown: str  # what an unknown number becomes; "" refuses it
    words: tuple[tuple[str, str], ...]  # enumerator, its IDL name


@dataclass(frozen=True, slots=True)
class MaskView:
    kind: str  # "mask"
    name: str
    doc: tuple[str, ...]
    underlying: str
    wire: str
    flags: tuple[EnumeratorView, ...]
    all_bits: str  # bits that may be set


@dataclass(frozen=True, slots=True)
class BitsView:
    kind: str  # "bits"
    name: str
    doc: tuple[str, ...]
    wire: str
    unsigned: str
    fields: tuple[FieldView, ...]
    pack: tuple[str, ...]
    unpack: tuple[str, ...]
    check: tuple[str, ...]
    prints: tuple[PrintView, ...]


@dataclass(frozen=True, slots=True)
class FieldView:
    type: str
    name: str
    initial: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PrintView:
    label: str  # "speed="
    value: str  # expression; "" for a secret
    unit: str  # " m", or ""


@dataclass(frozen=True, slots=True)
class CodecView:
    """Bodies of the functions that every struct and union has."""

    writer: str  # name of the encoder parameter; "" where nothing is written
    reader: str
    size: tuple[str, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    check: tuple[str, ...]  # empty: every value may be sent


@dataclass(frozen=True, slots=True)
class StructView:
    kind: str  # "struct"
    name: str
    type_name: str
    doc: tuple[str, ...]
    base: str  # ": Base" or ""
    fields: tuple[FieldView, ...]
    fingerprint: str  # "" for what is no declared type
    codec: CodecView
    prints: tuple[PrintView, ...]


@dataclass(frozen=True, slots=True)
class ArmView:
    name: str
    type: str
    argument: str
    index: int
    tag: str  # the label that selects it when none is named
    several: bool  # more than one label selects it: the maker takes the tag
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnionView:
    kind: str  # "union"
    name: str
    type_name: str
    doc: tuple[str, ...]
    tag_type: str
    tag_initial: str
    value_type: str
    arms: tuple[ArmView, ...]
    select: tuple[str, ...]  # body of the function from tag to index of the variant
    fingerprint: str
    codec: CodecView


@dataclass(frozen=True, slots=True)
class AliasView:
    kind: str  # "alias"
    name: str
    doc: tuple[str, ...]
    type: str


@dataclass(frozen=True, slots=True)
class ConstantView:
    kind: str  # "constant"
    name: str
    doc: tuple[str, ...]
    type: str
    value: str


@dataclass(frozen=True, slots=True)
class MappedView:
    kind: str  # "mapped"
    name: str
    header: str


TypeView = (
    EnumView | MaskView | BitsView | StructView | UnionView | AliasView | ConstantView | MappedView
)


@dataclass(frozen=True, slots=True)
class NamespaceView:
    name: str  # "robcl"; "" at the top
    forward: tuple[str, ...]  # structs that are used before they are declared
    types: tuple[TypeView, ...]


@dataclass(frozen=True, slots=True)
class TypesView:
    source: str  # "robcl/geometry.gidl"
    header: str  # "robcl/geometry_types.hpp"
    system_includes: tuple[str, ...]
    includes: tuple[str, ...]
    namespaces: tuple[NamespaceView, ...]


def types_view(lowering: Lowering, file: File, extra: tuple[Struct, ...]) -> TypesView:
    """`extra` are structs that calls need and nobody declared (results of several values)."""
    builder = _Builder(lowering)
    declarations = (*file.declarations, *extra)
    stem = source_stem(file.path)
    includes = {
        f"{source_stem(path)}_types.hpp"
        for path in file.includes
        if has_output(lowering.model, path)
    }
    for declaration in declarations:
        if isinstance(declaration, Struct) and declaration.maps_to and declaration.maps_to.cpp:
            includes.add(declaration.maps_to.cpp[1])
    return TypesView(
        file.path,
        f"{stem}_types.hpp",
        _system_includes(lowering, declarations),
        tuple(sorted(includes)),
        tuple(builder.namespaces(declarations)),
    )


def _system_includes(
    lowering: Lowering, declarations: tuple[AnyDeclaration, ...]
) -> tuple[str, ...]:
    found = {"cstddef", "cstdint", "iosfwd", "string", "string_view"}

    def visit(used: Type, optional: bool = False) -> None:
        text = lowering.type(used, optional)
        for word, header in (("array", "array"), ("vector", "vector"), ("map", "map")):
            if f"std::{word}<" in text:
                found.add(header)
        if optional:
            found.add("optional")

    for declaration in declarations:
        match declaration:
            case Struct():
                for member in declaration.members:
                    visit(member.type, member.optional)
            case Union():
                found.add("variant")
                for case in declaration.cases:
                    visit(case.member.type)
            case Typedef(type=target):
                visit(target)
            case _:
                pass
    if "numeric_limits" in "".join(_literals(lowering, declarations)):
        found.add("limits")
    return tuple(sorted(found))


def _literals(lowering: Lowering, declarations: tuple[AnyDeclaration, ...]) -> Iterator[str]:
    for declaration in declarations:
        if isinstance(declaration, Constant):
            yield lowering.literal(declaration.value, declaration.type)
        elif isinstance(declaration, Struct):
            for member in declaration.members:
                yield lowering.initial(member)


class _Builder:
    def __init__(self, lowering: Lowering) -> None:
        self._lowering = lowering
        self._model = lowering.model
        self._layout = lowering.layout

    def namespaces(self, declarations: tuple[AnyDeclaration, ...]) -> Iterator[NamespaceView]:
        """Runs of declarations of one module."""
        run: list[AnyDeclaration] = []
        for declaration in declarations:
            if isinstance(declaration, Interface) or self._view_kind(declaration) is None:
                continue
            if run and self._scope(run[-1]) != self._scope(declaration):
                yield self._namespace(run)
                run = []
            run.append(declaration)
        if run:
            yield self._namespace(run)

    def _scope(self, declaration: AnyDeclaration) -> str:
        return "::".join(names.scope_of(self._model, declaration.name))

    @staticmethod
    def _view_kind(declaration: AnyDeclaration) -> type | None:
        known = Struct | EnumDeclaration | Bitmask | Bitset | Union | Typedef | Constant
        return type(declaration) if isinstance(declaration, known) else None

    def _namespace(self, run: list[AnyDeclaration]) -> NamespaceView:
        forward = []
        seen: set[str] = set()
        for declaration in run:
            if isinstance(declaration, Struct | Union | Typedef):
                used = self._named_types(declaration)
                forward += [
                    name for name in sorted(used) if name not in seen and name not in forward
                ]
            seen.add(declaration.name)
        local = {d.name for d in run if isinstance(d, Struct | Union)}
        simple = tuple(names.simple_name(self._model, n) for n in forward if n in local)
        return NamespaceView(self._scope(run[0]), simple, tuple(self._type(d) for d in run))

    @staticmethod
    def _named_types(declaration: Struct | Union | Typedef) -> set[str]:
        match declaration:
            case Struct():
                used = [m.type for m in declaration.members]
            case Union():
                used = [case.member.type for case in declaration.cases]
            case Typedef():
                used = [declaration.type]
        return {name for each in used for name in named_types(each)} - {declaration.name}

    def _type(self, declaration: AnyDeclaration) -> TypeView:
        match declaration:
            case EnumDeclaration():
                return self._enum(declaration)
            case Bitmask():
                return self._mask(declaration)
            case Bitset():
                return self._bits(declaration)
            case Struct(maps_to=maps_to) if maps_to is not None and maps_to.cpp is not None:
                return MappedView("mapped", *maps_to.cpp)
            case Struct():
                return self._struct(declaration)
            case Union():
                return self._union(declaration)
            case Typedef():
                note = value_note(declaration.unit, declaration.range)
                return AliasView(
                    "alias",
                    self._name(declaration),
                    doc_lines(declaration.facts, note),
                    self._lowering.type(declaration.type),
                )
            case Constant():
                return self._constant(declaration)
            case _:
                raise AssertionError(declaration)

    def _name(self, declaration: AnyDeclaration) -> str:
        return names.simple_name(self._model, declaration.name)

    def _constant(self, constant: Constant) -> ConstantView:
        target = self._model.target(constant.type)
        text = isinstance(target, StringType)
        return ConstantView(
            "constant",
            self._name(constant),
            doc_lines(constant.facts, value_note(constant.unit, None)),
            "std::string_view" if text else self._lowering.type(constant.type),
            self._lowering.literal(constant.value, constant.type),
        )

    def _enum(self, enum: EnumDeclaration) -> EnumView:
        def word(name: str) -> str:
            return escaped(name, names.KEYWORDS)

        return EnumView(
            "enum",
            self._name(enum),
            doc_lines(enum.facts),
            "std::int32_t",
            tuple(
                EnumeratorView(word(e.name), str(e.number), doc_lines(e.facts))
                for e in enum.enumerators
            ),
            "" if enum.default_literal is None else word(enum.default_literal),
            tuple((word(e.name), e.name) for e in enum.enumerators),
        )

    def _mask(self, mask: Bitmask) -> MaskView:
        bits = 64 if mask.bit_bound > 32 else 32
        return MaskView(
            "mask",
            self._name(mask),
            doc_lines(mask.facts),
            f"std::uint{bits}_t",
            f"std::int{bits}_t",
            tuple(
                EnumeratorView(
                    escaped(f.name, names.KEYWORDS),
                    f"std::uint{bits}_t{{1}} << {f.position}",
                    doc_lines(f.facts),
                )
                for f in mask.flags
            ),
            f"0x{(1 << mask.bit_bound) - 1:x}U",
        )

    def _bits(self, bitset: Bitset) -> BitsView:
        wide = bitset.bit_size > 32
        unsigned = "std::uint64_t" if wide else "std::uint32_t"
        fields, pack, unpack, check, prints = [], [], [], [], []
        used = 0
        for field in self._model.all_fields(bitset):
            if field.name is None:
                continue
            name = escaped(field.name, names.STRUCT_WORDS | {"bits", "set_bits"})
            kind = field.type.kind
            mask = (1 << field.width) - 1
            used |= mask << field.position
            initial = " = false" if kind is Primitive.BOOLEAN else " = 0"
            doc = doc_lines(field.facts, f"{field.width} bits")
            fields.append(FieldView(PRIMITIVES[kind], name, initial, doc))
            pack.append(
                f"((static_cast<{unsigned}>({name}) & {unsigned}{{0x{mask:x}U}})"
                f" << {field.position})"
            )
            raw = f"(raw >> {field.position}) & 0x{mask:x}U"
            if kind is Primitive.BOOLEAN:
                unpack.append(f"{name} = ({raw}) != 0;")
            elif kind.is_unsigned:
                unpack.append(f"{name} = static_cast<{PRIMITIVES[kind]}>({raw});")
            else:
                sign = 1 << (field.width - 1)
                wide_type = "std::int64_t"
                unpack.append(
                    f"{name} = static_cast<{PRIMITIVES[kind]}>(({wide_type}{{}} + "
                    f"static_cast<{wide_type}>(({raw}) ^ 0x{sign:x}U)) - {sign});"
                )
            check += self._bits_check(bitset, name, field.name, kind, field.width)
            value = name
            prints.append(PrintView(f"{field.name}=", value, ""))
        unpack.insert(0, f"if ((raw & ~{unsigned}{{0x{used:x}U}}) != 0) return false;")
        return BitsView(
            "bits", self._name(bitset), doc_lines(bitset.facts),
            "std::int64_t" if wide else "std::int32_t", unsigned,
            tuple(fields), tuple(pack), tuple(unpack), tuple(check), _separated(prints),
        )  # fmt: skip

    def _bits_check(
        self, bitset: Bitset, name: str, label: str, kind: Primitive, width: int
    ) -> list[str]:
        if kind is Primitive.BOOLEAN or width == 8 * kind.size:
            return []
        if kind.is_unsigned:
            low, high, wide = 0, (1 << width) - 1, "unsigned long long"
            test = f"value.{name} > {high}U"
        else:
            low, high, wide = -(1 << (width - 1)), (1 << (width - 1)) - 1, "long long"
            test = f"value.{name} < {low} || value.{name} > {high}"
        text = f"{bitset.simple_name}.{label}"
        return block(
            f"if ({test})",
            [
                f'return gecos::wire::out_of_range("{text}", static_cast<{wide}>(value.{name}), '
                f'"[{low}, {high}]");'
            ],
        )

    # -- structs -----------------------------------------------------------------------------------

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
            _separated([self._print(m) for m in members]),
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
            tuple(encode),
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

    # -- unions ------------------------------------------------------------------------------------

    def _union(self, union: Union) -> UnionView:
        lowering = self._lowering
        tag_type = lowering.type(union.discriminator)
        arms = []
        for index, case in enumerate(union.cases):
            several = len(case.labels) != 1 or case.is_default
            label = lowering.literal(case.labels[0], union.discriminator) if case.labels else ""
            arms.append(
                ArmView(
                    escaped(case.member.name, names.STRUCT_WORDS | {"tag", "value"}),
                    lowering.type(case.member.type),
                    lowering.parameter(case.member.type),
                    index + 1,
                    label,
                    several,
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
            "std::variant<" + ", ".join(["std::monostate", *(a.type for a in arms)]) + ">",
            tuple(arms),
            tuple(self._select(union)),
            f"0x{layout.fingerprint & 0xFFFFFFFFFFFFFFFF:016x}",
            self._union_codec(union, arms),
        )

    def _initial_tag(self, union: Union) -> str:
        dummy = Member("tag", union.discriminator, union.facts)
        return self._lowering.initial(dummy)

    def _select(self, union: Union) -> list[str]:
        """Statements that return the variant's index for `tag`."""
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
        tag_node = node_of(self._model, union.discriminator)
        assert isinstance(tag_node, ScalarNode | EnumNode)
        wire = wire_tag_of(tag_node)
        wire_type = PRIMITIVES[wire]
        total = wire.size + len(arms)
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
        for arm, case in zip(arms, union.cases, strict=True):
            held = f"std::get<{arm.index}>(value)"
            label = f"{union.simple_name}.{case.member.name}"
            slot = Slot("arm", label, case.member.type, False, case.member.range)
            always, more = lowering.size(slot, "size", LocalNames({"size", "arm"}))
            inner = [f"size += {always};"] if always else []
            if more:
                inner = [*inner, f"const auto& arm = {held};", *more]
            if inner:
                size += block(f"if (value.index() == {arm.index})", inner)
            encode.append(f"to.put(value.index() == {arm.index});")
            writes = lowering.encode(slot, "to", LocalNames({"to", "arm"}))
            encode += block(
                f"if (value.index() == {arm.index})", [f"const auto& arm = {held};", *writes]
            )
            reads = lowering.decode(slot, "from", LocalNames({"from", "arm"}))
            there = f'gecos::wire::get_arm(from, gecos_arm(tag) == {arm.index}, "{label}")'
            if_there = [f"({there} &&", f" (gecos_arm(tag) != {arm.index} ||"]
            lambda_lines = [
                "  [&](auto& arm) {",
                *(f"    {x}" for x in _returning(reads)),
                f"  }}(value.emplace<{arm.index}>())))",
            ]
            terms.append([*if_there, *lambda_lines])
            checks = lowering.check(replace(slot, expression="arm"), LocalNames({"arm", "value"}))
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
            scope = "::".join(names.scope_of(self._model, tag.name))
            return [f'{scope}::decode_enum(from, tag, "{label}")']
        return [f'gecos::wire::get_tag<{wire_type}>(from, tag, "{label}")']


def or_at_end(reader: str, term: list[str]) -> list[str]:
    """`term`, unless nothing is left to read: an older writer's value."""
    lines = [f"({reader}.at_end() ||", *(f" {line}" for line in term)]
    if len(term) > 1 and term[0].endswith("&&"):
        lines[1] = f" ({term[0]}"
        lines[-1] += ")"
    lines[-1] += ")"
    return lines


def conjunction(terms: list[list[str]]) -> list[str]:
    """`return a && b;`, one term to a line."""
    if not terms:
        return ["return true;"]
    lines: list[str] = []
    for i, term in enumerate(terms):
        joined = list(term)
        joined[-1] += ";" if i == len(terms) - 1 else " &&"
        lines += joined
    return [f"return {lines[0]}", *(f"       {line}" for line in lines[1:])]


def _returning(expression: list[str]) -> list[str]:
    lines = [f"return {expression[0]}", *(f"       {line}" for line in expression[1:])]
    lines[-1] += ";"
    return lines


def _separated(prints: list[PrintView]) -> tuple[PrintView, ...]:
    return tuple(
        replace(p, label=p.label if i == 0 else f", {p.label}") for i, p in enumerate(prints)
    )


def _may_be_missing(member: Member) -> bool:
    return member.optional or member.default is not None


def missing_value(lowering: Lowering, member: Member) -> str:
    """What an older writer's absent member becomes."""
    if member.optional:
        return "std::nullopt"
    assert member.default is not None
    return lowering.literal(member.default, member.type)


def unit_of(used: Type) -> str | None:
    return used.unit if isinstance(used, SequenceType) else None


def bound_of(used: Type) -> int | None:
    return used.bound if isinstance(used, SequenceType | StringType) else None
