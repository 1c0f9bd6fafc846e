"""What the template of `<file>_types.py` prints."""

from __future__ import annotations

from dataclasses import dataclass

from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    ExceptionStruct,
    Facts,
    File,
    Location,
    Member,
    Primitive,
    PrimitiveType,
    Struct,
    Typedef,
    Union,
)
from gidl.targets.naming import LocalNames, doc_lines, escaped, value_note
from gidl.targets.python import names
from gidl.targets.python.imports import export_order, import_lines
from gidl.targets.python.lower import CODES, Leaf, Lowering, Run, Slot, indented
from gidl.targets.reach import type_reaches
from gidl.wire_layout import node_of, wire_tag_of
from gidl.wire_nodes import EnumNode, ScalarNode

LOCAL_WORDS = frozenset(
    ("out", "source", "cls", "self", "wire", "chr", "range", "len", "sorted", "Any", "np", "npt")
)


@dataclass(frozen=True, slots=True)
class EnumeratorView:
    name: str
    value: str
    doc: str  # one line, or ""


@dataclass(frozen=True, slots=True)
class EnumView:
    kind: str  # "enum" or "mask"
    name: str
    doc: tuple[str, ...]
    enumerators: tuple[EnumeratorView, ...]


@dataclass(frozen=True, slots=True)
class FieldView:
    name: str
    hint: str
    default: str
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class RunView:
    name: str  # "_HOLDER_1"
    codes: str
    labels: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StructView:
    kind: str  # "struct"
    name: str
    base: str  # "(DeclaredError)" or ""
    decorator: str
    scoped_name: str
    is_exception: bool
    doc: tuple[str, ...]
    fields: tuple[FieldView, ...]
    runs: tuple[RunView, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    fingerprint: str  # "" for what is no declared type
    equal: tuple[str, ...]  # comparisons, where arrays need help


@dataclass(frozen=True, slots=True)
class ArmView:
    name: str
    hint: str
    tag: str
    several: bool
    index: int
    doc: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnionView:
    kind: str  # "union"
    name: str
    doc: tuple[str, ...]
    tag_hint: str
    tag_default: str
    value_hint: str
    arms: tuple[ArmView, ...]
    select: tuple[str, ...]
    encode: tuple[str, ...]
    decode: tuple[str, ...]
    fingerprint: str
    needs_same: bool


@dataclass(frozen=True, slots=True)
class BitsFieldView:
    name: str
    hint: str
    default: str
    doc: tuple[str, ...]
    position: int
    width: int
    low: int
    high: int
    mask: str
    kind: str  # "bool", "unsigned", "signed"
    label: str


@dataclass(frozen=True, slots=True)
class BitsView:
    kind: str  # "bits"
    name: str
    doc: tuple[str, ...]
    code: str
    size: int
    used: str
    fields: tuple[BitsFieldView, ...]


@dataclass(frozen=True, slots=True)
class AliasView:
    kind: str  # "alias"
    name: str
    doc: tuple[str, ...]
    hint: str


@dataclass(frozen=True, slots=True)
class ConstantView:
    kind: str  # "constant"
    name: str
    doc: tuple[str, ...]
    hint: str
    value: str


TypeView = EnumView | StructView | UnionView | BitsView | AliasView | ConstantView


@dataclass(frozen=True, slots=True)
class TypesView:
    source: str
    doc: tuple[str, ...]
    standard: tuple[str, ...]  # import lines of the standard library
    imports: tuple[str, ...]  # import lines of gecos, hand-written types and other files
    numpy: tuple[str, ...]  # only for type checkers
    types: tuple[TypeView, ...]
    exported: tuple[str, ...]


def types_view(lowering: Lowering, file: File, extra: tuple[Struct, ...]) -> TypesView:
    builder = _Builder(lowering)
    declarations = (*file.declarations, *extra)
    types = [view for d in declarations if (view := builder.type(d)) is not None]
    mapped = [
        found
        for d in declarations
        if isinstance(d, Struct) and (found := names.mapped(d)) is not None
    ]
    exported = [t.name for t in types] + [name for _, name in mapped]
    return TypesView(
        file.path,
        _doc_lines(Facts(Location(file.path, 1, 1), file.doc)) or (f"Types of {file.path}.",),
        tuple(_standard(types)),
        tuple(_imports(lowering, file, declarations, types, mapped)),
        tuple(_numpy(types)),
        tuple(types),
        tuple(sorted(exported, key=export_order)),
    )


def _standard(types: list[TypeView]) -> list[str]:
    kinds = {t.kind for t in types}
    structs = [t for t in types if isinstance(t, StructView)]
    coded = bool(kinds & {"struct", "union", "bits"})
    modules: dict[str, list[str]] = {"dataclasses": [], "enum": [], "typing": []}
    for module, name, used in (
        ("dataclasses", "dataclass", coded),
        ("enum", "IntEnum", "enum" in kinds),
        ("enum", "IntFlag", "mask" in kinds),
        ("typing", "TYPE_CHECKING", bool(_numpy(types))),
        ("typing", "Any", "union" in kinds),
        ("typing", "ClassVar", any(t.is_exception for t in structs)),
        ("typing", "Final", "constant" in kinds),
        ("typing", "Self", coded),
        ("typing", "TypeAlias", "alias" in kinds),
    ):
        if used:
            modules[module].append(name)
    lines = import_lines(modules)
    if any("_field(" in field.default for t in structs for field in t.fields):
        lines.insert(1, "from dataclasses import field as _field")
    return lines


def _numpy(types: list[TypeView]) -> list[str]:
    hints = " ".join(
        part
        for t in types
        for part in (
            [f.hint for f in t.fields] if isinstance(t, StructView)
            else [t.value_hint, *(a.hint for a in t.arms)] if isinstance(t, UnionView)
            else [t.hint] if isinstance(t, AliasView)
            else []
        )
    )  # fmt: skip
    if "npt." not in hints:
        return []
    return ["import numpy as np", "import numpy.typing as npt"]


def _imports(
    lowering: Lowering,
    file: File,
    declarations: tuple[AnyDeclaration, ...],
    types: list[TypeView],
    mapped: list[tuple[str, str]],
) -> list[str]:
    model = lowering.model
    used: set[str] = set()
    for declaration in declarations:
        match declaration:
            case Struct():
                if names.mapped(declaration):
                    continue
                for member in model.all_members(declaration):
                    used |= lowering.imports(member.type)
            case Union():
                used |= lowering.imports(declaration.discriminator)
                for case in declaration.cases:
                    used |= lowering.imports(case.member.type)
            case Typedef(type=target):
                used |= lowering.imports(target)
            case _:
                pass
    modules: dict[str, set[str]] = {}
    if {t.kind for t in types} & {"struct", "union", "bits"}:
        modules["gecos"] = {"wire"}
    if any(isinstance(t, StructView) and t.is_exception for t in types):
        modules["gecos.errors"] = {"DeclaredError"}
    for module, name in mapped:
        modules.setdefault(module, set()).add(name)
    for name in used:
        home = model.file_of(name)
        if home != file.path:
            module = f"{names.module_of(home)}_types"
            modules.setdefault(module, set()).add(names.type_name(model, name))
    return import_lines(modules)


def _doc_lines(facts: Facts, note: str = "") -> tuple[str, ...]:
    return names.docstring(doc_lines(facts, note))


class _Builder:
    def __init__(self, lowering: Lowering) -> None:
        self._lowering = lowering
        self._model = lowering.model

    def type(self, declaration: AnyDeclaration) -> TypeView | None:
        match declaration:
            case EnumDeclaration():
                values = tuple(
                    EnumeratorView(names.enumerator(e.name), str(e.number), _one_line(e.facts))
                    for e in declaration.enumerators
                )
                return EnumView(
                    "enum", self._name(declaration), _doc_lines(declaration.facts), values
                )
            case Bitmask():
                values = tuple(
                    EnumeratorView(
                        names.enumerator(f.name), f"1 << {f.position}", _one_line(f.facts)
                    )
                    for f in declaration.flags
                )
                return EnumView(
                    "mask", self._name(declaration), _doc_lines(declaration.facts), values
                )
            case Bitset():
                return self._bits(declaration)
            case Struct():
                return None if names.mapped(declaration) else self._struct(declaration)
            case Union():
                return self._union(declaration)
            case Typedef():
                note = value_note(declaration.unit, declaration.range)
                hint = self._lowering.hint(declaration.type)
                doc = _doc_lines(declaration.facts, note)
                return AliasView("alias", self._name(declaration), doc, hint)
            case Constant():
                return self._constant(declaration)
            case _:
                return None

    def _name(self, declaration: AnyDeclaration) -> str:
        return names.type_name(self._model, declaration.name)

    def _constant(self, constant: Constant) -> ConstantView:
        return ConstantView(
            "constant",
            self._name(constant),
            _doc_lines(constant.facts, value_note(constant.unit, None)),
            self._lowering.hint(constant.type),
            self._lowering.literal(constant.value, constant.type),
        )

    def _bits(self, bitset: Bitset) -> BitsView:
        fields, used = [], 0
        for f in self._model.all_fields(bitset):
            if f.name is None:
                continue
            kind = f.type.kind
            boolean = kind is Primitive.BOOLEAN
            signed = not boolean and not kind.is_unsigned
            used |= ((1 << f.width) - 1) << f.position
            fields.append(
                BitsFieldView(
                    names.member_name(f.name, names.STRUCT_WORDS | {"pack", "unpack"}),
                    "bool" if boolean else "int",
                    "False" if boolean else "0",
                    _doc_lines(f.facts, f"{f.width} bits"),
                    f.position,
                    f.width,
                    -(1 << (f.width - 1)) if signed else 0,
                    (1 << (f.width - signed)) - 1,
                    f"0x{(1 << f.width) - 1:x}",
                    "bool" if boolean else "signed" if signed else "unsigned",
                    f"{bitset.simple_name}.{f.name}",
                )
            )
        wide = bitset.bit_size > 32
        return BitsView(
            "bits", self._name(bitset), _doc_lines(bitset.facts), "Q" if wide else "I",
            8 if wide else 4, f"0x{used:x}", tuple(fields),
        )  # fmt: skip

    # -- structs -----------------------------------------------------------------------------------

    def _struct(self, struct: Struct) -> StructView:
        members = self._model.all_members(struct)
        words = names.STRUCT_WORDS
        is_exception = isinstance(struct, ExceptionStruct)
        if is_exception:
            words = names.EXCEPTION_WORDS
        slots = [
            Slot(f"self.{names.member_name(m.name, words)}", f"{struct.simple_name}.{m.name}",
                 m.type, m.optional, m.range)
            for m in members
        ]  # fmt: skip
        arrays = any(self._lowering.holds_array(m.type) for m in members)
        known = self._model.has(struct.name)
        layout = self._lowering.layout.structs.get(struct.name)
        plan = _Plan(self._lowering, struct, members, slots, self._name(struct), words)
        by_hand = is_exception or arrays
        return StructView(
            "struct",
            self._name(struct),
            "(DeclaredError)" if is_exception else "",
            "@dataclass(slots=True, eq=False)" if by_hand else "@dataclass(slots=True)",
            struct.name,
            is_exception,
            _doc_lines(struct.facts),
            tuple(self._field(m, words) for m in members),
            tuple(plan.run_views()),
            tuple(plan.encode_body()),
            tuple(plan.decode_body(known and type_reaches(self._model, struct.name, struct.name))),
            "" if layout is None else f"0x{layout.fingerprint & (1 << 64) - 1:016X}",
            tuple(self._comparisons(members, words)) if arrays and not is_exception else (),
        )

    def _comparisons(self, members: tuple[Member, ...], words: frozenset[str]) -> list[str]:
        lines = []
        for m in members:
            name = names.member_name(m.name, words)
            if self._lowering.holds_array(m.type):
                lines.append(f"wire.same(self.{name}, other.{name})")
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
            _doc_lines(member.facts, note),
        )

    # -- unions ------------------------------------------------------------------------------------

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
        number = "wire.char(self.tag)[0]" if char else "int(self.tag)" if boolean else "self.tag"
        if isinstance(tag_node, ScalarNode) and tag_node.primitive is Primitive.UINT64:
            code = "Q"
        encode += [
            "arm = self._arm(self.tag)",
            "value: Any = self.value",
            "if (value is None) != (arm == 0):",
            f'    raise wire.EncodeError("{union.simple_name}",'
            ' "its tag does not select the arm that it holds")',
            f'out.append(wire.number({number}, "{code}", "{label}"))',
        ]
        decode += self._decode_tag(union, tag_node, code, label)
        decode += ["arm = cls._arm(tag)", "value: Any = None"]
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
                    _doc_lines(case.member.facts, value_note(case.member.unit, case.member.range)),
                )
            )  # fmt: skip
            slot = Slot("value", arm_label, used, False, case.member.range)
            local = LocalNames(LOCAL_WORDS | {"arm", "value"})
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
            "union", self._name(union), _doc_lines(union.facts),
            lowering.hint(union.discriminator), tag_default,
            " | ".join([*hints, "None"]), tuple(arms), tuple(self._select(union)),
            tuple(encode), tuple(decode), f"0x{fingerprint & (1 << 64) - 1:016X}",
            any("npt." in hint for hint in hints),
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
                f'    source.refuse(wire.DecodeProblem.UNKNOWN_UNION_TAG, "{label}",'
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


class _Plan:
    """A struct's members in wire order: runs of numbers, and everything else one by one."""

    def __init__(
        self,
        lowering: Lowering,
        struct: Struct,
        members: tuple[Member, ...],
        slots: list[Slot],
        name: str,
        words: frozenset[str],
    ) -> None:
        self._lowering = lowering
        self._struct = struct
        self._members = members
        self._slots = slots
        self._words = words
        self._required = len(members)
        if struct.is_appendable:
            while self._required and _may_be_missing(members[self._required - 1]):
                self._required -= 1
        # Groups: member indices that share a run, or a single index without one.
        self._groups: list[tuple[Run | None, list[int]]] = []
        for i, slot in enumerate(slots):
            leaves = lowering.leaves(slot) if i < self._required else None
            if leaves is None:
                self._groups.append((None, [i]))
            elif self._groups and self._groups[-1][0] is not None:
                last, indices = self._groups[-1]
                assert last is not None
                last.leaves += leaves
                indices.append(i)
            else:
                self._groups.append((Run(leaves), [i]))
        runs = [run for run, _ in self._groups if run is not None]
        self._names = {
            id(run): names.constant(name, "layout")
            if len(runs) == 1
            else names.constant(name, "layout", str(n))
            for n, run in enumerate(runs, start=1)
        }

    def run_views(self) -> list[RunView]:
        return [
            RunView(
                self._names[id(run)],
                "".join(leaf.code for leaf in run.leaves),
                tuple(leaf.label for leaf in run.leaves),
            )
            for run, _ in self._groups
            if run is not None
        ]

    def encode_body(self) -> list[str]:
        lines: list[str] = []
        local = LocalNames(LOCAL_WORDS)
        for run, indices in self._groups:
            if run is None:
                lines += self._lowering.encode(self._slots[indices[0]], local)
                continue
            values = ", ".join(leaf.access for leaf in run.leaves)
            lines.append(f"out.append({self._names[id(run)]}.pack({values}))")
            for leaf in run.leaves:
                lines += self._lowering.check_leaf(leaf)
        return lines or ["pass"]

    def decode_body(self, recursive: bool) -> list[str]:
        only = self._groups[0][0] if len(self._groups) == 1 else None
        if only is not None and self._is_plain(only) and not self._struct.is_appendable:
            return [f"return cls(*{self._names[id(only)]}.unpack(source))"]
        lines: list[str] = []
        local = LocalNames(LOCAL_WORDS | {names.type_name(self._lowering.model, n)
                                          for m in self._members
                                          for n in self._lowering.imports(m.type)})  # fmt: skip
        arguments: list[str] = []
        for run, indices in self._groups:
            if run is None:
                lines += self._decode_single(indices[0], local, arguments)
            else:
                lines += self._decode_run(run, indices, local, arguments)
        if recursive:
            lines.insert(0, f'source.enter("{self._struct.simple_name}")')
            lines.append("source.leave()")
        if self._struct.is_appendable:
            lines.append("source.offset = source.end  # what a newer writer added is skipped")
        return [*lines, f"return cls({', '.join(arguments)})"]

    def _is_plain(self, run: Run) -> bool:
        """Whether what is unpacked are the members as they are."""
        return len(run.leaves) == len(self._members) and all(
            isinstance(node_of(self._lowering.model, m.type), ScalarNode)
            and not self._lowering.refuse_leaf(leaf, "x", 0)
            for m, leaf in zip(self._members, run.leaves, strict=True)
        )

    def _decode_single(self, index: int, local: LocalNames, arguments: list[str]) -> list[str]:
        member, slot = self._members[index], self._slots[index]
        variable = local.fresh(names.member_name(member.name, self._words))
        arguments.append(variable)
        text = self._lowering.decode(slot)
        if index < self._required:
            return [f"{variable} = {text}"]
        missing, made = self._lowering.initial(member)
        hint = self._lowering.hint(member.type, member.optional)
        assert not made, "only constants and None stand in for what is missing"
        return [
            f"{variable}: {hint} = {missing}",
            "if source.offset < source.end:",
            f"    {variable} = {text}",
        ]

    def _decode_run(
        self, run: Run, indices: list[int], local: LocalNames, arguments: list[str]
    ) -> list[str]:
        variables = [local.fresh(_variable(leaf)) for leaf in run.leaves]
        left = ", ".join(variables) + ("," if len(variables) == 1 else "")
        target = f"({left})" if len(variables) == 1 else left
        lines = [f"{target} = {self._names[id(run)]}.unpack(source)"]
        for i, (leaf, variable) in enumerate(zip(run.leaves, variables, strict=True)):
            lines += self._lowering.refuse_leaf(leaf, variable, run.behind(i))
        left_over, behind = list(variables), [run.behind(i) for i in range(len(run.leaves))]
        for index in indices:
            member, slot = self._members[index], self._slots[index]
            text = self._lowering.rebuilt(member.type, left_over, behind, slot.label)
            if text in variables:
                arguments.append(text)
                continue
            made = local.fresh(f"{names.member_name(member.name, self._words)}_value")
            lines.append(f"{made} = {text}")
            arguments.append(made)
        return lines


def _variable(leaf: Leaf) -> str:
    """ "self.position.x" -> "position_x"."""
    return escaped(leaf.access.removeprefix("self.").replace(".", "_"), names.KEYWORDS)


def _may_be_missing(member: Member) -> bool:
    return member.optional or member.default is not None


def _one_line(facts: Facts) -> str:
    return " ".join(doc_lines(facts))
