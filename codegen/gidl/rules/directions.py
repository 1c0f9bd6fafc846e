"""Rule: only an `in` parameter may have a default; an operation with @unit or @optional must have a
result."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Direction, Model, Operation
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if not isinstance(member, Operation):
            continue
        for parameter in member.parameters:
            if parameter.default is not None and parameter.direction is not Direction.IN:
                findings.error(
                    "G0508",
                    parameter.facts.place_of("default"),
                    f"the {parameter.direction.value} parameter '{parameter.name}' cannot have a "
                    "default",
                    "leave out the default: only an 'in' parameter can have a default, because "
                    "only the caller may leave out a value",
                )
        if member.result is None and member.facts.has("unit"):
            findings.error(
                "G0509",
                member.facts.place_of("unit"),
                f"'{member.name}' has @unit, but no result",
            )
        if member.result is None and member.facts.has("optional"):
            findings.error(
                "G0508",
                member.facts.place_of("optional"),
                f"'{member.name}' has @optional, but no result",
            )
