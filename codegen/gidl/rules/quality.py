"""Rule: quality terms must not contradict each other, because no medium could fulfil all of
them."""

from __future__ import annotations

from gidl.diagnostics import Findings
from gidl.model import Facts, Model
from gidl.policy import Qos, QualityClass
from gidl.rules.walk import members

_HARD = ("inproc", "shm", "can")


def check(model: Model, findings: Findings) -> None:
    for interface in model.interfaces():
        _terms(interface.qos, interface.facts, findings)
    for member in members(model):
        _terms(member.qos, member.facts, findings)


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
