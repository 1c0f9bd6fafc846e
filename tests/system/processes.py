"""Programs as processes of their own: started, read line by line, killed, and never left behind."""

from __future__ import annotations

import os
import queue
import select
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

PATIENCE_S = 30.0
"""How long a test waits for a line or an end: far beyond what is promised, a miss is a defect."""

WITH_OTHER_USERS = () if os.geteuid() == 0 else ("unshare", "--map-root-user", "--map-auto")
"""Before a command: it runs as root of a namespace that has other users, too, namely those that
/etc/subuid gives to this user."""

OTHER_USERS_MISSING = (
    "this test needs two users of this host: run it as root, or allow user namespaces "
    "(sysctl -w kernel.unprivileged_userns_clone=1) and give this user others in /etc/subuid and "
    "/etc/subgid (usermod --add-subuids 100000-165535 --add-subgids 100000-165535 USER); "
    "newuidmap comes with the package uidmap"
)


def until(happened: Callable[[], bool], what: str, patience: float = PATIENCE_S) -> float:
    """Asks every millisecond until `happened()` is true. Returns how long that took, in s. Without
    the pause, the test would take processor time from the programs that it waits for."""
    began = time.monotonic()
    while not happened():
        assert time.monotonic() - began < patience, f"not within {patience} s: {what}"
        time.sleep(1e-3)
    return time.monotonic() - began


def await_ends(pids: Iterable[int], patience: float = PATIENCE_S) -> None:
    """Waits until processes that another process started have ended and hold nothing any more."""
    for pid in pids:
        try:
            process = os.pidfd_open(pid)
        except ProcessLookupError:
            continue  # it has ended, and its parent knows
        try:
            ended, _, _ = select.select([process], [], [], patience)
            assert ended, f"process {pid} still runs after {patience} s"
        finally:
            os.close(process)


class Program:
    """A running program. Its output is collected while it runs; lines can be waited for. One that
    `listens` is told lines."""

    def __init__(
        self, command: Sequence[str | Path], env: Mapping[str, str], listens: bool = False
    ) -> None:
        self.command = [str(part) for part in command]
        self._process = subprocess.Popen(
            self.command,
            stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            bufsize=1,
            env=dict(env),
        )
        self.lines: list[str] = []
        self._fresh: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.lines.append(line.rstrip("\n"))
            self._fresh.put(line.rstrip("\n"))
        self._fresh.put(None)

    def tell(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()

    def end_of_input(self) -> None:
        if self._process.stdin is not None:
            self._process.stdin.close()

    def wait_for(self, text: str, patience: float = PATIENCE_S) -> str:
        """The next line that contains `text`; lines before it are passed over."""
        end = time.monotonic() + patience
        while True:
            try:
                line = self._fresh.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"no line with {text!r} in {patience} s from {self}") from None
            if line is None:
                raise AssertionError(f"{self} ended before it printed {text!r}")
            if text in line:
                return line

    def finish(self, patience: float = PATIENCE_S) -> int:
        """Waits for the end; the exit status, negative for a signal."""
        try:
            status = self._process.wait(patience)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still runs after {patience} s: {self}") from None
        self._reader.join(patience)
        self.end_of_input()
        if self._process.stdout is not None:
            self._process.stdout.close()
        return status

    def running(self) -> bool:
        return self._process.poll() is None

    def signal(self, number: int) -> None:
        if self.running():
            self._process.send_signal(number)

    def kill(self) -> int:
        """Gives the time in ns, of CLOCK_BOOTTIME, when it was gone."""
        self.signal(signal.SIGKILL)
        self._process.wait()  # with a time-out it looks only now and then
        gone = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        self.finish()
        return gone

    def terminate(self) -> int:
        """Stops a server, which reports that it is ready just before it handles the signal."""
        until(lambda: self._takes(signal.SIGTERM), f"{self} takes SIGTERM")
        self.signal(signal.SIGTERM)
        return self.finish()

    def _takes(self, number: signal.Signals) -> bool:
        status = Path(f"/proc/{self._process.pid}/status").read_text()
        caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
        return bool(int(caught.split()[1], 16) >> (number - 1) & 1)

    def output(self) -> str:
        """All it has printed, but for warnings that a busy machine did not let it run."""
        return "\n".join(line for line in self.lines if "this process stood still" not in line)

    def __str__(self) -> str:
        lines = "\n".join(self.lines)
        return f"{' '.join(self.command)}\n--- its output ---\n{lines}\n---"


class Laboratory:
    """A private laboratory: its own runtime directory, so it meets no other one on this machine."""

    def __init__(self, directory: Path, build: Path) -> None:
        self.build = build
        self.env = {
            **os.environ,
            "GECOS_RUNTIME_DIR": str(directory),
            "PYTHONUNBUFFERED": "1",
        }
        self.env.pop("GECOS_BROKER", None)
        self.env.pop("ROBCL_CLOCK", None)
        self.programs: list[Program] = []

    def start(
        self, *command: str | Path, ready: str | None = None, listens: bool = False
    ) -> Program:
        program = Program(command, self.env, listens)
        self.programs.append(program)
        if ready is not None:
            program.wait_for(ready)
        return program

    def run(self, *command: str | Path) -> Program:
        """Runs a program to its end."""
        program = self.start(*command)
        program.finish()
        return program

    def close(self) -> None:
        """Ends what still runs, last started first, and insists that it does end."""
        stuck = []
        for program in reversed(self.programs):
            program.signal(signal.SIGCONT)
            program.signal(signal.SIGTERM)
            try:
                program.finish(10.0)
            except AssertionError:
                program.kill()
                stuck.append(str(program))
        assert not stuck, "did not end on SIGTERM:\n" + "\n".join(stuck)


def laboratory(directory: Path, build: Path) -> Iterator[Laboratory]:
    lab = Laboratory(directory, build)
    try:
        yield lab
    finally:
        lab.close()
