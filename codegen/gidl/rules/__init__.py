"""Semantic rules that every model must satisfy. Each rule is a module."""

from __future__ import annotations

from collections.abc import Callable

from gidl.diagnostics.findings import Findings
from gidl.model import Model
from gidl.rules import (
    accessors,
    call_terms,
    chains,
    codes,
    defaults,
    directions,
    enums,
    events,
    inheritance,
    maps,
    member_kinds,
    oneway,
    open_streams,
    quality,
    quality_below,
    recursion,
    streams,
    struct_bases,
    unions,
    units,
    versions,
)

Rule = Callable[[Model, Findings], None]

ALL: tuple[Rule, ...] = (
    inheritance.check,
    oneway.check,
    events.check,
    accessors.check,
    call_terms.check,
    streams.check,
    open_streams.check,
    quality.check,
    quality_below.check,
    recursion.check,
    chains.check,
    struct_bases.check,
    defaults.check,
    directions.check,
    units.check,
    unions.check,
    enums.check,
    maps.check,
    member_kinds.check,
    versions.check,
)


def check_all(model: Model, findings: Findings, codes_of: codes.CodesOf) -> None:
    """Checks all rules on the whole model, so that one run reports all findings."""
    for rule in ALL:
        rule(model, findings)
    codes.check(model, findings, codes_of)
