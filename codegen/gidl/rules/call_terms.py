"""Rule: an annotation that says how a call runs must fit the kind of the call: sensor operation,
actor operation or getter."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model, Operation
from gidl.model.policy import Access
from gidl.rules.walk import members

_OF_ACTORS = ("on_new", "parallel", "on_loss")


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if isinstance(member, Attribute):
            _attribute(member, findings)
        elif not member.is_event:
            _operation(member, findings)


def _operation(operation: Operation, findings: Findings) -> None:
    facts = operation.facts
    if operation.access is Access.SENSOR:
        for annotation in _OF_ACTORS:
            if facts.has(annotation):
                findings.error(
                    "G0408",
                    facts.place_of(annotation),
                    f"'@{annotation}' needs an actor command, but '{operation.name}' is a sensor "
                    "operation",
                    "leave out the annotation, or write @actor",
                )
        if facts.has("presence"):
            findings.error(
                "G0408",
                facts.place_of("presence"),
                f"'@presence' is not allowed on '{operation.name}': a sensor operation never needs "
                "presence",
                "leave out '@presence'",
            )
    elif operation.ordered:
        findings.error(
            "G0408",
            facts.place_of("ordered"),
            f"'@ordered' is not allowed on '{operation.name}': actor operations are always in "
            "order",
            "leave out '@ordered'",
        )


def _attribute(attribute: Attribute, findings: Findings) -> None:
    writes = attribute.has_setter or attribute.streams_in
    if attribute.facts.has("presence") and not writes:
        findings.error(
            "G0408",
            attribute.facts.place_of("presence"),
            f"'@presence' is not allowed on '{attribute.name}': reading never needs presence",
            "leave out '@presence'",
        )
