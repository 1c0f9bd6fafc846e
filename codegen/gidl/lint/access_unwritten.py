"""Lint: an operation should declare who may call it, instead of relying on the default."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model, Operation
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if member.access_written:
            continue
        applies, what = _unwritten(member)
        findings.warning(
            "G0902",
            member.facts.location,
            f"{what} '{member.name}' does not say who may use it",
            f"write @sensor, @actor or @master; the default here is @{applies}",
        )


def _unwritten(member: Operation | Attribute) -> tuple[str, str]:
    if isinstance(member, Operation):
        what = "event" if member.is_event else "operation"
        return member.access.name.lower(), what
    if member.streams_in or member.has_setter:
        return member.write_access.name.lower(), "attribute"
    return member.read_access.name.lower(), "attribute"
