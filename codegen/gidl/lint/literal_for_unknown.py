"""Lint: an enum should have a @default_literal, which old readers use for enumerators that are
added later."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import EnumDeclaration, Model, NamedType, Union


def check(model: Model, findings: Findings) -> None:
    chosen = {
        union.discriminator.name
        for union in model.declarations()
        if isinstance(union, Union) and isinstance(union.discriminator, NamedType)
    }
    for enum in model.declarations():
        if not isinstance(enum, EnumDeclaration) or enum.name in chosen:
            continue
        if enum.default_literal is None:
            findings.warning(
                "G0911",
                enum.facts.location,
                f"enum '{enum.simple_name}' has no @default_literal, so no enumerator can "
                "be added later",
                "write @default_literal before the enumerator that readers should use for "
                "unknown values",
            )
