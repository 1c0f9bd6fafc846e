"""Checks whether the runtime directory belongs to this user, whether its sockets are in use, and
whether memory can be shared."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from gecos.cli.doctor.finding import Finding, fine, warning, wrong

_ANOTHER = 'mkdir -m 700 "$HOME/.gecos-run" && export GECOS_RUNTIME_DIR="$HOME/.gecos-run"'


def runtime_directory(problem: str | None, where: str) -> Finding:
    """Checks the runtime directory. `problem` says why the runtime refuses it; None if the runtime
    accepts it."""
    if problem is None:
        return fine("runtime directory", "only you can write to this folder", where)
    text = problem.removeprefix("shm: ")
    what, closing, _ = text.partition("; run:  chmod ")
    # The command in `problem` is replaced, because the runtime does not quote the path in it.
    if closing:
        return wrong("runtime directory", what, where, shlex.join(["chmod", "go-w", where]))
    what, advice, _ = text.rpartition("; ")
    return wrong("runtime directory", what if advice else text, where, _ANOTHER)


def stale_sockets(left: Sequence[str]) -> Finding:
    """Checks for sockets that are not in use. `left` are the sockets in the runtime directory whose
    programs have ended."""
    if not left:
        return fine("sockets", "no socket is left over")
    what = "programs that were killed left these sockets; the next server or broker removes them"
    return warning("sockets", what, ", ".join(left), shlex.join(["rm", *left]))


def occupied(others: Sequence[str]) -> Finding | None:
    """Checks the place of the broker's socket. `others` are files in this place that are not
    sockets."""
    if not others:
        return None
    what = "this file is in the place of the broker's socket, but is not a socket"
    return wrong("sockets", what, ", ".join(others), shlex.join(["rm", "-r", *others]))


def shared_memory(problem: str | None) -> Finding:
    """Checks whether memory can be shared. `problem` says why the kernel refuses a sealed memfd;
    None if the kernel allows it. The runtime does not use /dev/shm."""
    if problem is None:
        return fine("shared memory", "the kernel provides sealed memory; /dev/shm is not needed")
    mend = "use Linux 5.1 or newer; in a container, use a profile that allows memfd_create"
    return wrong("shared memory", f"shm is not usable: {problem}", "memfd_create", mend)
