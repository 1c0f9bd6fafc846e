"""Rule: function codes are unique in an object and have 32 bits, and 0 to 255 are reserved for
built-in operations."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from gidl.diagnostics.findings import Findings, Note
from gidl.model import BUILT_IN, Attribute, Interface, Model, Operation
from gidl.rules.walk import meet_first

LAST_RESERVED = 255
LAST_CODE = 0xFFFFFFFF

Member = Operation | Attribute
CodesOf = Callable[[Model, Interface], Iterable[tuple[int, str, Member]]]
"""A function that returns the function codes of the members that an interface itself declares. Each
code comes with the name from which codes and hashes are computed, and with the member."""


def check(model: Model, findings: Findings, codes_of: CodesOf) -> None:
    own = {i.name: list(codes_of(model, i)) for i in model.interfaces()}
    for interface in model.interfaces():
        for code, name, member in own[interface.name]:
            _reserved(interface, code, name, member, findings)
        _unique(model, interface, own, findings)


def _reserved(
    interface: Interface, code: int, name: str, member: Member, findings: Findings
) -> None:
    inside = code <= LAST_RESERVED
    if interface.name == BUILT_IN:
        if not 1 <= code <= LAST_RESERVED:
            findings.error(
                "G0602",
                member.facts.place_of("id"),
                f"'{name}' is a built-in operation and needs a code from 1 to {LAST_RESERVED}",
                "write @id(n) with a code that is not in use",
            )
    elif inside:
        hashed = "has" if member.facts.has("id") else "hashes to"
        findings.error(
            "G0602",
            member.facts.place_of("id"),
            f"'{name}' {hashed} the code {code}, but 0 to {LAST_RESERVED} are reserved for "
            "built-in operations",
            f"write @id(n) with n above {LAST_RESERVED}",
        )
    elif code > LAST_CODE:  # a setter, whose code is one more than the number that @id can have
        findings.error(
            "G0602",
            member.facts.place_of("id"),
            f"'{name}' would have the code {code}, but a code is at most {LAST_CODE}",
            f"write @id(n) with n below {LAST_CODE}: the setter of an attribute has the code n + 1",
        )


def _unique(
    model: Model,
    interface: Interface,
    own: dict[str, list[tuple[int, str, Member]]],
    findings: Findings,
) -> None:
    seen: dict[int, tuple[str, Member]] = {}
    for part in model.with_bases(interface):
        for code, name, member in own[part.name]:
            first = seen.setdefault(code, (name, member))
            if first[0] == name or not meet_first(
                model, interface, member.interface, first[1].interface
            ):
                continue
            is_own = interface.name in (member.interface, first[1].interface)
            findings.error(
                "G0603",
                member.facts.place_of("id") if is_own else interface.facts.location,
                f"'{name}' and '{first[0]}' have the same function code {code}",
                f"write @id(n) before one of the two declarations; n is an unused number above "
                f"{LAST_RESERVED}",
                notes=(Note("this declaration has the same code", first[1].facts.location),),
            )
