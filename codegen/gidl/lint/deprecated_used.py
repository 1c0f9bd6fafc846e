"""Lint: a declaration that is not deprecated itself should not use a deprecated declaration."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.lint.uses import uses
from gidl.model import Model


def check(model: Model, findings: Findings) -> None:
    for file in model.files:
        for use in uses(model, file):
            used = model.find(use.name)
            reason = used.facts.deprecated
            if reason is None or use.by_deprecated:
                continue
            findings.warning(
                "G0906",
                use.facts.location,
                f"{use.what} uses '{used.name}', which is deprecated",
                reason,
                notes=(Note("declared here", used.facts.location),),
            )
