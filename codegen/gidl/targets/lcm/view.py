"""Builds the views of a model's .lcm files from the structs that gidl.wire.lcm_lowering
computes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gidl.files.names import source_stem
from gidl.model import Bitmask, EnumDeclaration, Facts, Model, Struct, Union
from gidl.targets.naming import OutputFile, doc_lines, value_note
from gidl.wire.lcm_lowering import (
    LCM_PRIMITIVES,
    OBJECT_REF,
    OBJECT_REF_STRUCT,
    LcmMember,
    LcmStruct,
)
from gidl.wire.wire_layout import Layout


@dataclass(frozen=True, slots=True)
class MemberView:
    doc: tuple[str, ...]
    text: str  # the declaration, for example "double x[3];"


@dataclass(frozen=True, slots=True)
class StructView:
    doc: tuple[str, ...]
    name: str
    constants: tuple[str, ...]
    members: tuple[MemberView, ...]


@dataclass(frozen=True, slots=True)
class PackageView:
    name: str  # "" for types outside of every module
    structs: tuple[StructView, ...]


@dataclass(frozen=True, slots=True)
class LcmView:
    source: str
    packages: tuple[PackageView, ...]


def files(model: Model, layout: Layout) -> Iterator[OutputFile]:
    asked = [file for file in model.files if file.asked_for]
    refers = False
    for file in asked:
        structs = layout.lcm_structs[file.path]
        refers = refers or any(m.type == OBJECT_REF for s in structs for m in s.members)
        if structs:
            view = LcmView(file.path, _packages(model, structs))
            yield OutputFile(f"lcm/{source_stem(file.path)}.lcm", "lcm", "types.lcm.j2", view)
    if refers:
        view = LcmView("any interface that passes objects", _packages(model, (OBJECT_REF_STRUCT,)))
        yield OutputFile("lcm/gecos/object_ref.lcm", "lcm", "types.lcm.j2", view)


def _packages(model: Model, structs: tuple[LcmStruct, ...]) -> tuple[PackageView, ...]:
    """Returns the packages, sorted by name. Structs without a package come first."""
    names = sorted({struct.package for struct in structs})
    return tuple(
        PackageView(name, tuple(_struct(model, s) for s in structs if s.package == name))
        for name in names
    )


def _struct(model: Model, struct: LcmStruct) -> StructView:
    facts = _facts(model, struct)
    return StructView(
        doc_lines(facts[""]) if "" in facts else (),
        struct.simple_name,
        tuple(f"const {c.type} {c.name} = {c.value};" for c in struct.constants),
        tuple(_member(struct, member, facts, model) for member in struct.members),
    )


def _facts(model: Model, struct: LcmStruct) -> dict[str, Facts]:
    """Returns the facts (for example the comments) of the members, by the name of the member. The
    facts of the struct itself have the key ""."""
    if struct.source is None:
        return {}
    declaration = model.find(struct.source)
    found = {"": declaration.facts}
    if isinstance(declaration, Struct):
        found |= {m.name: m.facts for m in model.all_members(declaration)}
    elif isinstance(declaration, Union):
        found |= {case.member.name: case.member.facts for case in declaration.cases}
    else:
        assert isinstance(declaration, EnumDeclaration | Bitmask) or not struct.members
    return found


def _member(
    struct: LcmStruct, member: LcmMember, facts: dict[str, Facts], model: Model
) -> MemberView:
    used = member.type
    if used not in LCM_PRIMITIVES:
        used = used.removeprefix(f"{struct.package}.") if struct.package else used
        if used.count(".") and member.type.rpartition(".")[0] != struct.package:
            used = member.type
    sizes = "".join(f"[{dimension.size}]" for dimension in member.dimensions)
    doc: tuple[str, ...] = ()
    if member.source is not None and member.source in facts:
        doc = doc_lines(facts[member.source], _note(model, struct, member.source))
    return MemberView(doc, f"{used} {member.name}{sizes};")


def _note(model: Model, struct: LcmStruct, source: str) -> str:
    assert struct.source is not None
    declaration = model.find(struct.source)
    if isinstance(declaration, Struct):
        for member in model.all_members(declaration):
            if member.name == source:
                return value_note(member.unit, member.range)
    return ""
