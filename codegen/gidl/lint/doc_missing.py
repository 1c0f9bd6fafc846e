"""Lint: interfaces, operations and events should have a comment for the caller."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Model


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        if not interface.facts.doc:
            findings.warning(
                "G0907",
                interface.facts.location,
                f"interface '{interface.simple_name}' has no comment",
                "before the interface, write a comment /** ... */ that says what the interface is "
                "for",
            )
        for operation in (*interface.operations, *interface.events):
            if not operation.facts.doc:
                what = "event" if operation.is_event else "operation"
                advice = (
                    "before the operation, write a comment /** ... */ that says what the "
                    "operation does, and when the server refuses it"
                )
                if operation.is_event:
                    advice = (
                        "before the event, write a comment /** ... */ that says when the event "
                        "occurs"
                    )
                findings.warning(
                    "G0907",
                    operation.facts.location,
                    f"{what} '{operation.name}' has no comment",
                    advice,
                )
