"""Lint: an interface should declare a version."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Model


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        if interface.facts.version is None:
            findings.warning(
                "G0908",
                interface.facts.location,
                f"interface '{interface.simple_name}' has no version",
                'write @version("1.0") before it',
            )
