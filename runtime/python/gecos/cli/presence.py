"""Collects the data for `gecos ls`: the objects that the broker knows, their changes, and whether
their servers answer."""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import gecos
from gecos.cli.options import plain
from gecos.dynamic_client.connect import connect_to, silent_objects
from gecos.dynamic_client.silence import silent_since, told

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry, SilentObject

ASKED_FOR = 2.0
"""Longest wait for the answer of a server, in s. It is a little longer than the 1.5 s of silence
after which the broker reports a server as silent."""
_MOST_AT_ONCE = 64


@dataclass(frozen=True, slots=True)
class Presence:
    """Says whether an object can be reached. `silent_since` is the Unix time at which the broker
    last heard the server; None while the broker hears it. `answers` is true if the server has
    answered this program, or refused it; otherwise `problem` says why there was no answer."""

    entry: Entry
    silent_since: float | None
    answers: bool
    problem: str | None

    def as_json(self) -> dict[str, Any]:
        return {
            **plain(self.entry),
            "silent_since": self.silent_since,
            "answers": self.answers,
            "problem": self.problem,
        }


def presences(lab: gecos.Lab, interface: str = "") -> list[Presence]:
    """Returns the objects that are online or silent and have `interface` or an interface derived
    from it, sorted by name. Without `interface`, returns all objects. Asks up to 64 servers at the
    same time, and waits at most ASKED_FOR s for the answer of each. Raises CreateError if no broker
    answers."""
    listed = lab.objects(interface)
    with ThreadPoolExecutor(_MOST_AT_ONCE) as side_by_side:
        problems = list(side_by_side.map(lambda entry: _problem(lab, entry), listed))
    silent = {
        one.entry.name: one
        for one in silent_objects(lab)
        if interface in ("", one.entry.interface_name, *one.entry.bases)
    }
    found = {}
    for entry, problem in zip(listed, problems, strict=True):
        gone = None if problem is None else silent.pop(entry.name, None)
        found[entry.name] = _silent(gone) if gone else _online(entry, problem)
    for name, one in silent.items():
        found.setdefault(name, _silent(one))
    return [found[name] for name in sorted(found)]


def changes(lab: gecos.Lab, interface: str = "") -> Iterator[dict[str, Any]]:
    """Yields each change of the broker's list as data for JSON. Begins with each object that is
    already online or silent. `skipped` is the number of changes before this one that were not
    reported, because this program read them too late."""
    with lab.watch(interface) as watch:
        skipped = 0
        for change in watch:
            silent = change.presence.name == "SILENT"
            since = silent_since(change.silent_for) if silent else None
            yield plain(change.entry) | {
                "presence": change.presence.name,
                "epoch": change.epoch,
                "silent_since": since,
                "skipped": watch.skipped - skipped,
            }
            skipped = watch.skipped


def _online(entry: Entry, problem: str | None) -> Presence:
    return Presence(entry, None, problem is None, problem)


def _silent(one: SilentObject) -> Presence:
    since = silent_since(one.silent_for)
    return Presence(one.entry, since, False, told(since))


def _problem(lab: gecos.Lab, entry: Entry) -> str | None:
    """Returns why the server of an object does not answer this program, for example because it
    serves the object only inside its own process. Returns None if the server answers, even if it
    refuses this program."""
    began = time.monotonic()
    try:
        connect_to(lab, entry, patience=ASKED_FOR)
    except gecos.CreateError as error:
        if any(attempt.detail is gecos.Detail.REFUSED for attempt in error.attempts):
            return None
        if time.monotonic() - began >= ASKED_FOR:
            return f"does not answer within {ASKED_FOR:g} s"
        return "; ".join(a.reason.removeprefix(f"{entry.name} ") for a in error.attempts)
    return None
