"""Rule: a base struct is not @appendable, and a derived struct does not repeat members of its
base."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Model, Struct


def check(model: Model, findings: Findings) -> None:
    for struct in model.declarations():
        if not isinstance(struct, Struct) or struct.base is None:
            continue
        base = model.struct(struct.base)
        if base.is_appendable:
            findings.error(
                "G0320",
                struct.facts.location,
                f"'{base.simple_name}' is @appendable, so it cannot be a base: members appended "
                f"to '{base.simple_name}' would move the members of '{struct.simple_name}'",
                f"declare a member of type '{base.simple_name}' instead",
                notes=(Note("the base is declared here", base.facts.location),),
            )
        inherited = {m.name.lower(): m for m in model.all_members(base)}
        for member in struct.members:
            first = inherited.get(member.name.lower())
            if first is not None:
                findings.error(
                    "G0321",
                    member.facts.location,
                    f"member '{member.name}' is already inherited from '{base.simple_name}'",
                    notes=(Note("first declared here", first.facts.location),),
                )
