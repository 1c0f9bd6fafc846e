"""Lint: a stream should declare its rate, because buffers, watchdogs and plots are designed for the
rate."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if isinstance(member, Attribute) and member.stream and member.stream.rate_hz is None:
            findings.warning(
                "G0904",
                member.facts.place_of("stream"),
                f"stream '{member.name}' declares no rate",
                'write the intended rate, for example @stream(rate="250Hz")',
            )
