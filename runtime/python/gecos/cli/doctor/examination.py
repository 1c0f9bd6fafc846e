"""Runs all checks of `gecos doctor`, one after the other."""

from __future__ import annotations

import os
import re
import resource
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gecos.cli.doctor import network, places, readings, real_time, resources, settings
from gecos.cli.doctor.broker import (
    Answer,
    BrokerPlace,
    broker,
    one_broker,
    over_lcm,
    unusable_lab_file,
)
from gecos.cli.doctor.extension import NEEDED, extension
from gecos.cli.doctor.finding import Finding, Level
from gecos.cli.doctor.keys import own_key
from gecos.cli.policy import named_file

_OWN_KEY = "own.secret"  # in the folder of keys
# This pattern matches only the error about the value of GECOS_LCM_TTL. It does not match the advice
# "GECOS_LCM_TTL is 0, so …" in other errors.
_REFUSED_TTL = re.compile(r"GECOS_LCM_TTL is '.*")


def examine() -> list[Finding]:
    """Returns the findings about the environment in which programs of this user run. Waits some
    seconds at most for the answers of the brokers of this host."""
    return list(_findings())


def _findings() -> Iterator[Finding]:
    built = extension(*readings.extension(NEEDED))
    yield built
    yield from settings.unknown(os.environ)
    if built.level is Level.OK:
        yield from _of_the_runtime()
    yield places.shared_memory(readings.sealed_memory_problem())
    yield network.socket_buffers(readings.receive_buffer(network.WANTED_BYTES))
    held = readings.capabilities()
    yield real_time.priority(readings.limit(resource.RLIMIT_RTPRIO), held)
    yield real_time.locked_memory(readings.limit(resource.RLIMIT_MEMLOCK), held)


def _of_the_runtime() -> Iterator[Finding]:
    from gecos import _core

    unusable = readings.lab_problem()
    if isinstance(unusable, OSError):
        yield _exhausted(unusable)
        return
    if unusable is not None:
        yield settings.refused(_variable_in(str(unusable)), str(unusable))
        return
    directory = _core.runtime_directory()
    problem = _core.runtime_directory_problem()
    yield places.runtime_directory(problem, directory)
    blocked = places.occupied(readings.in_the_way(Path(directory)))
    if blocked is not None:
        yield blocked
    if problem is None:
        yield places.stale_sockets(readings.stale_sockets(Path(directory)))
    folder = Path(_core.key_directory())
    yield own_key(
        readings.key_problem(),
        readings.place(folder, follow_symlinks=True),
        readings.place(folder / _OWN_KEY, follow_symlinks=False),
    )
    yield from _of_brokers()


def _exhausted(error: OSError) -> Finding:
    number = error.errno or 0
    limit = resources.LIMITS.get(number)
    rises = limit is not None and readings.may_rise(limit.number)
    return resources.exhausted(number, error.strerror or str(error), rises)


def _of_brokers() -> Iterator[Finding]:
    place, unusable = BrokerPlace(), ""
    try:
        place = readings.broker_place()
    except RuntimeError as error:
        unusable = str(error)
    with ThreadPoolExecutor(2) as side_by_side:
        first = side_by_side.submit(readings.ask_broker, None)
        second = side_by_side.submit(readings.ask_broker, "lcm")
        answers = [first.result(), second.result()]
    of_lcm = list(_of_lcm(answers[1], place))
    yield from of_lcm
    if unusable:
        yield unusable_lab_file(unusable, str(named_file()))
    else:
        yield broker(answers[0], place, readings.this_user())
    several = one_broker(answers)
    if several is not None:
        yield several
    wants_lcm = not place.address and os.environ.get("GECOS_LCM_TTL", "0") != "0"
    if wants_lcm and all(finding.level is Level.OK for finding in of_lcm):
        unreached = over_lcm(*answers)
        if unreached is not None:
            yield unreached


def _of_lcm(answer: Answer, place: BrokerPlace) -> Iterator[Finding]:
    refused = _REFUSED_TTL.search(answer.reason or "")
    if refused is not None:
        yield settings.refused("GECOS_LCM_TTL", refused[0].removesuffix(")"))
        return
    yield settings.accepted(os.environ)
    ttl = int(os.environ.get("GECOS_LCM_TTL") or 0)
    yield network.multicast_route(answer.reason, place.address.startswith("lcm") or ttl > 0)
    yield network.reach_of_packets(ttl, place)


def _variable_in(text: str) -> str:
    found = re.search(r"GECOS_\w+", text)
    return found[0] if found else ""
