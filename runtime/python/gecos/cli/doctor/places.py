"""Is the runtime directory ours, are its sockets alive, and can memory be shared?"""

from __future__ import annotations

from collections.abc import Sequence

from gecos.cli.doctor.finding import Finding, fine, warning, wrong

_ANOTHER = 'mkdir -m 700 "$HOME/.gecos-run" && export GECOS_RUNTIME_DIR="$HOME/.gecos-run"'


def runtime_directory(problem: str | None, where: str) -> Finding:
    """`problem`: why the runtime refuses the directory."""
    if problem is None:
        return fine("runtime directory", "only this user can write to it", where)
    text = problem.removeprefix("shm: ")
    _, _, command = text.partition("; run:  ")
    what, _, _ = text.partition("; ")
    return wrong("runtime directory", what, where, command or _ANOTHER)


def stale_sockets(left: Sequence[str]) -> Finding:
    """`left`: sockets in the runtime directory whose programs have ended."""
    if not left:
        return fine("sockets", "none is left over")
    what = "left over by programs that were killed; the next server or broker removes them"
    return warning("sockets", what, ", ".join(left), f"rm {' '.join(left)}")


def occupied(others: Sequence[str]) -> Finding | None:
    """`others`: files in the way of the broker's socket that are no sockets."""
    if not others:
        return None
    what = "is in the way of the broker's socket and is no socket"
    return wrong("sockets", what, ", ".join(others), f"rm -r {' '.join(others)}")


def shared_memory(problem: str | None) -> Finding:
    """`problem`: why a sealed memfd cannot be made. The runtime does not use /dev/shm."""
    if problem is None:
        return fine("shared memory", "sealed memory can be made; /dev/shm is not needed")
    mend = "use Linux 5.1 or newer, and in a container a profile that allows memfd_create"
    return wrong("shared memory", f"shm is not usable: {problem}", "memfd_create", mend)
