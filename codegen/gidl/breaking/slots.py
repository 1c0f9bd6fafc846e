"""Compares old and new slots. A slot is a member of a struct, or a parameter of an operation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gidl.breaking.report import Report
from gidl.breaking.sides import Sides, Slot, ranges, units, wire_text
from gidl.model import Attribute, Facts, Member, Model, Parameter, Range, Type, Typedef

_MISREAD = "old and new programs read each other's bytes wrongly"


@dataclass(frozen=True, slots=True)
class Owner:
    """The struct whose members are compared, or the operation whose parameters are compared."""

    subject: str  # scoped name of the struct or operation
    what: str  # the word for a slot in messages: "member" or "parameter"
    grows: bool
    old: Facts
    new: Facts


@dataclass(frozen=True, slots=True)
class Numbers:
    """The type of a slot, and the unit and the range that the slot declares for the numbers in a
    value of this type."""

    type: Type
    unit: str | None
    range: Range | None

    @classmethod
    def of(cls, slot: Slot | Attribute | Typedef) -> Numbers:
        return cls(slot.type, slot.unit, slot.range)


def compare(
    sides: Sides, report: Report, owner: Owner, old: Sequence[Slot], new: Sequence[Slot]
) -> None:
    before = {_key(s): s for s in old}
    after = {_key(s): s for s in new}
    kept = [k for k in before if k in after]
    if kept != [k for k in after if k in before]:
        report.add(
            "G1002", owner.subject,
            f"the {owner.what}s of '{owner.subject}' are in another order", _MISREAD,
            "restore the old order", new=owner.new, old=owner.old,
        )  # fmt: skip
    gone = _gone(report, owner, list(before.values()), after)
    _added(report, owner, list(after.values()), before, gone)
    for key in kept:
        _kept(sides, report, owner, before[key], after[key], _leaves_core(owner, old, new, key))


def _key(slot: Slot) -> str:
    return slot.facts.hash_as or slot.name if isinstance(slot, Member) else slot.name


def _may_be_left_out(slot: Slot) -> bool:
    return slot.optional or slot.default is not None


def _leaves_core(owner: Owner, old: Sequence[Slot], new: Sequence[Slot], key: str) -> bool:
    """Returns whether a writer may leave out the slot in one of the two versions but not in the
    other version."""
    return owner.grows and (key in _tail(old)) != (key in _tail(new))


def _tail(slots: Sequence[Slot]) -> set[str]:
    tail: set[str] = set()
    for slot in reversed(slots):
        if not _may_be_left_out(slot):
            break
        tail.add(_key(slot))
    return tail


def _gone(report: Report, owner: Owner, old: list[Slot], after: dict[str, Slot]) -> set[str]:
    gone = {_key(s) for s in old if _key(s) not in after}
    for index, slot in enumerate(old):
        if _key(slot) not in gone:
            continue
        at_end = all(_key(s) in gone for s in old[index:])
        if owner.grows and at_end and _may_be_left_out(slot):
            if all(_key(s) in {_key(o) for o in old} for s in after.values()):
                report.add(
                    "G1101", owner.subject,
                    f"{owner.what} '{slot.name}' of '{owner.subject}' is gone",
                    "programs that use the old name do not build any more",
                    "keep the declaration and mark it @deprecated", new=owner.new, old=slot.facts,
                )  # fmt: skip
                continue
            instead = "keep the old declaration, and put new declarations after it"
        else:
            instead = (
                "keep the declaration and mark it @deprecated; if you renamed it, write "
                '@hash_as("old_name")'
            )
        report.add(
            "G1002", owner.subject, f"{owner.what} '{slot.name}' of '{owner.subject}' is gone",
            _MISREAD, instead, new=owner.new, old=slot.facts,
        )  # fmt: skip
    return gone


def _added(
    report: Report, owner: Owner, new: list[Slot], before: dict[str, Slot], gone: set[str]
) -> None:
    for index, slot in enumerate(new):
        if _key(slot) in before or gone:
            continue  # the new slot may replace a removed one, which is already reported
        what = f"{owner.what} '{slot.name}' of '{owner.subject}'"
        at_end = all(_key(s) not in before for s in new[index:])
        if not owner.grows:
            report.add(
                "G1002", owner.subject, f"{what} is new, and '{owner.subject}' is @final", _MISREAD,
                "declare another struct that contains this struct", new=slot.facts,
            )  # fmt: skip
        elif not at_end:
            report.add(
                "G1002", owner.subject, f"{what} is new, but not at the end", _MISREAD,
                "put the new declaration at the end, with @default or @optional", new=slot.facts,
            )  # fmt: skip
        elif not _may_be_left_out(slot):
            report.add(
                "G1003", owner.subject, f"{what} is new and required",
                "messages of old programs do not contain the new value",
                "write @default(...) or @optional before the new declaration",
                new=slot.facts,
            )  # fmt: skip


def _kept(
    sides: Sides, report: Report, owner: Owner, old: Slot, new: Slot, leaves_core: bool
) -> None:
    what = f"{owner.what} '{new.name}' of '{owner.subject}'"
    subject, places = owner.subject, (new.facts, old.facts)
    if old.name != new.name:
        report.add("G1101", subject, f"{what} was named '{old.name}' before",
                   "programs that use the old name do not build any more", "keep the name",
                   new=places[0], old=places[1])  # fmt: skip
    if isinstance(old, Parameter) and isinstance(new, Parameter) and old.direction != new.direction:
        report.add("G1002", subject,
                   f"{what} was '{old.direction.value}' and is now '{new.direction.value}'",
                   _MISREAD, "declare another operation", new=places[0], old=places[1])  # fmt: skip
    same_type = value(sides, report, subject, what, (old.type, new.type),
                      (old.optional, new.optional), places)  # fmt: skip
    if same_type:
        meaning(sides, report, subject, what, (Numbers.of(old), Numbers.of(new)), places)
    had, has = old.default is not None, new.default is not None
    if leaves_core and old.optional == new.optional:
        report.add("G1002", subject,
                   f"one version allows messages without {what}, and the other does not",
                   "the hashes of operations differ, so old and new programs refuse each other",
                   "write @default or @optional exactly where the old version has it, and add no "
                   "required declaration after this one",
                   new=places[0], old=places[1])  # fmt: skip
    elif had and not has and not new.optional:
        report.add("G1102", subject, f"{what} has no default any more",
                   "programs that leave the value out do not build any more", "keep @default",
                   new=places[0], old=places[1])  # fmt: skip
    elif same_type and had and has and _text(old.default) != _text(new.default):
        report.add("G1102", subject,
                   f"the default of {what} was {_text(old.default)} "
                   f"and is now {_text(new.default)}",
                   "programs that leave the value out get the new default", "keep the default",
                   new=places[0], old=places[1])  # fmt: skip
    secrecy(report, subject, what, old, new)


def secrecy(report: Report, subject: str, what: str, old: Slot, new: Slot) -> None:
    """Reports a value that was @secret and is not @secret any more."""
    if old.secret and not new.secret:
        report.add("G1302", subject, f"{what} is not @secret any more",
                   "the value is now printed, logged and recorded", "keep @secret",
                   new=new.facts, old=old.facts)  # fmt: skip


def _text(default: object) -> str:
    return str(getattr(default, "literal", default))


def value(
    sides: Sides,
    report: Report,
    subject: str,
    what: str,
    types: tuple[Type | None, Type | None],
    optional: tuple[bool, bool],
    places: tuple[Facts, Facts],
) -> bool:
    """Compares the old and the new value, reports a difference, and returns whether their encodings
    are the same."""
    was, is_now = wire_text(sides.old, types[0]), wire_text(sides.new, types[1])
    if was != is_now:
        report.add("G1002", subject, f"{what} was {was} and is now {is_now}", _MISREAD,
                   "keep the old declaration, and add a new declaration with another name",
                   new=places[0], old=places[1])  # fmt: skip
        return False
    if optional[0] != optional[1]:
        now = "may be absent" if optional[1] else "is always there"
        report.add("G1002", subject, f"{what} {now} now", _MISREAD,
                   "keep @optional as it was", new=places[0], old=places[1])  # fmt: skip
        return False
    return True


def meaning(
    sides: Sides,
    report: Report,
    subject: str,
    what: str,
    numbers: tuple[Numbers, Numbers],
    places: tuple[Facts, Facts],
) -> None:
    """Reports a changed unit or range of the numbers in a value whose encoding is unchanged."""
    old, new = numbers
    unit = _units(sides.old, old), _units(sides.new, new)
    if unit[0] != unit[1]:
        report.add("G1006", subject,
                   f"{what} was in '{unit[0] or 'no unit'}' and is now in '{unit[1] or 'no unit'}'",
                   "old and new programs read the same number in different units",
                   "keep the unit, and add another declaration with the new unit",
                   new=places[0], old=places[1])  # fmt: skip
    was = ranges(sides.old, old.type, old.range)
    is_now = ranges(sides.new, new.type, new.range)
    for part in sorted(was.keys() | is_now.keys()):
        bounds(report, subject, part + what, (was.get(part), is_now.get(part)), places)


def _units(model: Model, numbers: Numbers) -> str:
    return numbers.unit or units(model, numbers.type).strip(",")


def bounds(
    report: Report,
    subject: str,
    what: str,
    limits: tuple[Range | None, Range | None],
    places: tuple[Facts, Facts],
) -> None:
    """Reports a changed range of numbers."""
    if limits[0] != limits[1]:
        report.add("G1006", subject,
                   f"the range of {what} was {_bounds(limits[0])} and is now {_bounds(limits[1])}",
                   "one of the programs may send values that the other program refuses",
                   "keep the range, and add another declaration with the new range",
                   new=places[0], old=places[1])  # fmt: skip


def _bounds(bounds: Range | None) -> str:
    if bounds is None:
        return "unlimited"
    if bounds.maximum is None:
        return f"at least {bounds.minimum}"
    if bounds.minimum is None:
        return f"at most {bounds.maximum}"
    return f"{bounds.minimum} to {bounds.maximum}"
