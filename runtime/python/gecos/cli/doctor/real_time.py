"""Checks whether programs of this user may run in real time."""

from __future__ import annotations

from gecos.cli.doctor.finding import Finding, fine, warning

_CAP_IPC_LOCK = 14
_CAP_SYS_NICE = 23
_LEAST_LOCKED = 64 * 1024 * 1024  # bytes that the server of an arm and its libraries need
_LIMITS = "/etc/security/limits.d/gecos.conf"


def raised(limit: str) -> str:
    """Returns the command that raises a limit of this user permanently. `limit` is for example
    "rtprio 80"."""
    return f'echo "$USER - {limit}" | sudo tee -a {_LIMITS}, and log in again'


def priority(limit: int, capabilities: int) -> Finding:
    """Checks the real-time priority. `limit` is RLIMIT_RTPRIO, or -1 for unlimited. `capabilities`
    is CapEff, as bits."""
    if limit != 0 or capabilities >> _CAP_SYS_NICE & 1:
        return fine("real-time priority", "SCHED_FIFO is permitted")
    what = "SCHED_FIFO is not permitted: only a program that moves hardware in real time needs it"
    return warning("real-time priority", what, "ulimit -r", raised("rtprio 80"))


def locked_memory(limit: int, capabilities: int) -> Finding:
    """Checks how much memory may be locked. `limit` is RLIMIT_MEMLOCK in bytes, or -1 for
    unlimited. `capabilities` is CapEff, as bits."""
    if limit < 0 or limit >= _LEAST_LOCKED or capabilities >> _CAP_IPC_LOCK & 1:
        return fine("locked memory", "mlockall is permitted")
    what = f"only {limit} bytes may be locked: only a program that runs in real time needs more"
    return warning("locked memory", what, "ulimit -l", raised("memlock unlimited"))
