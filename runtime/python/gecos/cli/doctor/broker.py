"""Does a broker answer, is it the only one, and is it of this version?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gecos.cli.doctor.finding import Finding, fine, warning, wrong


@dataclass(frozen=True, slots=True)
class Answer:
    """`reason`: why no broker answers; None if one does. `boot`: tells one run of a broker from
    another. `ours`: it has the interface that this program knows."""

    reason: str | None
    boot: int = 0
    process: str = ""
    ours: bool = True


def broker(answer: Answer, place: str) -> Finding:
    """`place`: where programs look for a broker, GECOS_BROKER or this host."""
    if answer.reason is not None:
        what = f"no broker answers: {_tried(answer.reason)}"
        return wrong("broker", what, place, _mend(answer.reason, place))
    if not answer.ours:
        what = f"the broker, {answer.process}, is of another version of robcl"
        mend = "end it, and start `gecos broker` of this installation"
        return warning("broker", what, place, mend)
    return fine("broker", f"{answer.process} answers", place)


def one_broker(answers: Sequence[Answer]) -> Finding | None:
    """`answers`: of the brokers at several places. None if at most one broker answers."""
    found = {each.boot: each.process for each in answers if each.reason is None}
    if len(found) < 2:
        return None
    what = f"several answer: {', '.join(found.values())}; names are unique within each one only"
    mend = "end one of them, or set GECOS_BROKER for all programs"
    return warning("brokers", what, "this host and lcm", mend)


def _mend(reason: str, place: str) -> str:
    if "is not admitted here" in reason:
        return "gecos keys add FILE, with the .public file of the broker's user"
    if place == "this host":
        return "gecos broker (or gecos up, which starts devices too)"
    mend = f"gecos broker, on the host and for the user that {place} names"
    if "does not admit our key" in reason:
        mend += "; if one runs, gecos keys add FILE there, with our .public file"
    return mend


def _tried(reason: str) -> str:
    """The places that were tried, without the advice, which `mend` gives."""
    _, _, tried = reason.partition("(tried ")
    return tried.removesuffix(")") or reason
