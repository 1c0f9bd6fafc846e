"""Compares types and constants."""

from __future__ import annotations

from gidl.breaking import slots
from gidl.breaking.report import Report
from gidl.breaking.sides import Sides, read_exactly, wire_text
from gidl.files.names import source_stem
from gidl.model import (
    AnyDeclaration,
    Bitmask,
    Bitset,
    Constant,
    EnumDeclaration,
    ExceptionStruct,
    Interface,
    Model,
    Primitive,
    Struct,
    Typedef,
    Union,
)
from gidl.wire.function_codes import hashed_name

_MISREAD = "old and new programs read each other's bytes wrongly"
_NO_BUILD = "programs that use the old name do not build any more"


def compare(sides: Sides, report: Report) -> None:
    exact = read_exactly(sides.old), read_exactly(sides.new)
    for old, new in sides.declarations():
        if new is None:
            _gone(old, report)
        elif _kind(old) != _kind(new):
            report.add("G1002", old.name,
                       f"'{old.name}' was {_article(_kind(old))} and is now {_article(_kind(new))}",
                       _MISREAD,
                       "keep the old declaration, and give the new declaration another name",
                       new=new.facts, old=old.facts)  # fmt: skip
        else:
            _moved(sides, old, new, report)
            _one(sides, old, new, report)
            if isinstance(old, EnumDeclaration) and isinstance(new, EnumDeclaration):
                # A union or map that only one version declares is never sent to the other version.
                # `used` is therefore "" unless the enum is a discriminator or the key of a map in
                # both versions.
                used = exact[1].get(new.name, "") if old.name in exact[0] else ""
                _enum(old, new, used, report)


def _kind(declaration: AnyDeclaration) -> str:
    match declaration:
        case ExceptionStruct():
            return "exception"
        case EnumDeclaration():
            return "enum"
        case _:
            return type(declaration).__name__.lower()


def _article(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _gone(old: AnyDeclaration, report: Report) -> None:
    if isinstance(old, Interface):
        report.add("G1001", old.name, f"interface '{old.name}' is gone",
                   "old clients find no object with this interface",
                   "keep the declaration and mark it @deprecated; if you renamed it, write "
                   "@hash_as(\"old_name\")",
                   old=old.facts)  # fmt: skip
        return
    report.add("G1101", old.name, f"{_kind(old)} '{old.name}' is gone", _NO_BUILD,
               "keep the declaration and mark it @deprecated; if you renamed it, write "
               "@hash_as(\"old_name\")",
               old=old.facts)  # fmt: skip


def _moved(sides: Sides, old: AnyDeclaration, new: AnyDeclaration, report: Report) -> None:
    if old.name != new.name:
        report.add("G1101", old.name, f"'{new.name}' was named '{old.name}' before", _NO_BUILD,
                   "keep the name", new=new.facts, old=old.facts)  # fmt: skip
        return
    was, is_now = sides.old.file_of(old.name), sides.new.file_of(new.name)
    if source_stem(was) != source_stem(is_now):
        report.add("G1102", old.name, f"'{new.name}' has moved from {was} to {is_now}",
                   "the generated headers and modules that programs use are named after the file",
                   f"include {is_now} in {was}, or move the declaration back to {was}",
                   new=new.facts, old=old.facts)  # fmt: skip


def _one(sides: Sides, old: AnyDeclaration, new: AnyDeclaration, report: Report) -> None:
    match old, new:
        case Struct(), Struct():
            _struct(sides, old, new, report)
        case Bitmask(), Bitmask():
            flags = [{f.name: f.position for f in m.flags} for m in (old, new)]
            if flags[0] != flags[1] or old.bit_bound != new.bit_bound:
                _refused(old, new, "flags", report)
        case Bitset(), Bitset():
            _bitset(sides, old, new, report)
        case Union(), Union():
            _union(sides, old, new, report)
        case Typedef(), Typedef():
            _typedef(sides, old, new, report)
        case Constant(), Constant():
            if old.value != new.value or not sides.same_type(old.type, new.type):
                was, is_now = repr(old.value), repr(new.value)
                if not sides.same_type(old.type, new.type):
                    was = f"{wire_text(sides.old, old.type)} {was}"
                    is_now = f"{wire_text(sides.new, new.type)} {is_now}"
                report.add("G1102", old.name,
                           f"constant '{old.name}' was {was} and is now {is_now}",
                           "programs that were built before the change use the old value",
                           "keep the constant, and declare another constant", new=new.facts,
                           old=old.facts)  # fmt: skip


def _struct(sides: Sides, old: Struct, new: Struct, report: Report) -> None:
    if old.extensibility != new.extensibility:
        report.add("G1002", old.name,
                   f"'{old.name}' was @{old.extensibility.value} "
                   f"and is now @{new.extensibility.value}",
                   _MISREAD, "keep the old struct, and declare another struct", new=new.facts,
                   old=old.facts)  # fmt: skip
    owner = slots.Owner(old.name, "member", old.is_appendable and new.is_appendable,
                        old.facts, new.facts)  # fmt: skip
    slots.compare(sides, report, owner, sides.old.all_members(old), sides.new.all_members(new))
    bases = [_base(m, s) for m, s in ((sides.old, old), (sides.new, new))]
    if bases[0] != bases[1] and not report.has_broken(old.name):
        report.add("G1102", old.name,
                   f"'{old.name}' had {bases[0]} and now has {bases[1]}",
                   "C++ programs that use a value of the struct as one of its base, or initialise "
                   "its members in order, do not build any more", "keep the base as it was",
                   new=new.facts, old=old.facts)  # fmt: skip
    if old.maps_to != new.maps_to:
        report.add("G1102", old.name, f"'{old.name}' maps to another hand-written type now",
                   "existing programs handle values of the struct as the old hand-written type",
                   "keep @maps_to", new=new.facts, old=old.facts)  # fmt: skip


def _base(model: Model, struct: Struct) -> str:
    """Returns a text that names the base of a struct. A renamed base has the name that its @hash_as
    keeps."""
    if struct.base is None:
        return "no base"
    base = model.struct(struct.base)
    return f"the base '{hashed_name(model, base.name, base.facts)}'"


def _refused(old: AnyDeclaration, new: AnyDeclaration, what: str, report: Report) -> None:
    report.add("G1004", old.name, f"the {what} of '{old.name}' have changed",
               "a reader refuses bits that it does not know",
               "keep the type, and declare another type", new=new.facts, old=old.facts)  # fmt: skip


def _enum(old: EnumDeclaration, new: EnumDeclaration, exact: str, report: Report) -> None:
    """Compares two versions of an enum. `exact` is the reason why readers refuse unknown
    enumerators even if the enum has a @default_literal; see `read_exactly` in sides.py. If readers
    accept unknown enumerators, `exact` is ""."""
    if old.default_literal != new.default_literal:
        report.add("G1004", old.name,
                   f"unknown enumerators of '{old.name}' were read as "
                   f"{old.default_literal or 'an error'} and are now read as "
                   f"{new.default_literal or 'an error'}",
                   "the hash of every operation that uses the enum differs, so old and new "
                   "programs refuse each other", "keep @default_literal as it was", new=new.facts,
                   old=old.facts)  # fmt: skip
    default = old.default_literal is not None and new.default_literal is not None
    grows = default and not exact
    refuse = f"refuse it, because {exact}" if default else "refuse it"
    before = {e.name: e for e in old.enumerators}
    after = {e.name: e for e in new.enumerators}
    numbers = {e.number: e for e in new.enumerators}
    for name, was in before.items():
        now = after.get(name)
        if now is not None and now.number != was.number:
            report.add("G1004", old.name,
                       f"'{name}' of '{old.name}' was {was.number} and is now {now.number}",
                       "old and new programs read the same number as different enumerators",
                       "keep the number with @value, and put new enumerators at the end",
                       new=now.facts, old=was.facts)  # fmt: skip
        elif now is None and not grows:
            report.add("G1004", old.name, f"'{name}' of '{old.name}' is gone",
                       f"old programs still send the enumerator, and new programs {refuse}",
                       "keep the declaration and mark it @deprecated", new=new.facts,
                       old=was.facts)  # fmt: skip
        elif now is None and was.number in numbers:
            taken = numbers[was.number]
            report.add("G1004", old.name,
                       f"number {was.number} of '{old.name}' was '{name}' and is now "
                       f"'{taken.name}'",
                       "old and new programs read the same number as different enumerators",
                       f"keep '{name}', and give '{taken.name}' a number of its own",
                       new=taken.facts, old=was.facts)  # fmt: skip
        elif now is None:
            report.add("G1101", old.name, f"'{name}' of '{old.name}' is gone",
                       f"{_NO_BUILD}; old programs send the enumerator, and new programs read "
                       f"'{new.default_literal}'",
                       "keep the declaration and mark it @deprecated", new=new.facts,
                       old=was.facts)  # fmt: skip
    for name, now in after.items():
        if name not in before and not grows:
            report.add("G1004", old.name, f"'{name}' of '{old.name}' is new",
                       f"old programs {refuse}" if default else
                       "old programs refuse the new enumerator",
                       "declare a new enum, and a new union or member with it" if default else
                       "declare a new enum with @default_literal, which readers use for unknown "
                       "enumerators",
                       new=now.facts)  # fmt: skip


def _bitset(sides: Sides, old: Bitset, new: Bitset, report: Report) -> None:
    before, after = sides.old.all_fields(old), sides.new.all_fields(new)
    bits = [[(f.name, f.position, f.width) for f in fields] for fields in (before, after)]
    if bits[0] != bits[1]:
        _refused(old, new, "fields", report)
        return
    for one, other in zip(before, after, strict=True):
        was, is_now = one.type.kind, other.type.kind
        if one.name is None or was is is_now or {was, is_now} == {Primitive.OCTET, Primitive.UINT8}:
            continue  # the generated code is the same
        what = f"field '{one.name}' of '{old.name}'"
        if one.is_signed != other.is_signed:
            report.add("G1004", old.name, f"{what} was {was.value} and is now {is_now.value}",
                       "old and new programs read the same bits as different numbers",
                       "keep the type of the field, and declare another bitset",
                       new=other.facts, old=one.facts)  # fmt: skip
        else:
            report.add("G1102", old.name, f"{what} was {was.value} and is now {is_now.value}",
                       "programs that use the field do not build any more, or compute with "
                       "another type", "keep the type of the field",
                       new=other.facts, old=one.facts)  # fmt: skip


def _union(sides: Sides, old: Union, new: Union, report: Report) -> None:
    became = {case.member.name: case.member for case in new.cases}
    for case in old.cases:
        member = became.get(case.member.name)
        if member is not None:
            what = f"member '{member.name}' of '{old.name}'"
            slots.secrecy(report, old.name, what, case.member, member)
    texts = []
    for model, union in ((sides.old, old), (sides.new, new)):
        arms = [
            (
                sorted(str(getattr(v, "number", v)) for v in case.labels),
                case.is_default,
                case.member.name,
                wire_text(model, case.member.type),
            )
            for case in union.cases
        ]
        texts.append((union.extensibility, wire_text(model, union.discriminator), arms))
    if texts[0] != texts[1]:
        report.add("G1004", old.name, f"the cases of '{old.name}' have changed",
                   "a reader refuses a case that it does not know",
                   "keep the union, and declare another union", new=new.facts,
                   old=old.facts)  # fmt: skip
        return
    for one, other in zip(old.cases, new.cases, strict=True):
        what = f"member '{other.member.name}' of '{old.name}'"
        numbers = slots.Numbers.of(one.member), slots.Numbers.of(other.member)
        places = other.member.facts, one.member.facts
        slots.meaning(sides, report, old.name, what, numbers, places)


def _typedef(sides: Sides, old: Typedef, new: Typedef, report: Report) -> None:
    was, is_now = wire_text(sides.old, old.type), wire_text(sides.new, new.type)
    what = f"type '{old.name}'"
    if was != is_now:
        report.add("G1102", old.name, f"{what} was {was} and is now {is_now}",
                   "programs that use the type do not build any more, or compute with another type",
                   "keep the type, and declare another type",
                   new=new.facts, old=old.facts)  # fmt: skip
        return
    numbers = slots.Numbers.of(old), slots.Numbers.of(new)
    slots.meaning(sides, report, old.name, what, numbers, (new.facts, old.facts))
