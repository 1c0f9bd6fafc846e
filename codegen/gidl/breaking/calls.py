"""Compares interfaces: their bases, operations, attributes and promises."""

from __future__ import annotations

from gidl.breaking import promises, slots
from gidl.breaking.report import Report
from gidl.breaking.sides import Call, Sides, reached
from gidl.model import Attribute, Interface, Operation, Type
from gidl.wire import hashes
from gidl.wire.function_codes import call_code, hashed_name

_REFUSED = "old and new programs refuse each other's calls of the changed operation or attribute"
_BESIDE = "keep the old declaration, and add a new declaration with another name"


def compare(sides: Sides, report: Report) -> None:
    for old, new in sides.declarations():
        if isinstance(old, Interface) and isinstance(new, Interface):
            _bases(sides, old, new, report)
            told = promises.interface(old, new, report)
            for before, after in sides.calls(old, new):
                if after is None:
                    _gone(before, new, report)
                else:
                    _call(sides, before, after, told, report)


def _bases(sides: Sides, old: Interface, new: Interface, report: Report) -> None:
    names = [
        {hashed_name(m, b, m.find(b).facts) for b in i.all_bases}
        for m, i in ((sides.old, old), (sides.new, new))
    ]
    for base in sorted(names[0] - names[1]):
        report.add("G1001", old.name, f"'{new.name}' does not inherit '{base}' any more",
                   "old clients do not find the inherited operations", "keep the base",
                   new=new.facts, old=old.facts)  # fmt: skip


def _gone(old: Call, new: Interface, report: Report) -> None:
    what = "attribute" if isinstance(old, Attribute) else "operation"
    report.add("G1001", old.scoped_name, f"{what} '{old.scoped_name}' is gone",
               "calls of old clients fail on a new server with UNKNOWN_OPERATION",
               "keep the declaration and mark it @deprecated; if you renamed it, write "
               "@hash_as(\"old_name\")",
               new=new.facts, old=old.facts)  # fmt: skip


def _call(sides: Sides, old: Call, new: Call, told: frozenset[str], report: Report) -> None:
    subject, places = old.scoped_name, (new.facts, old.facts)
    if old.name != new.name:
        report.add("G1101", subject, f"'{new.scoped_name}' was named '{old.name}' before",
                   "programs that use the old name do not build any more", "keep the name",
                   new=places[0], old=places[1])  # fmt: skip
    codes = call_code(sides.old, old), call_code(sides.new, new)
    if codes[0] != codes[1] or old.id != new.id:
        report.add("G1005", subject,
                   f"'{subject}' had the function code {codes[0]} and now has {codes[1]}",
                   "calls between old and new programs fail with UNKNOWN_OPERATION",
                   "keep @id as it was",
                   new=places[0], old=places[1])  # fmt: skip
    if isinstance(old, Operation) and isinstance(new, Operation):
        _operation(sides, old, new, report)
    elif isinstance(old, Attribute) and isinstance(new, Attribute):
        _attribute(sides, old, new, report)
    else:
        _kind(report, old, new, *("an attribute" if isinstance(m, Attribute) else "an operation"
                                  for m in (old, new)))  # fmt: skip
        return
    promises.call(old, new, told, report)
    _hash(sides, old, new, report)


def _kind(report: Report, old: Call, new: Call, was: str, is_now: str) -> None:
    report.add("G1002", old.scoped_name, f"'{old.scoped_name}' was {was} and is now {is_now}",
               _REFUSED, _BESIDE, new=new.facts, old=old.facts)  # fmt: skip


def _operation(sides: Sides, old: Operation, new: Operation, report: Report) -> None:
    subject, places = old.scoped_name, (new.facts, old.facts)
    was, is_now = _way(old), _way(new)
    if was != is_now:
        _kind(report, old, new, was, is_now)
    owner = slots.Owner(subject, "parameter", True, old.facts, new.facts)
    slots.compare(sides, report, owner, old.parameters, new.parameters)
    what = f"the result of '{subject}'"
    if slots.value(sides, report, subject, what, (old.result, new.result),
                   (old.result_optional, new.result_optional), places):  # fmt: skip
        before, after = _result(old), _result(new)
        if before is not None and after is not None:
            slots.meaning(sides, report, subject, what, (before, after), places)
    _outputs(old, new, report)
    _raises(sides, old, new, (old.raises, new.raises), "", report)
    if old.feedback is not None and not sides.same_type(old.feedback, new.feedback):
        is_now = new.feedback.name if new.feedback else "absent"
        report.add("G1002", subject,
                   f"the feedback of '{subject}' was {old.feedback.name} and is now {is_now}",
                   "old clients cannot decode the feedback",
                   "keep the type of the feedback, and add members at the end of this type",
                   new=places[0], old=places[1])  # fmt: skip


def _outputs(old: Operation, new: Operation, report: Report) -> None:
    """Reports a new optional `out` parameter that changes what a call returns. A call with one
    value in its reply returns this value, a call with several values returns a struct of them. To
    such a struct, a new parameter only adds a member."""
    if len(old.outputs) + (old.result is not None) > 1 or report.has_broken(old.scoped_name):
        return
    names = {p.name for p in old.parameters}
    for p in new.outputs:
        if p.name not in names:
            report.add("G1102", old.scoped_name,
                       f"the {p.direction.value} parameter '{p.name}' of '{old.scoped_name}' is "
                       "new, so a call returns another type",
                       "clients that use the result do not build any more, and neither do servers",
                       "add another operation that returns the new value", new=p.facts)  # fmt: skip
            return


def _result(operation: Operation) -> slots.Numbers | None:
    if operation.result is None:
        return None
    return slots.Numbers(operation.result, operation.result_unit, operation.result_range)


def _way(operation: Operation) -> str:
    if operation.is_event:
        return "an event"
    return "a oneway operation" if operation.oneway else "an operation with a reply"


def _attribute(sides: Sides, old: Attribute, new: Attribute, report: Report) -> None:
    subject, places = old.scoped_name, (new.facts, old.facts)
    was, is_now = _use(old), _use(new)
    if was != is_now:
        _kind(report, old, new, was, is_now)
    what = f"attribute '{subject}'"
    if slots.value(sides, report, subject, what, (old.type, new.type),
                   (old.optional, new.optional), places):  # fmt: skip
        numbers = slots.Numbers.of(old), slots.Numbers.of(new)
        slots.meaning(sides, report, subject, what, numbers, places)
    _raises(sides, old, new, (old.get_raises, new.get_raises), " when it is read", report)
    _raises(sides, old, new, (old.set_raises, new.set_raises), " when it is set", report)


def _use(attribute: Attribute) -> str:
    kind = f"a {'readonly' if attribute.readonly else 'writable'} attribute"
    if attribute.stream is None:
        return f"{kind} without a stream"
    return f"{kind} with an {'inward' if attribute.streams_in else 'outward'} stream"


def _raises(
    sides: Sides,
    old: Call,
    new: Call,
    raised: tuple[tuple[str, ...], tuple[str, ...]],
    when: str,
    report: Report,
) -> None:
    names = [
        {hashed_name(m, n, m.find(n).facts) for n in r}
        for m, r in ((sides.old, raised[0]), (sides.new, raised[1]))
    ]
    for name in sorted(names[0] ^ names[1]):
        change = "now raises" if name in names[1] else "no longer raises"
        report.add("G1007", old.scoped_name,
                   f"'{old.scoped_name}' {change} '{name}'{when}", _REFUSED,
                   "add members to an @appendable exception, or add another operation",
                   new=new.facts, old=old.facts)  # fmt: skip


def _hash(sides: Sides, old: Call, new: Call, report: Report) -> None:
    """Reports a changed hash of a call if no other finding explains the change."""
    if _hashed(sides.old, old) == _hashed(sides.new, new) or report.has_broken(old.scoped_name):
        return
    names: set[str] = set()
    for used in _types(old):
        reached(sides.old, used, names)
    if not any(report.has_broken(name) for name in names):
        report.add("G1008", old.scoped_name, f"the hash of '{old.scoped_name}' has changed",
                   _REFUSED, "compare the outputs of `gidl dump` for old and new interfaces",
                   new=new.facts, old=old.facts)  # fmt: skip


def _hashed(model: object, call: Call) -> int:
    from gidl.model import Model

    assert isinstance(model, Model)
    if isinstance(call, Operation):
        return hashes.operation_hash(model, call)
    return hashes.attribute_hash(model, call)


def _types(call: Call) -> list[Type | None]:
    from gidl.model import NamedType

    if isinstance(call, Attribute):
        raised = (*call.get_raises, *call.set_raises)
        return [call.type, *(NamedType(n) for n in raised)]
    return [call.result, *(p.type for p in call.parameters), *(NamedType(n) for n in call.raises)]
