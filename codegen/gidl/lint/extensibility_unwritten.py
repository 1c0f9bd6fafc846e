"""Lint: a struct should declare @appendable or @final. The default is @final, which cannot be
changed later."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import ExceptionStruct, Model, Struct, Union


def check(model: Model, findings: Findings) -> None:
    for declaration in model.declarations():
        if isinstance(declaration, ExceptionStruct) or not isinstance(declaration, Struct | Union):
            continue
        facts = declaration.facts
        if not (facts.has("final") or facts.has("appendable")):
            kind = "union" if isinstance(declaration, Union) else "struct"
            findings.warning(
                "G0910",
                facts.location,
                f"{kind} '{declaration.simple_name}' is declared neither @appendable nor @final",
                "write @appendable, or @final, which is the default and cannot be changed later",
            )
