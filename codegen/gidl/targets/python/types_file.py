"""Builds the view with which the template of a generated `<file>_types.py` is rendered."""

from __future__ import annotations

from gidl.files.names import python_module
from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    Facts,
    File,
    Interface,
    Location,
    Model,
    Primitive,
    Struct,
    Typedef,
    Union,
)
from gidl.targets.groups import call, group
from gidl.targets.naming import value_note
from gidl.targets.python import names
from gidl.targets.python.homes import ModuleNames, mapped_import
from gidl.targets.python.imports import export_order, import_lines, private
from gidl.targets.python.layout_steps import Lowering, renamed
from gidl.targets.python.name_lookup import type_doc
from gidl.targets.python.structs import Structs
from gidl.targets.python.type_text import CODES, quoted
from gidl.targets.python.type_views import (
    AliasView,
    BitsView,
    ConstantView,
    EnumeratorView,
    EnumView,
    FieldView,
    StructView,
    TypesView,
    TypeView,
    UnionView,
)
from gidl.targets.python.unions import Unions
from gidl.wire.wire_layout import Layout, node_of
from gidl.wire.wire_nodes import Node


def types_view(lowering: Lowering, file: File) -> TypesView:
    builder = _Types(_in_module(lowering, file))
    types = [*builder.types(file), *builder.results(file)]
    mapped = [d for d in file.declarations if isinstance(d, Struct) and names.mapped(d) is not None]
    known = lowering.layout.python_names.types
    hand_written = {mapped_import(d, known[d.name].name) for d in mapped}
    exported = [t.name for t in types if not t.name.startswith("_")]
    exported += [known[d.name].name for d in mapped]
    return TypesView(
        file.path,
        type_doc(Facts(Location(file.path, 1, 1), file.doc)) or (f"Types of {file.path}.",),
        tuple(_standard(types)),
        tuple(_imports(builder.module, types, hand_written)),
        tuple(_numpy(types)),
        tuple(types),
        tuple(sorted(exported, key=export_order)),
    )


def _in_module(lowering: Lowering, file: File) -> Lowering:
    """Returns a copy of `lowering` that prints names as the generated module `<file>_types.py` uses
    them."""
    homes, layout = lowering.module.homes, lowering.layout
    nodes = [n for d in file.declarations for n in _nodes(lowering.model, layout, d)]
    for operation in homes.results_of(file):
        nodes += [field.node for field in layout.call(operation.scoped_name).reply]
    used = {home for node in nodes for home in lowering.named(node)}
    own = f"{python_module(file.path)}_types"
    return lowering.within(ModuleNames(homes, used, homes.names_of(file), [own]))


def _nodes(model: Model, layout: Layout, declaration: AnyDeclaration) -> list[Node]:
    """Returns the wire-layout nodes of all values in the class that is generated for a
    declaration."""
    match declaration:
        case Struct(name):
            return [field.node for field in layout.structs[name].fields]
        case Union(name):
            union = layout.unions[name]
            return [union.tag, *(arm.node for arm in union.arms)]
        case Typedef(type=target) | Constant(type=target):
            return [node_of(model, target)]
        case _:
            return []


def _standard(types: list[TypeView]) -> list[str]:
    kinds = {t.kind for t in types}
    structs = [t for t in types if isinstance(t, StructView)]
    coded = bool(kinds & {"struct", "union", "bits"})
    fields = any("_field(" in field.default for t in structs for field in t.fields)
    unions = "union" in kinds
    modules: dict[str, list[str]] = {"dataclasses": [], "enum": [], "typing": []}
    for module, name, used in (
        ("dataclasses", "dataclass", coded),
        ("dataclasses", "field", fields),
        ("enum", "IntEnum", "enum" in kinds),
        ("enum", "IntFlag", "mask" in kinds),
        ("typing", "TYPE_CHECKING", bool(_numpy(types))),
        ("typing", "Any", unions),
        ("typing", "Final", "constant" in kinds),
        ("typing", "Self", unions),
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
    module: ModuleNames, types: list[TypeView], hand_written: set[tuple[str, str]]
) -> list[str]:
    modules = module.imports()
    if {t.kind for t in types} - {"alias", "constant"}:
        modules["gecos.wire"] = set(private(["layout"]))
    structs = [t for t in types if isinstance(t, StructView)]
    if any("_wire." in field.default for t in structs for field in t.fields):
        modules["gecos"] = set(private(["wire"]))
    if any(t.role == "exception" for t in structs):
        modules["gecos.errors"] = set(private(["DeclaredError"]))
    for home, text in hand_written:
        modules.setdefault(home, set()).add(text)
    return import_lines(modules)


class _Types(Structs, Unions):
    @property
    def module(self) -> ModuleNames:
        return self._lowering.module

    def results(self, file: File) -> list[StructView]:
        """Returns the result classes of those operations in the file that have several results."""
        return [self._result(operation) for operation in self.module.homes.results_of(file)]

    def types(self, file: File) -> list[TypeView]:
        """Returns the views of the declarations in the order of the file. A typedef that uses a
        class defined later is moved to the end."""
        views: list[TypeView] = []
        later: list[TypeView] = []
        missing = self.module.homes.names_of(file)
        pending = self._lowering.pending
        pending.update(d.name for d in file.declarations if not isinstance(d, Interface))
        for declaration in file.declarations:
            view = self.type(declaration)
            pending.discard(declaration.name)
            if view is None:
                continue
            missing.discard(view.name)
            used = self._lowering.type_names(_nodes(self._model, self._layout, declaration))
            early = isinstance(view, AliasView) and used & missing
            (later if early else views).append(view)
        return views + later

    def type(self, declaration: AnyDeclaration) -> TypeView | None:
        match declaration:
            case EnumDeclaration():
                enumerators = declaration.enumerators
                unknown = declaration.default_literal
                return self._enum(
                    "enum",
                    declaration,
                    "_layout.enumeration",
                    [quoted("q" if declaration.bit_bound > 32 else "i")]
                    + ([] if unknown is None else [quoted(names.enumerator(unknown))]),
                    [(e.name, str(e.number), e.facts) for e in enumerators],
                )
            case Bitmask():
                return self._enum(
                    "mask",
                    declaration,
                    "_layout.flags",
                    [
                        quoted("Q" if declaration.bit_bound > 32 else "I"),
                        str(declaration.bit_bound),
                    ],
                    [(f.name, f"1 << {f.position}", f.facts) for f in declaration.flags],
                )
            case Bitset():
                return self._bits(declaration)
            case Struct():
                mapped = names.mapped(declaration) is not None
                return self._twin(declaration) if mapped else self._struct(declaration)
            case Union():
                return self._union(declaration)
            case Typedef():
                note = value_note(declaration.unit, declaration.range)
                hint = self._lowering.hint(node_of(self._model, declaration.type))
                doc = type_doc(declaration.facts, note)
                return AliasView("alias", self._name(declaration), doc, hint)
            case Constant():
                return self._constant(declaration)
            case _:
                return None

    def _enum(
        self,
        kind: str,
        declaration: EnumDeclaration | Bitmask,
        described: str,
        terms: list[str],
        enumerators: list[tuple[str, str, Facts]],
    ) -> EnumView:
        called = [(names.enumerator(name), name) for name, _, _ in enumerators]
        return EnumView(
            kind,
            self._name(declaration),
            call(described, *terms, *renamed(called)),
            type_doc(declaration.facts),
            tuple(
                EnumeratorView(names.enumerator(name), value, type_doc(facts))
                for name, value, facts in enumerators
            ),
        )

    def _constant(self, constant: Constant) -> ConstantView:
        node = node_of(self._model, constant.type)
        return ConstantView(
            "constant",
            self._name(constant),
            type_doc(constant.facts, value_note(constant.unit, None)),
            self._lowering.hint(node),
            self._lowering.literal(constant.value, node),
        )

    def _bits(self, bitset: Bitset) -> BitsView:
        words = names.STRUCT_WORDS | {"pack", "unpack"}
        fields, members, called = [], [], []
        for f in self._model.all_fields(bitset):
            if f.name is None:
                continue
            boolean = f.type.kind is Primitive.BOOLEAN
            member = names.member_name(f.name, words)
            called.append((member, f.name))
            code = quoted(CODES[f.type.kind])
            members.append(group([str(f.position), str(f.width), code]))
            fields.append(
                FieldView(
                    member,
                    "bool" if boolean else "int",
                    "False" if boolean else "0",
                    type_doc(f.facts, f"{f.width} bits"),
                )
            )
        name = self._name(bitset)
        label = [f"label={quoted(bitset.simple_name)}"] if bitset.simple_name != name else []
        code = quoted("Q" if bitset.bit_size > 32 else "I")
        described = call("_layout.bits", code, *members, *label, *renamed(called))
        return BitsView("bits", name, described, type_doc(bitset.facts), tuple(fields))
