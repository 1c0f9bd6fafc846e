"""Whether a struct may grow is decided when it is written; unwritten, it never can."""

from __future__ import annotations

from gidl.diagnostics import Findings
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
                f"{kind} '{declaration.simple_name}' does not say whether it may grow",
                "write @appendable, or @final, which applies now and is for ever",
            )
