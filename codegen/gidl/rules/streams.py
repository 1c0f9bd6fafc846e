"""Rules for streams: their direction, their watchdog, and the requirements of an open stream."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model, NamedType, Struct
from gidl.model.policy import QualityClass
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
        if member.stream.is_open:
            _open(model, member, findings)


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
            "only a stream that clients send can have a watchdog; the server publishes this one",
            "leave out 'watchdog'",
        )


def _open(model: Model, attribute: Attribute, findings: Findings) -> None:
    at = attribute.facts.place_of("open_stream")
    target = model.target(attribute.type)
    declaration = model.find(target.name) if isinstance(target, NamedType) else None
    if attribute.streams_in:
        findings.error("G0411", at, "only a stream that the server publishes can be an open stream")
    elif not isinstance(declaration, Struct) or declaration.is_appendable:
        findings.error(
            "G0411",
            at,
            f"samples of an open stream are plain LCM messages, but '{attribute.name}' is not "
            "a final struct",
            "use a struct that is not @appendable",
        )
    if attribute.qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        findings.error(
            "G0411",
            at,
            "an open stream is not authenticated, so it never satisfies a real-time class",
            "leave out '@open_stream', or the class in '@qos'",
        )
