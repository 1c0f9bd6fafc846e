"""Advice on valid interfaces. Each rule is a module, with a code and a folder of tests.

Each rule checks the whole model, but only findings in the files that the user asked for are
reported. An author can confirm an exception from a rule in the interface: for example, `@unit("1")`
marks a number without a unit.
"""

from __future__ import annotations

from collections.abc import Callable

from gidl.diagnostics.findings import Finding, Findings
from gidl.lint import (
    access_unwritten,
    best_effort_actor,
    deprecated_used,
    doc_missing,
    extensibility_unwritten,
    literal_for_unknown,
    non_si_unit,
    stream_without_rate,
    unit_missing,
    unused_include,
    version_missing,
    watchdog_missing,
)
from gidl.model import Model

Rule = Callable[[Model, Findings], None]

ALL: tuple[Rule, ...] = (
    unit_missing.check,
    access_unwritten.check,
    best_effort_actor.check,
    stream_without_rate.check,
    non_si_unit.check,
    deprecated_used.check,
    doc_missing.check,
    version_missing.check,
    watchdog_missing.check,
    extensibility_unwritten.check,
    literal_for_unknown.check,
    unused_include.check,
)


def lint(model: Model) -> list[Finding]:
    """Returns the findings of all rules about the files that the user asked for."""
    findings = Findings()
    for rule in ALL:
        rule(model, findings)
    wanted = [file.path for file in model.files if file.asked_for]
    return [
        finding
        for finding in findings.in_order(wanted)
        if finding.location is not None and finding.location.file in wanted
    ]
