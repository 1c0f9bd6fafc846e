"""Two simulated hosts: network namespaces with a link between them that can be cut."""

from __future__ import annotations

import os
import subprocess
from types import TracebackType

from lateness import now_ns

NEEDED = (
    "two network namespaces are needed, with a bridge between them: run as root, or let users make"
    " them (sysctl -w kernel.unprivileged_userns_clone=1 user.max_net_namespaces=100)"
)


class Hosts:
    """Two network namespaces. A program runs on host 0 or 1 with the arguments of `on` in front."""

    def __enter__(self) -> Hosts:
        self._holders: list[subprocess.Popen[bytes]] = []
        try:
            self._user = [] if os.geteuid() == 0 else self._enter(self._hold(["unshare", "-Ur"]))
            self._between = self._hold([*self._user, "unshare", "-n"])
            self._ends = [self._hold([*self._user, "unshare", "-n"]) for _ in range(2)]
            self._ip(self._between, "link add line type bridge mcast_snooping 0")
            self._ip(self._between, "link set line up")
            for end, pid in enumerate(self._ends):
                self._ip(self._between, f"link add end{end} type veth peer name eth0 netns {pid}")
                self._ip(self._between, f"link set end{end} master line up")
                self._ip(pid, "link set lo up")
                self._ip(pid, f"address add 10.77.0.{end + 1}/24 dev eth0")
                self._ip(pid, "link set eth0 up multicast on")
                self._ip(pid, "route add 224.0.0.0/4 dev eth0")
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        for holder in reversed(self._holders):
            holder.kill()
            holder.wait()
        self._holders = []

    def on(self, host: int) -> list[str]:
        return self._enter(self._ends[host], "-n")

    def without_route(self, host: int) -> None:
        """Takes the only route for multicast from a host, which has no default route either."""
        self._ip(self._ends[host], "route del 224.0.0.0/4 dev eth0")

    def cut(self) -> int:
        """Cuts the link and returns the time in ns. Neither host sees its own interface go down."""
        self._ip(self._between, "link set end0 nomaster")
        return now_ns()

    def between(self) -> list[str]:
        """Takes the link away. A program with these words in front stands between the hosts: it
        receives what they send at the interfaces end0 and end1, and may send to them there."""
        for end in range(2):
            self._ip(self._between, f"link set end{end} nomaster")
        return self._enter(self._between, "-n")

    def mend(self) -> int:
        now = now_ns()
        self._ip(self._between, "link set end0 master line")
        return now

    def _hold(self, command: list[str]) -> int:
        """A process that keeps a namespace; it says when it is in it."""
        holder = subprocess.Popen(
            [*command, "sh", "-c", "echo in; exec sleep infinity"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self._holders.append(holder)
        assert holder.stdout is not None and holder.stderr is not None
        said = holder.stdout.readline()
        holder.stdout.close()
        assert said == b"in\n", f"{NEEDED}: {holder.stderr.read().decode().strip()}"
        holder.stderr.close()
        return holder.pid

    def _enter(self, pid: int, *spaces: str) -> list[str]:
        user = [] if os.geteuid() == 0 else ["-U", "--preserve-credentials"]
        return ["nsenter", "-t", str(pid), *user, *spaces, "--"]

    def _ip(self, pid: int, words: str) -> None:
        done = subprocess.run(
            [*self._enter(pid, "-n"), "ip", *words.split()], capture_output=True, text=True
        )
        assert done.returncode == 0, f"{NEEDED}: ip {words}: {done.stderr.strip()}"
