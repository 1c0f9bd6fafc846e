"""Checks that this machine supports the media, and says how to fix each missing requirement."""

import os
import socket
import struct
import sys
import tempfile
from collections.abc import Callable

GROUP = "239.255.76.67"  # the group of LCM; ttl 0 keeps datagrams on this host


def sealed_memory() -> str | None:
    """Checks memfd_create with seals, from which the medium shm gets its shared memory."""
    try:
        descriptor = os.memfd_create("check_host", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    except OSError as error:
        return (
            f"shm: memfd_create fails ({error}). "
            "Allow the system call in the container's seccomp profile."
        )
    os.close(descriptor)
    return None


def process_descriptors() -> str | None:
    """Checks pidfd_open, by which the medium shm notices that a peer has died."""
    try:
        os.close(os.pidfd_open(os.getpid()))
    except OSError as error:
        return (
            f"shm: pidfd_open fails ({error}). It needs Linux 5.3 or newer, and a seccomp profile "
            "that allows it."
        )
    return None


def unix_sockets() -> str | None:
    """Checks that a Unix socket names the user of a client, as servers of the medium shm need."""
    try:
        with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX) as listener:
            path = f"{folder}/s"
            listener.bind(path)
            listener.listen()
            with socket.socket(socket.AF_UNIX) as client:
                client.connect(path)
                server, _ = listener.accept()
                with server:
                    size = struct.calcsize("3i")
                    raw = server.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
                    if struct.unpack("3i", raw)[1] != os.getuid():
                        return (
                            "shm: the kernel names another user than ours (SO_PEERCRED). "
                            "Map this user in the container's user namespace."
                        )
    except OSError as error:
        return f"shm: Unix sockets fail ({error}). Set TMPDIR to a folder on a local file system."
    return None


def multicast() -> str | None:
    """Checks that a datagram to the multicast group of LCM comes back to this host."""
    try:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        ):
            receiver.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            receiver.bind((GROUP, 0))
            member = socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0")
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
            receiver.settimeout(2.0)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            sender.sendto(b"robcl", (GROUP, receiver.getsockname()[1]))
            receiver.recv(16)
    except OSError as error:
        return (
            f"lcm: multicast to {GROUP} does not come back ({error}). Give it a route:  "
            "ip link set lo multicast on && ip route add 239.255.0.0/16 dev lo"
        )
    return None


CHECKS: tuple[Callable[[], str | None], ...] = (
    sealed_memory,
    process_descriptors,
    unix_sockets,
    multicast,
)


def main() -> int:
    problems = [problem for check in CHECKS if (problem := check()) is not None]
    for problem in problems:
        print(problem)
    working = len(CHECKS) - len(problems)
    print(f"check_host: {working} of {len(CHECKS)} things that the media need work")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
