"""Checks whether a broker answers, whether it is the only one, and whether it has the version of
this program."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from gecos.cli import refusal
from gecos.cli.doctor.finding import Finding, fine, warning, wrong

_REQUEST = re.compile(r" \(request [0-9a-f-]+\)")
# This pattern and _NO_LIST match texts of refusals that gecos/access/access_policy.cpp writes.
_NOT_NAMED = re.compile(
    r"(?:(?P<list>\[[^\]]+\] in \S+):\d+|(?P<of_program>the list in the program of the server).*) "
    r'does not name .+; add (?P<name>"[^"]+") to its (?P<names>\w+)'
)
_NO_LIST = re.compile(r"; (?P<what>write .+ below \[allow\] in \S+)")
_MEDIA = ("inproc", "lcm", "shm")  # an address begins with one of these words


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a broker. `reason` says why no broker answers; None if a broker answers. `boot`
    is different in each run of a broker. `ours` says whether the broker has the interface that this
    program knows."""

    reason: str | None
    boot: int = 0
    process: str = ""
    ours: bool = True


@dataclass(frozen=True, slots=True)
class BrokerPlace:
    """Where programs look for the broker. `source` names the setting with the address, as
    "GECOS_BROKER" or "[broker] in lab.toml:4"; `address` and `source` are empty if no setting names
    a broker."""

    address: str = ""
    source: str = ""

    @property
    def of_environment(self) -> bool:
        return self.source == "GECOS_BROKER"

    def __str__(self) -> str:
        if self.of_environment:
            return f"GECOS_BROKER={self.address}"
        return f"address {self.address}, {self.source}" if self.source else "this host"


def unusable_lab_file(problem: str, file: str) -> Finding:
    """Returns the finding for a lab file that programs need to find the broker, but cannot use.
    `problem` says why, and what to do."""
    what, _, mend = problem.rpartition("; ")
    return wrong("broker", what, file, mend)


def broker(answer: Answer, at: BrokerPlace, us: str) -> Finding:
    """Checks the answer of the broker at the place where programs look for a broker. `us` is this
    user and this host, as "anna@desk"."""
    place = str(at)
    if answer.reason is not None:
        refused = refusal.of_broker(answer.reason)
        if refused:
            return _refused(refused, place)
        what = f"no broker answers: {_tried(answer.reason)}"
        return wrong("broker", what, place, _mend(answer.reason, at, us))
    if not answer.ours:
        what = f"the broker, {answer.process}, belongs to another version of robcl"
        mend = "end it, and start `gecos broker` of this installation"
        return warning("broker", what, place, mend)
    return fine("broker", f"{answer.process} answers", place)


def one_broker(answers: Sequence[Answer]) -> Finding | None:
    """Checks that at most one broker answers. `answers` come from brokers at several places.
    Returns None if at most one broker answers."""
    found = {each.boot: each.process for each in answers if each.reason is None}
    if len(found) < 2:
        return None
    what = (
        f"several brokers answer: {', '.join(found.values())}; names are unique only "
        "within one broker"
    )
    mend = "end all but one, or name one for all programs: in GECOS_BROKER or in the lab file"
    return warning("brokers", what, "this host and lcm", mend)


def over_lcm(here: Answer, over_lcm: Answer) -> Finding | None:
    """Checks whether the broker of this host is also reached over lcm. Call this function only if
    packets can be sent over lcm, and if programs on other hosts are to be reached. Returns None if
    the broker is reached over lcm, or if no broker answers on this host."""
    if here.reason is not None or over_lcm.reason is None:
        return None
    what = (
        f"{here.process}, the broker of this host, does not answer over lcm, so programs on other "
        "hosts do not find it; it may have started before there was a route for multicast"
    )
    return warning(
        "broker over lcm", what, "lcm", "end the broker and the devices, and start them again"
    )


def _refused(why: str, place: str) -> Finding:
    """Returns the finding for a user whom a broker refuses. The finding does not advise the user to
    start another broker, because a new broker would be another laboratory, without objects."""
    text = _REQUEST.sub("", why)
    mend = f"ask the user of the broker to {_admission(text)}"
    return wrong("broker", f"the broker refuses this user: {text}", place, mend)


def _admission(refusal: str) -> str:
    """Returns what the user who runs the broker has to do, so that the broker admits the user who
    runs this command."""
    if found := _NOT_NAMED.search(refusal):
        names = found["list"] or "the list in the program of the broker"
        return f"add {found['name']} to the {found['names']} of {names}"
    found = _NO_LIST.search(refusal)
    return "admit this user" if found is None else found["what"]


def _mend(reason: str, at: BrokerPlace, us: str) -> str:
    if "is not admitted here" in reason:
        return (
            "gecos keys add FILE USER@HOST, with the .public file of the broker's user, and the "
            "name and host of that user"
        )
    if not at.source:
        return "gecos broker (or gecos up, which also starts devices)"
    if at.address.partition(":")[0] not in _MEDIA:
        if at.of_environment:
            return "export GECOS_BROKER=lcm for a broker of another host (unset it for this host's)"
        return (
            f'write address = "lcm" at {at.source} for a broker of another host, or remove the line'
        )
    mend = f"run gecos broker on the host and as the user that {at} names"
    if "does not admit our key" in reason:
        mend += (
            "; if a broker already runs there, ask its user to run gecos keys add FILE "
            f"{us}, where FILE is your .public file"
        )
    return mend


def _tried(reason: str) -> str:
    """Returns the addresses in `reason` at which this program looked for a broker. Leaves out the
    advice in `reason`, because the finding gives its own advice."""
    _, _, tried = reason.partition("(tried ")
    return tried.removesuffix(")") or reason
