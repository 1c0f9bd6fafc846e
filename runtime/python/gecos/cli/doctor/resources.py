"""Checks whether programs of this user get the threads and descriptors that they need."""

from __future__ import annotations

import errno
import resource
from dataclasses import dataclass

from gecos.cli.doctor.finding import Finding, wrong
from gecos.cli.doctor.real_time import raised


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit of a process. `number` is its constant in the module `resource`, `letter` is its
    option of ulimit, and `name` is its entry in limits.conf."""

    number: int
    letter: str
    name: str


LIMITS = {
    errno.EMFILE: Limit(resource.RLIMIT_NOFILE, "n", "nofile 65536"),
    errno.EAGAIN: Limit(resource.RLIMIT_NPROC, "u", "nproc 65536"),
}
"""Maps an error number to the limit that a process has reached when it gets this error."""

_OTHERWISE = "end programs that are not needed now"


def exhausted(error: int, reason: str, may_rise: bool) -> Finding:
    """Returns the finding for a system that refuses a resource that a Lab needs. `error` is the
    errno of the refusal. `reason` says what the system refuses. `may_rise` says whether this user
    may raise the limit."""
    what = f"programs of this user get too few resources for a Lab: {reason}"
    limit = LIMITS.get(error)
    if limit is None:
        return wrong("resources", what, "this machine", _OTHERWISE)
    here = f'ulimit -{limit.letter} "$(ulimit -H{limit.letter})"'
    where = f"ulimit -{limit.letter}"
    return wrong("resources", what, where, here if may_rise else raised(limit.name))
