"""Rule: only an `in` parameter may have a default; an operation with an annotation that is about
its result, such as @unit, must have a result."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Direction, Model, Operation
from gidl.rules.walk import members

# The annotations of an operation that are about its result, and the codes of their findings.
_OF_A_RESULT = {
    "unit": "G0509",
    "optional": "G0508",
    "secret": "G0511",
    "range": "G0307",
    "min": "G0307",
    "max": "G0307",
}


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
        for annotation, code in _OF_A_RESULT.items():
            if member.result is None and member.facts.has(annotation):
                findings.error(
                    code,
                    member.facts.place_of(annotation),
                    f"'{member.name}' has @{annotation}, but no result",
                    f"write @{annotation} before the parameter that it is about, or leave it out",
                )
