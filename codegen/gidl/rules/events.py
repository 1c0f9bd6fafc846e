"""Rule: an event must be oneway, because the server sends it. An event must not have annotations
that are for calls."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Model, Operation
from gidl.rules.walk import members

_OF_CALLS = ("safety", "idempotent", "on_new", "parallel", "ordered", "on_loss", "presence")


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if not (isinstance(member, Operation) and member.is_event):
            continue
        if not member.oneway:
            findings.error(
                "G0406",
                member.facts.place_of("event"),
                f"event '{member.name}' is not oneway",
                f"write 'oneway void {member.name}(...)'",
            )
        for annotation in _OF_CALLS:
            if member.facts.has(annotation):
                findings.error(
                    "G0406",
                    member.facts.place_of(annotation),
                    f"'@{annotation}' is not allowed on an event, because the server sends events",
                    "leave out the annotation",
                )
