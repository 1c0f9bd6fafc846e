"""Rule: only sequences and arrays of numbers may be @bulk, and only strings may be @secret."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import ArrayType, Model, PrimitiveType, SequenceType, StringType, Type
from gidl.rules.walk import slots


def check(model: Model, findings: Findings) -> None:
    for slot in slots(model):
        if slot.bulk and not _is_numbers(model, slot.type):
            findings.error(
                "G0510",
                slot.facts.place_of("bulk"),
                f"{slot.what} is not a sequence or array of numbers, so it cannot be @bulk",
            )
        if slot.secret and not _is_text(model, slot.type):
            findings.error(
                "G0511",
                slot.facts.place_of("secret"),
                f"{slot.what} is not a string, so it cannot be @secret",
            )


def _is_numbers(model: Model, used: Type) -> bool:
    target = model.target(used)
    if not isinstance(target, SequenceType | ArrayType):
        return False
    element = model.target(target.element)
    return isinstance(element, PrimitiveType) and element.kind.is_number


def _is_text(model: Model, used: Type) -> bool:
    return isinstance(model.target(used), StringType)
