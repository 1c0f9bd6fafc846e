"""Reads the values that the checks judge: answers of the runtime, /proc, limits and files."""

from __future__ import annotations

import errno
import fcntl
import os
import re
import resource
import socket
import stat
from importlib import import_module
from pathlib import Path

from gecos.cli.doctor.broker import Answer, BrokerPlace
from gecos.cli.doctor.keys import Kind, Place

_ASKED_FOR = 1.0  # s; longest wait for the answer of a broker
_SEALS = ["F_SEAL_SHRINK", "F_SEAL_GROW", "F_SEAL_SEAL"]
_F_SEAL_FUTURE_WRITE = 0x10  # fcntl has no name for it before Python 3.13
_OF_A_PROCESS = re.compile(r"[^.]*\.(\d+)\.\d+\.sock")


def extension(needed: list[str]) -> tuple[str | None, list[str], str]:
    """Returns the reason why gecos._core cannot be imported (or None), the names of `needed` that
    the extension lacks, and the path of its file."""
    folder = Path(__file__).resolve().parents[2]
    try:
        found = import_module("gecos._core")
    except ImportError as error:
        made = ", ".join(path.name for path in sorted(folder.glob("_core*.so")))
        return str(error), [], f"{folder} (there is {made or 'no _core*.so'})"
    return None, [name for name in needed if not hasattr(found, name)], str(found.__file__)


def lab_problem() -> RuntimeError | OSError | None:
    """Returns the reason why this process cannot have a Lab. The reason is a RuntimeError if a
    setting is invalid, and an OSError if threads or descriptors are missing. Returns None if the
    process can have a Lab."""
    import gecos

    try:
        gecos.Lab("shm").close()
    except (RuntimeError, OSError) as error:
        return error
    return None


def ask_broker(place: str | None) -> Answer:
    """Asks the broker at `place` who it is. If `place` is None, asks the broker that programs of
    this user find by default."""
    from gecos_idl.broker import Broker

    import gecos

    try:
        with gecos.Lab(place) as lab:
            broker = lab.broker(Broker, patience=_ASKED_FOR)
            told = gecos.describe(broker).result(_ASKED_FOR)
            ours = told.interface_hash == Broker._gecos_interface.hash
            return Answer(None, gecos.reference(broker).boot, f"process {told.pid}", ours)
    except gecos.CreateError as error:
        return Answer(error.attempts[0].reason)
    except (OSError, RuntimeError) as error:
        return Answer(str(error))


def this_user() -> str:
    """Returns the name of this user and of this host in one text, such as "anna@desk"."""
    from gecos import key_folder

    return f"{key_folder.this_user()}@{socket.gethostname()}"


def broker_place() -> BrokerPlace:
    """Returns where programs of this user look for the broker. Raises RuntimeError if GECOS_BROKER
    is not set and the lab file, which may name the broker, cannot be used."""
    from gecos import _core

    named = os.environ.get("GECOS_BROKER", "")
    if named:
        return BrokerPlace(named, "GECOS_BROKER")
    return BrokerPlace(*_core.broker_in_lab_file(_ASKED_FOR))


def key_problem() -> str | None:
    from gecos import _core

    try:
        _core.own_key()
    except RuntimeError as error:
        return str(error)
    return None


def place(path: Path, follow_symlinks: bool) -> Place:
    """Returns what is at `path`."""
    try:
        found = path.stat(follow_symlinks=follow_symlinks)
    except OSError:
        return Place(str(path), Kind.MISSING)
    kinds = {stat.S_IFDIR: Kind.FOLDER, stat.S_IFREG: Kind.FILE}
    return Place(
        str(path),
        kinds.get(stat.S_IFMT(found.st_mode), Kind.OTHER),
        ours=found.st_uid == os.geteuid(),
        shared=bool(found.st_mode & (stat.S_IRWXG | stat.S_IRWXO)),
        readable=os.access(path, os.R_OK),
    )


def stale_sockets(directory: Path) -> list[str]:
    """Returns the sockets in `directory` on which no program listens any more."""
    return [str(path) for path in _sockets(directory) if _process_has_ended(path) and _dead(path)]


def _sockets(directory: Path) -> list[Path]:
    try:
        return sorted(p for p in directory.glob("*.sock") if stat.S_ISSOCK(p.lstat().st_mode))
    except OSError:
        return []  # another check reports what is wrong with the directory


def _process_has_ended(path: Path) -> bool:
    """Returns whether the process that made a socket has ended, by the process number in the
    socket's name. Returns True for a broker's socket, whose name has no such number. The check does
    not connect to a living server, because the server would get a client that sends nothing."""
    of = _OF_A_PROCESS.fullmatch(path.name)
    if of is None:
        return True  # the name is that of a broker's socket
    try:
        os.kill(int(of[1]), 0)
    except ProcessLookupError:
        return True
    except (PermissionError, OverflowError):
        return False
    return False


def _dead(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as client:
        client.setblocking(False)
        return client.connect_ex(str(path)) == errno.ECONNREFUSED


def in_the_way(directory: Path) -> list[str]:
    """Returns the path of the broker's socket if another kind of file has this path."""
    place = directory / "BROKER.sock"
    try:
        return [] if stat.S_ISSOCK(place.lstat().st_mode) else [str(place)]
    except OSError:
        return []


def sealed_memory_problem() -> str | None:
    """Returns the reason why the kernel refuses memory of the kind that the runtime shares, a
    sealed memfd. Returns None if the kernel allows it."""
    seals = _F_SEAL_FUTURE_WRITE | sum(getattr(fcntl, name) for name in _SEALS)
    try:
        memory = os.memfd_create("gecos-doctor", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(memory, 4096)
            fcntl.fcntl(memory, fcntl.F_ADD_SEALS, seals)
        finally:
            os.close(memory)
    except OSError as error:
        return os.strerror(error.errno or 0)
    return None


def receive_buffer(wanted: int) -> int:
    """Returns the number of bytes that a socket gets when it asks for `wanted` bytes."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, wanted)
        # The kernel returns twice the size that it grants.
        return udp.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) // 2


def capabilities() -> int:
    """Returns the capabilities of this process, as bits."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("CapEff:")), 16)


def may_rise(limit: int) -> bool:
    """Returns whether this process may raise its limit `limit` of the module `resource`."""
    soft, hard = resource.getrlimit(limit)
    return soft != resource.RLIM_INFINITY and (hard == resource.RLIM_INFINITY or soft < hard)


def limit(name: int) -> int:
    """Returns the soft limit `name` of the module `resource`, or -1 if there is no limit."""
    soft, _ = resource.getrlimit(name)
    return -1 if soft == resource.RLIM_INFINITY else soft
