"""Checks that no actor command starts, and no sample is taken, while nobody is present in the zone
of the server, and that none starts after presence has returned that was sent before it was lost.

A zone notes that its person comes or leaves before it publishes that. The record of a zone:

    zone <pid>
    comes
    leaves
    done
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import TYPE_CHECKING, NamedTuple

import statuses

if TYPE_CHECKING:
    from history import History

BOUND_S = 0.25
"""Promised: from the loss of presence until nothing starts any more."""
TICK_NS = 10_000_000
"""The mark of a start may be one kernel tick too early (IncomingCall::marked_at), at most 10 ms."""
REPORT_LIVES_S = 1.0
"""For so long an object believes the last report of a zone that has fallen silent. The zone is also
silent for an object until they have a new session, after one of them stood still or ended."""


@dataclass(slots=True)
class Zone:
    """One life of a zone."""

    name: str
    pid: int = 0
    changes: list[tuple[int, bool]] = field(default_factory=list)
    """When the person came (True) or left."""
    done: int | None = None


class Absence(NamedTuple):
    """Nobody was present, or nobody could know of it, from one time to another."""

    begin: int
    end: int
    heard_s: float
    """Within this time after `begin` the server must have learned of it."""
    why: str


def read_zone(name: str, lines: Iterable[list[str]]) -> Zone:
    zone = Zone(name)
    for time, event, *rest in lines:
        match event, rest:
            case "zone", [pid]:
                zone.pid = int(pid)
            case (("comes" | "leaves"), []):
                zone.changes.append((int(time), event == "comes"))
            case "done", []:
                zone.done = int(time)
            case _:
                raise ValueError(f"{name}: no line of a zone: {event} {rest}")
    return zone


def absences(history: History) -> Iterator[Absence]:
    zones = sorted(
        (zone for zone in history.zones if zone.changes), key=lambda zone: zone.changes[0]
    )
    for zone, later in zip_longest(zones, zones[1:]):
        killed = history.kills.get(zone.pid, zone.done)
        if killed is not None and later is not None:
            yield Absence(killed, later.changes[0][0], REPORT_LIVES_S, "the zone had ended")
        frozen = [freeze for freeze in history.freezes if freeze.pid == zone.pid]
        for freeze in frozen:
            if (freeze.end - freeze.begin) * 1e-9 > REPORT_LIVES_S:  # else no report grew too old
                yield Absence(freeze.begin, freeze.end, REPORT_LIVES_S, "the zone stood still")
        for (begin, present), (end, _) in zip(zone.changes, zone.changes[1:], strict=False):
            if present:
                continue
            silent = _is_silent(history, zone.pid, begin, end)
            yield Absence(begin, end, REPORT_LIVES_S if silent else 0.0, "the person had left")


def check(history: History) -> Iterator[str]:
    calls = {number: call for client in history.clients for number, call in client.calls.items()}
    calls |= {number: call for client in history.clients for number, call in client.samples.items()}
    gone = [*absences(history)]
    for server in history.servers:
        begun = [
            (start.command, start.marked, f"command {start.command}")
            for start in server.starts
            if start.operation in statuses.ACTOR
        ]
        begun += [(sample, before, f"sample {sample}") for sample, before, _ in server.taken]
        for number, at, what in begun:
            call = calls.get(number)
            for absence in gone:
                if at <= absence.begin:
                    continue
                until = min(at, absence.end)
                silent = _is_silent(history, server.pid, absence.begin, absence.end)
                heard_s = REPORT_LIVES_S if silent else absence.heard_s
                knew = history.awake_s(server.pid, absence.begin, at) > heard_s + BOUND_S
                if at + TICK_NS < absence.end and knew:
                    yield (
                        f"{server.name}: {what} began"
                        f" {(until - absence.begin) * 1e-9:.3f} s after {absence.why}"
                    )
                sent = call.sent if call is not None else None
                heard = knew and history.awake_s(server.pid, absence.end, at) > BOUND_S
                if at > absence.end and heard and sent is not None and sent < absence.begin:
                    yield f"{server.name}: {what} began, and was sent before {absence.why}"


def _is_silent(history: History, pid: int, begin: int, end: int) -> bool:
    """Whether the process stood still between two times or shortly before, or a zone ended then."""
    before = begin - int(REPORT_LIVES_S * 1e9)
    still = any(
        freeze.pid == pid and freeze.begin < end and before < freeze.end
        for freeze in history.freezes
    )
    ended = (history.kills.get(zone.pid, zone.done) for zone in history.zones)
    return still or any(at is not None and before < at < end for at in ended)
