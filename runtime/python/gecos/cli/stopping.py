"""Stops objects by name, for `gecos stop`."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import gecos_idl.object  # noqa: F401  # gecos.stop needs it, and no descriptor may be left then

import gecos
from gecos.dynamic_client.connect import (
    BROKER,
    connect_here,
    connect_to,
    entries,
    find,
    not_online,
    silence_of,
    silent_objects,
    sockets_here,
)

if TYPE_CHECKING:
    from pathlib import Path

    from gecos_idl.broker_types import Entry

T = TypeVar("T")
_STOP_WITHIN = 5.0  # s for the answer of a server
_MOST_AT_ONCE = 64  # each session has several descriptors, and `ulimit -n` is often 1024
_NO_DESCRIPTORS = (
    os.strerror(errno.EMFILE),  # in this process
    "no file descriptors left",  # in the server (gecos/media/shm/acceptor.cpp)
)


@dataclass(slots=True)
class Stopping:
    """The results of a request to stop objects. `outcomes` has for each object the reason why it
    was not stopped, or None. `silent_unknown` is the reason why the broker did not say which other
    objects are silent."""

    outcomes: dict[str, Exception | None]
    silent_unknown: Exception | None = None


@dataclass(frozen=True, slots=True)
class _End:
    """The result of the request to stop one object. `failure` is the reason why the object was not
    stopped, or None. `reached` is false if the object did not answer on its socket; `name` then has
    only its first 32 characters."""

    name: str
    failure: Exception | None
    reached: bool = True


def stop_objects(lab: gecos.Lab, names: Sequence[str] | None) -> Stopping:
    """Stops the objects called `names`; without `names`, all objects that are online. If no broker
    answers, stops only objects that run as this user on this host. Raises CreateError if no broker
    answers, `names` is None, and there are no objects on this host."""
    try:
        online = {entry.name: entry for entry in entries(lab)}
    except (ConnectionError, RuntimeError) as error:
        return _stop_without_broker(lab, names, error)
    wanted = list(online if names is None else dict.fromkeys(names))
    ends = _side_by_side(lambda name: _End(name, _failure(lab, name, online)), wanted)
    stopping = Stopping({end.name: end.failure for end in ends})
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
    ends = _side_by_side(lambda socket: _end_here(lab, socket, names), sockets_here())
    if names is None and not ends:
        raise no_broker
    outcomes = {end.name: end.failure for end in ends if end.reached}
    silent = {end.name: end.failure for end in ends if not end.reached}
    for name in silent if names is None else names:
        outcomes.setdefault(name, silent.get(name, no_broker))
    return Stopping(outcomes, no_broker if names is None else None)


def _end_here(lab: gecos.Lab, socket: Path, names: Sequence[str] | None) -> _End | None:
    """Stops the object of a socket, if it is one of `names` or `names` is None. Returns None if it
    is not, or if no server listens."""
    try:
        robot = connect_here(lab, socket)
    except (OSError, RuntimeError) as error:
        robot = str(error)
    if robot is None:
        return None
    if isinstance(robot, str):
        name, reason = socket.name.split(".")[0], f"{robot}; the object may still move"
        attempt = gecos.Attempt(name, gecos.Detail.NO_SERVER, reason)
        return _End(name, gecos.CreateError([attempt]), reached=False)
    name = robot._gecos_session.object_name
    return _End(name, _failure_of(lambda: robot)) if names is None or name in names else None


def _side_by_side(stop: Callable[[T], _End | None], wanted: Sequence[T]) -> list[_End]:
    """Calls `stop` for up to 64 objects at the same time, because an object that does not answer
    must not keep the others moving. If no file descriptors were left for some objects, calls `stop`
    for each of them again, one after another."""
    with ThreadPoolExecutor(_MOST_AT_ONCE) as threads:
        ends = list(threads.map(stop, wanted))
    for place, (one, end) in enumerate(zip(wanted, ends, strict=True)):
        if end is not None and any(text in str(end.failure) for text in _NO_DESCRIPTORS):
            ends[place] = stop(one)
    return [end for end in ends if end is not None]


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
    except (OSError, RuntimeError) as error:  # OSError: also an import without a descriptor
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
