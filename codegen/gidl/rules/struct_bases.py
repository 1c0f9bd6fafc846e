"""Rule: a base struct is not @appendable, and a derived struct or bitset does not repeat members or
fields of its base."""

from __future__ import annotations

from collections.abc import Sequence

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Bitfield, Bitset, Member, Model, Struct


def check(model: Model, findings: Findings) -> None:
    for derived in model.declarations():
        if isinstance(derived, Struct) and derived.base is not None:
            base = model.struct(derived.base)
            _appendable(derived, base, findings)
            inherited = model.all_members(base)
            _repeated("member", derived.members, base.simple_name, inherited, findings)
        if isinstance(derived, Bitset) and derived.base is not None:
            bits = model.find(derived.base)
            assert isinstance(bits, Bitset)
            inherited_fields = model.all_fields(bits)
            _repeated("field", derived.fields, bits.simple_name, inherited_fields, findings)


def _appendable(derived: Struct, base: Struct, findings: Findings) -> None:
    if base.is_appendable:
        findings.error(
            "G0320",
            derived.facts.location,
            f"'{base.simple_name}' is @appendable, so it cannot be a base: members appended "
            f"to '{base.simple_name}' would move the members of '{derived.simple_name}'",
            f"declare a member of type '{base.simple_name}' instead",
            notes=(Note("the base is declared here", base.facts.location),),
        )


def _repeated(
    what: str,
    own: Sequence[Member | Bitfield],
    base: str,
    inherited: Sequence[Member | Bitfield],
    findings: Findings,
) -> None:
    """Reports the members or fields in `own` whose names are among `inherited`. A field without a
    name repeats nothing."""
    known = {each.name.lower(): each for each in inherited if each.name is not None}
    for each in own:
        first = None if each.name is None else known.get(each.name.lower())
        if first is not None:
            findings.error(
                "G0321",
                each.facts.location,
                f"{what} '{each.name}' is already inherited from '{base}'",
                f"give the {what} another name, or leave it out",
                notes=(Note("first declared here", first.facts.location),),
            )
