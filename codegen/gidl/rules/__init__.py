"""The rules a model obeys beyond being well formed: one file each, `check(model, findings)`."""

from __future__ import annotations

from collections.abc import Callable

from gidl.diagnostics import Findings
from gidl.model import Model

Rule = Callable[[Model, Findings], None]

ALL: tuple[Rule, ...] = ()


def check_all(model: Model, findings: Findings) -> None:
    """Every rule on the whole model, so that one run shows everything."""
    for rule in ALL:
        rule(model, findings)
