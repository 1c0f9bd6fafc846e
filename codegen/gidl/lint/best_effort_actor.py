"""Lint: an actor command should not be BEST_EFFORT, because it could be lost on the way. Does not
look at streams, whose samples are BEST_EFFORT by default."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings
from gidl.model import Attribute, Model, Operation
from gidl.model.policy import Access, Reliability
from gidl.rules.walk import members


def check(model: Model, findings: Findings) -> None:
    for member in members(model):
        if member.qos.reliability is Reliability.BEST_EFFORT and _acts(member):
            what = "attribute" if isinstance(member, Attribute) else "operation"
            findings.warning(
                "G0903",
                member.facts.place_of("qos"),
                f"{what} '{member.name}' controls the device, but is BEST_EFFORT: messages "
                "may be lost",
                "write reliability=RELIABLE, or leave reliability out",
            )


def _acts(member: Operation | Attribute) -> bool:
    if member.sends_samples:
        return False
    if isinstance(member, Attribute):
        return member.has_setter and member.write_access >= Access.ACTOR
    return member.access >= Access.ACTOR or member.safety
