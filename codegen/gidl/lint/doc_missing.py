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
                "write before it a comment /** ... */ that says what the interface is for",
            )
        for operation in (*interface.operations, *interface.events):
            if not operation.facts.doc:
                what = "event" if operation.is_event else "operation"
                about = "that says what the operation does, and when it is refused"
                if operation.is_event:
                    about = "that says when the event occurs"
                findings.warning(
                    "G0907",
                    operation.facts.location,
                    f"{what} '{operation.name}' has no comment",
                    f"write before it a comment /** ... */ {about}",
                )
