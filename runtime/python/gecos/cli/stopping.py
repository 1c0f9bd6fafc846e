"""Stops objects by name, for `gecos stop`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import gecos
from gecos.dynamic_client.connect import (
    BROKER,
    connect_to,
    entries,
    find,
    not_online,
    objects_here,
    silence_of,
    silent_objects,
)

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry

_STOP_WITHIN = 5.0  # s for the answer of a server


@dataclass(slots=True)
class Stopping:
    """The results of a request to stop objects. `outcomes` has for each object the reason why it
    was not stopped, or None. `silent_unknown` is the reason why the broker did not say which other
    objects are silent."""

    outcomes: dict[str, Exception | None]
    silent_unknown: Exception | None = None


def stop_objects(lab: gecos.Lab, names: Sequence[str] | None) -> Stopping:
    """Stops the objects called `names`; without `names`, all objects that are online. If no broker
    answers, stops only objects that run as this user on this host. Raises CreateError if no broker
    answers, `names` is None, and there are no objects on this host."""
    try:
        online = {entry.name: entry for entry in entries(lab)}
    except (ConnectionError, RuntimeError) as error:
        return _stop_without_broker(lab, names, error)
    wanted = list(online if names is None else dict.fromkeys(names))
    # All objects are stopped at the same time, because an object that does not answer must not keep
    # the others moving.
    with ThreadPoolExecutor(max(1, len(wanted))) as threads:
        failures = threads.map(lambda name: _failure(lab, name, online), wanted)
        stopping = Stopping(dict(zip(wanted, failures, strict=True)))
    # The broker is asked after the stop, because the question must not delay it.
    outcomes = stopping.outcomes.values()
    if names is None or any(isinstance(error, gecos.CreateError) for error in outcomes):
        _find_silent(lab, stopping, every=names is None)
    return stopping


def _stop_without_broker(
    lab: gecos.Lab, names: Sequence[str] | None, no_broker: Exception
) -> Stopping:
    """Stops the objects whose servers run as this user on this host. Only the broker knows other
    objects. Therefore, if `names` is None, it is not known whether all objects were stopped."""
    found, silent = objects_here(lab)
    if names is None and not found and not silent:
        raise no_broker
    reached = [name for name in found if names is None or name in names]
    with ThreadPoolExecutor(max(1, len(reached))) as threads:
        ends = threads.map(lambda name: _failure_of(lambda: found[name]), reached)
        outcomes = dict(zip(reached, ends, strict=True))
    for name in silent if names is None else names:
        outcomes.setdefault(name, _not_reached(name, silent) if name in silent else no_broker)
    return Stopping(outcomes, no_broker if names is None else None)


def _not_reached(name: str, silent: dict[str, str]) -> Exception:
    reason = f"{silent[name]}; the object may still move"
    return gecos.CreateError([gecos.Attempt(name, gecos.Detail.NO_SERVER, reason)])


def _failure(lab: gecos.Lab, name: str, online: dict[str, Entry]) -> Exception | None:
    if name == BROKER:
        return _failure_of(lambda: find(lab, name))
    if name not in online:
        return not_online(name, list(online))
    return _failure_of(lambda: connect_to(lab, online[name]))


def _failure_of(connected: Callable[[], gecos.Object]) -> Exception | None:
    """Stops an object. Returns the reason if the object could not be reached or has not confirmed
    the stop; else None."""
    try:
        gecos.stop(connected()).result(_STOP_WITHIN)
    except TimeoutError:
        return TimeoutError(
            f"its server has not confirmed the stop within {_STOP_WITHIN:g} s; "
            "the object may still move"
        )
    except (ConnectionError, RuntimeError) as error:
        return error
    return None


def _find_silent(lab: gecos.Lab, stopping: Stopping, every: bool) -> None:
    """For each object that could not be reached, adds the time since when it is silent. With
    `every`, also adds the silent objects that the broker no longer lists, because the user must
    know that they cannot be stopped."""
    try:
        silent = silent_objects(lab)
    except (ConnectionError, RuntimeError) as error:
        stopping.silent_unknown = error if every else None
        return
    for one in silent:
        name = one.entry.name
        unknown = every and name not in stopping.outcomes
        if unknown or isinstance(stopping.outcomes.get(name), gecos.CreateError):
            stopping.outcomes[name] = silence_of(one)
