"""The verb `gecos stats`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import click

from gecos.cli.options import broker_option, json_option, optional_name_argument, plain, print_json

if TYPE_CHECKING:
    from gecos_idl.object_types import ObjectStats, OperationStats, OutcomeCount, SessionStats

    import gecos

    Counted = OperationStats | SessionStats


@click.command()
@optional_name_argument
@broker_option
@json_option
def stats(name: str | None, broker: str | None, as_json: bool) -> None:
    """Shows what an object has counted since its server began to serve it: calls by outcome, calls
    that were late, times of handlers, samples of streams, and the calls of each open session.
    Without NAME, prints a line for each object that is online."""
    import gecos

    with gecos.Lab(broker) as lab:
        found = dict(_all_stats(lab) if name is None else [(name, _stats(lab, name))])
    if as_json:
        print_json([_as_json(each, told) for each, told in found.items()])
    elif name is None:
        _print_objects(found)
    else:
        told = found[name]
        assert not isinstance(told, str)
        _print_object(name, told)


def _stats(lab: gecos.Lab, name: str) -> ObjectStats:
    import gecos
    from gecos.dynamic_client.connect import find

    return gecos.stats(find(lab, name)).result()


def _all_stats(lab: gecos.Lab) -> Iterator[tuple[str, ObjectStats | str]]:
    """Yields the counts of each object that is online, or the reason why an object does not report
    them."""
    from gecos.dynamic_client.connect import entries

    for entry in entries(lab):
        try:
            yield entry.name, _stats(lab, entry.name)
        except (ConnectionError, RuntimeError) as error:
            yield entry.name, str(error)


def _outcomes(ended: Sequence[OutcomeCount]) -> dict[str, int]:
    from gecos.errors import Detail

    names = {detail.value: detail.name for detail in Detail}
    return {names.get(each.detail, str(each.detail)): each.calls for each in ended}


def _as_json(name: str, told: ObjectStats | str) -> dict[str, Any]:
    if isinstance(told, str):
        return {"name": name, "problem": told}
    value: dict[str, Any] = plain(told)
    for shown, operation in zip(value["operations"], told.operations, strict=True):
        shown["ended"] = _outcomes(operation.ended)
    for shown, session in zip(value["sessions"], told.sessions, strict=True):
        shown["ended"] = _outcomes(session.ended)
    return {"name": name, "problem": None} | value


# For people


def _time(seconds: float) -> str:
    """Returns a text such as "1.2 ms"; "-" for no time."""
    if seconds <= 0:
        return "-"
    for unit, size in (("ns", 1e-9), ("us", 1e-6), ("ms", 1e-3)):
        if seconds < 999.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s" if seconds < 600 else f"{seconds / 3600:.1f} h"


def _done(counted: Counted) -> int:
    return _outcomes(counted.ended).get("DONE", 0)


def _others(counted: Counted) -> str:
    """Returns a text such as "2 DENIED, 1 CANCELED"."""
    ended = _outcomes(counted.ended).items()
    return ", ".join(f"{calls} {name}" for name, calls in ended if name != "DONE")


def _late(counted: Counted) -> str:
    return str(counted.deadline_missed + counted.start_by_missed)


def _print_objects(found: dict[str, ObjectStats | str]) -> None:
    from gecos.cli import report

    if not found:
        print("no object is online")
        return
    rows = [
        (name, *["-"] * 6, told) if isinstance(told, str) else (name, *_summary(told), "")
        for name, told in found.items()
    ]
    heads = ("name", "served for", "begun", "done", "late", "samples", "sessions", "")
    report.table(heads, rows)


def _summary(told: ObjectStats) -> tuple[str, ...]:
    calls = told.operations
    return (
        _time(told.served_for),
        str(sum(each.begun for each in calls)),
        str(sum(map(_done, calls))),
        str(sum(int(_late(each)) for each in calls)),
        str(sum(each.samples for each in told.streams)),
        str(len(told.sessions)),
    )


def _print_object(name: str, told: ObjectStats) -> None:
    from gecos.cli import report

    print(report.printable(f"{name}: served for {_time(told.served_for)}"))
    for heads, rows in (_operations(told), _streams(told), _inward(told), _sessions(told)):
        if rows:
            print()
            report.table(heads, rows)


Table = tuple[tuple[str, ...], list[tuple[str, ...]]]


def _operations(told: ObjectStats) -> Table:
    heads = ("operation", "begun", "done", "late", "median", "99 %", "worst", "other outcomes")
    return heads, [
        (
            each.operation,
            str(each.begun),
            str(_done(each)),
            _late(each),
            _time(each.median),
            _time(each.percentile_99),
            _time(each.worst),
            _others(each),
        )
        for each in told.operations
    ]


def _streams(told: ObjectStats) -> Table:
    heads = ("stream", "samples", "bytes", "dropped", "readers")
    return heads, [
        (each.stream, *map(str, (each.samples, each.bytes_, each.dropped, each.readers)))
        for each in told.streams
    ]


def _inward(told: ObjectStats) -> Table:
    heads = ("inward stream", "admitted", "lost", "too old", "refused", "last refusal")
    rows = []
    for each in told.inward:
        counts = each.samples
        refused = (
            counts.other_session
            + counts.session_ended
            + counts.no_status
            + counts.command_not_running
            + counts.not_newer
            + counts.unreadable
        )
        numbers = (counts.admitted, counts.lost, counts.too_old, refused)
        rows.append((each.stream, *map(str, numbers), counts.last_refusal))
    return heads, rows


def _sessions(told: ObjectStats) -> Table:
    heads = ("client", "program", "pid", "medium", "connected", "begun", "done", "late")
    return (*heads, "other outcomes"), [
        (
            f"{each.user}@{each.host}",
            each.program,
            str(each.pid),
            each.medium,
            _time(each.connected_for),
            str(each.begun),
            str(_done(each)),
            _late(each),
            _others(each),
        )
        for each in told.sessions
    ]
