"""Lint: a stream that clients send should have a watchdog, which limits how long the sender may be
silent."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if not isinstance(member, Attribute) or member.stream is None or not member.streams_in:
            continue
        if member.stream.watchdog_ns is None:
            findings.warning(
                "G0909",
                member.facts.place_of("stream"),
                f"stream '{member.name}' has no watchdog, which would notice a silent sender",
                'write @stream(dir="in", watchdog="48ms") with the longest silence that is safe',
            )
