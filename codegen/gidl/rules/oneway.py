"""Rule: a oneway operation has no reply, so it has no result, no `out` parameter, no exception and
no cancellation."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Direction, Model, Operation
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if not (isinstance(member, Operation) and member.oneway):
            continue
        name = f"{'event' if member.is_event else 'oneway operation'} '{member.name}'"
        advice = "leave it out" if member.is_event else "leave out 'oneway'"
        if member.result is not None:
            findings.error(
                "G0404", member.facts.location, f"{name} cannot have a result", "write void"
            )
        for parameter in member.parameters:
            if parameter.direction is not Direction.IN:
                findings.error(
                    "G0404",
                    parameter.facts.location,
                    f"{name} cannot have the {parameter.direction.value} parameter "
                    f"'{parameter.name}'",
                    f"there is no reply: write 'in', or {advice}",
                )
        if member.raises:
            findings.error("G0404", member.facts.location, f"{name} cannot raise", advice)
        if member.cancelable:
            findings.error(
                "G0404",
                member.facts.place_of("cancelable"),
                f"{name} cannot be cancelable, because its caller gets no reply",
                advice,
            )
