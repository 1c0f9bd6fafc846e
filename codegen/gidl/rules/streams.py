"""Rules for streams: their direction and their watchdog."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if not isinstance(member, Attribute):
            continue
        if member.stream is None:
            if member.facts.has("open_stream"):
                findings.error(
                    "G0410",
                    member.facts.place_of("open_stream"),
                    f"attribute '{member.name}' has no @stream, so it cannot have @open_stream",
                    'write @stream(rate="...") as well',
                )
            continue
        _direction(member, findings)


def _direction(attribute: Attribute, findings: Findings) -> None:
    assert attribute.stream is not None
    facts = attribute.facts
    if attribute.streams_in:
        if attribute.readonly:
            findings.error(
                "G0410",
                facts.place_of("stream"),
                f"clients send '{attribute.name}', so it cannot be readonly",
                "leave out 'readonly', or write dir=\"out\"",
            )
        if attribute.get_raises or attribute.set_raises:
            findings.error(
                "G0410",
                facts.location,
                f"'{attribute.name}' is sent continuously by clients, so it cannot raise "
                "exceptions",
            )
    elif attribute.stream.watchdog_ns is not None:
        findings.error(
            "G0410",
            facts.place_of("stream"),
            "only a stream that clients send can have a watchdog; the server publishes this stream",
            "leave out 'watchdog'",
        )
