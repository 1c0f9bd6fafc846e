"""Rule: quality terms must not contradict each other, because no medium could fulfil all of
them."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Facts, Model, Operation
from gidl.model.policy import Liveliness, Qos, QualityClass, Reliability
from gidl.rules.walk import members

_HARD = ("inproc", "shm", "can")


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        _terms(interface.qos, interface.facts, findings)
    for member in members(model):
        _terms(member.qos, member.facts, findings)
        _silence(member, findings)
        _samples(member, findings)
        if member.facts.has("qos.on_degraded"):
            findings.error(
                "G0412",
                member.facts.place_of("qos.on_degraded"),
                f"'on_degraded' is not allowed on '{member.name}', because all members of "
                "the interface share one connection",
                "set it in the @qos of the interface",
            )


def _terms(qos: Qos, facts: Facts, findings: Findings) -> None:
    if not facts.has("qos"):
        return
    at = facts.place_of("qos")
    hard = qos.quality_class is QualityClass.HARD_REALTIME
    if hard and qos.media is not None and not set(qos.media) & set(_HARD):
        findings.error(
            "G0412",
            at,
            f"the class HARD_REALTIME is not possible with the media {', '.join(qos.media)}",
            f"add one of the media {', '.join(_HARD)}",
        )
    if qos.deadline_ns and qos.start_by_ns and qos.start_by_ns > qos.deadline_ns:
        findings.error(
            "G0412",
            at,
            "'start_by' is later than 'deadline', but a call must start before its deadline",
        )


def _samples(member: Operation | Attribute, findings: Findings) -> None:
    """Reports a stream or event that demands RELIABLE samples but allows only the medium lcm, which
    loses samples."""
    reliable = member.sends_samples and member.qos.reliability is Reliability.RELIABLE
    if reliable and member.qos.media is not None and set(member.qos.media) == {"lcm"}:
        findings.error(
            "G0412",
            member.facts.place_of("qos"),
            f"the samples of '{member.name}' cannot be RELIABLE with the media lcm: a lost sample "
            "is not sent again",
            "add one of the media inproc, shm, or leave reliability out",
        )


def _silence(member: Operation | Attribute, findings: Findings) -> None:
    """Reports a stream with liveliness MANUAL that declares no time after which a silent writer
    counts as lost. With MANUAL, only the samples of the stream show that its writer is alive."""
    if member.qos.liveliness is not Liveliness.MANUAL:
        return
    inward = isinstance(member, Attribute) and member.streams_in
    if inward:
        assert isinstance(member, Attribute)
        assert member.stream is not None
        bound, missing = member.stream.watchdog_ns, "'watchdog' in @stream"
    else:
        bound, missing = member.qos.deadline_ns, "'deadline' in @qos"
    outward = member.is_event if isinstance(member, Operation) else member.streams_out
    if (inward or outward) and not bound:
        findings.error(
            "G0412",
            member.facts.place_of("qos"),
            f"'{member.name}' has liveliness MANUAL, but no time after which a silent writer "
            "counts as lost",
            f"set {missing}",
        )
