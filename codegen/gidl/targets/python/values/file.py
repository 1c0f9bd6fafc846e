"""What the template of `<file>_types.py` prints of one file."""

from __future__ import annotations

from gidl.file_names import python_module
from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    Facts,
    File,
    Location,
    Primitive,
    Struct,
    Typedef,
    Union,
)
from gidl.targets.naming import value_note
from gidl.targets.python import names
from gidl.targets.python.imports import export_order, import_lines, private
from gidl.targets.python.lower import CODES, Lowering
from gidl.targets.python.values.names import (
    BUILTIN_FUNCTIONS,
    one_line,
    type_doc,
)
from gidl.targets.python.values.structs import Structs
from gidl.targets.python.values.unions import Unions
from gidl.targets.python.values.views import (
    AliasView,
    BitsFieldView,
    BitsView,
    ConstantView,
    EnumeratorView,
    EnumView,
    StructView,
    TypesView,
    TypeView,
    UnionView,
)


def types_view(lowering: Lowering, file: File, extra: tuple[Struct, ...]) -> TypesView:
    builder = _Types(lowering)
    declarations = (*file.declarations, *extra)
    types = [view for d in declarations if (view := builder.type(d)) is not None]
    mapped = [
        found
        for d in declarations
        if isinstance(d, Struct) and (found := names.mapped(d)) is not None
    ]
    exported = [t.name for t in types if not t.name.startswith("_")] + [name for _, name in mapped]
    return TypesView(
        file.path,
        type_doc(Facts(Location(file.path, 1, 1), file.doc)) or (f"Types of {file.path}.",),
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
    bodies = "\n".join(
        line for t in types if isinstance(t, StructView | UnionView) for line in t.encode
    )
    fields = any("_field(" in field.default for t in structs for field in t.fields)
    modules: dict[str, list[str]] = {"builtins": [], "dataclasses": [], "enum": [], "typing": []}
    modules["builtins"] += private(w for w in BUILTIN_FUNCTIONS if f"_{w}(" in bodies)
    for module, name, used in (
        ("dataclasses", "dataclass", coded),
        ("dataclasses", "field", fields),
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
            modules[module] += private([name])
    return import_lines(modules)


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
    if "_npt." not in hints:
        return []
    return ["import numpy as _np", "import numpy.typing as _npt"]


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
    names.refuse_same_names(model, file, used)
    modules: dict[str, set[str]] = {}
    if {t.kind for t in types} & {"struct", "union", "bits"}:
        modules["gecos"] = set(private(["wire"]))
        modules["gecos.wire"] = set(private(["shapes"]))
    if any(isinstance(t, StructView) and t.plan for t in types):
        modules["gecos.wire"].update(private(["plans"]))
    if any(isinstance(t, StructView) and t.is_exception for t in types):
        modules["gecos.errors"] = set(private(["DeclaredError"]))
    for module, name in mapped:
        modules.setdefault(module, set()).add(name)
    for name in used:
        module = names.types_module(model, name)
        if module != f"{python_module(file.path)}_types":
            modules.setdefault(module, set()).add(names.type_name(model, name))
    return import_lines(modules)


class _Types(Structs, Unions):
    def type(self, declaration: AnyDeclaration) -> TypeView | None:
        match declaration:
            case EnumDeclaration():
                values = tuple(
                    EnumeratorView(names.enumerator(e.name), str(e.number), one_line(e.facts))
                    for e in declaration.enumerators
                )
                return EnumView(
                    "enum", self._name(declaration), type_doc(declaration.facts), values
                )
            case Bitmask():
                values = tuple(
                    EnumeratorView(
                        names.enumerator(f.name), f"1 << {f.position}", one_line(f.facts)
                    )
                    for f in declaration.flags
                )
                return EnumView(
                    "mask", self._name(declaration), type_doc(declaration.facts), values
                )
            case Bitset():
                return self._bits(declaration)
            case Struct():
                mapped = names.mapped(declaration)
                if mapped is not None:
                    return self._twin(declaration, mapped[1])
                return self._struct(declaration)
            case Union():
                return self._union(declaration)
            case Typedef():
                note = value_note(declaration.unit, declaration.range)
                hint = self._lowering.hint(declaration.type)
                doc = type_doc(declaration.facts, note)
                return AliasView("alias", self._name(declaration), doc, hint)
            case Constant():
                return self._constant(declaration)
            case _:
                return None

    def _constant(self, constant: Constant) -> ConstantView:
        return ConstantView(
            "constant",
            self._name(constant),
            type_doc(constant.facts, value_note(constant.unit, None)),
            self._lowering.hint(constant.type),
            self._lowering.literal(constant.value, constant.type),
        )

    def _bits(self, bitset: Bitset) -> BitsView:
        fields, shape, used = [], [], 0
        for f in self._model.all_fields(bitset):
            if f.name is None:
                continue
            kind = f.type.kind
            boolean = kind is Primitive.BOOLEAN
            signed = not boolean and not kind.is_unsigned
            member = names.member_name(f.name, names.STRUCT_WORDS | {"pack", "unpack"})
            attribute = f', attribute="{member}"' if member != f.name else ""
            shape.append(f'_shapes.Member("{f.name}", _shapes.Number("{CODES[kind]}"){attribute})')
            used |= ((1 << f.width) - 1) << f.position
            fields.append(
                BitsFieldView(
                    member,
                    "bool" if boolean else "int",
                    "False" if boolean else "0",
                    type_doc(f.facts, f"{f.width} bits"),
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
            "bits", self._name(bitset), type_doc(bitset.facts), "Q" if wide else "I",
            8 if wide else 4, f"0x{used:x}", tuple(fields), tuple(shape),
        )  # fmt: skip
