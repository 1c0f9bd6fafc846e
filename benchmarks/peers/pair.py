"""A server and its clients as processes, spoken to line by line as speaker.hpp says."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

PATIENCE_S = 60.0
"""How long a program may stay silent: far more than any of them needs."""


class Broken(RuntimeError):
    """A program ended, or said nothing; with what it wrote to its standard error."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """One measured pair of programs. `peer` is the library that it needs, "" for none."""

    name: str
    peer: str
    server: tuple[str | Path, ...]
    client: tuple[str | Path, ...]

    def programs(self) -> list[Path]:
        """Files that must be there for it to run."""
        return [part for part in (*self.server, *self.client) if isinstance(part, Path)]


def ran_for(task: Path) -> float:
    """Seconds that a thread, given by its folder in /proc, has had a core."""
    return int((task / "schedstat").read_text().split()[0]) * 1e-9


class Process:
    """One program, on the given cores; says that it is ready before the constructor returns."""

    def __init__(
        self, command: Sequence[str | Path], cores: Sequence[int], env: dict[str, str]
    ) -> None:
        self._command = [str(part) for part in command]
        self._errors: IO[str] = tempfile.TemporaryFile("w+")  # noqa: SIM115  closed by end()
        self._buffer = b""
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=env,
            preexec_fn=lambda: os.sched_setaffinity(0, cores),
        )
        try:
            # Libraries may write lines of their own before.
            while not (line := self.line()).startswith("ready "):
                pass
        except Broken:
            self.end()
            raise
        self.address = line.removeprefix("ready ").strip() or "-"

    def line(self) -> str:
        assert self._process.stdout is not None
        file = self._process.stdout.fileno()
        while b"\n" not in self._buffer:
            readable, _, _ = select.select([file], [], [], PATIENCE_S)
            fresh = os.read(file, 65536) if readable else b""
            if not fresh:
                what = "ended" if readable else f"said nothing for {PATIENCE_S:.0f} s"
                raise Broken(f"{' '.join(self._command)} {what}:\n{self._said_of_errors()}")
            self._buffer += fresh
        line, self._buffer = self._buffer.split(b"\n", 1)
        return line.decode()

    def say(self, question: str) -> None:
        assert self._process.stdin is not None
        with contextlib.suppress(
            BrokenPipeError
        ):  # the reader of the answer reports why the program ended
            self._process.stdin.write(question.encode() + b"\n")
            self._process.stdin.flush()

    def ran_for(self) -> float:
        """Seconds that its threads have had a core."""
        threads = Path(f"/proc/{self._process.pid}/task").iterdir()
        return sum(ran_for(thread) for thread in threads)

    def _said_of_errors(self) -> str:
        self._errors.seek(0)
        return self._errors.read()[-2000:]

    def close_input(self) -> None:
        """A client ends by itself at the end of its input."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # it ended before it took what it was asked
            self._process.stdin.close()

    def end(self) -> None:
        """Asks it to end, by SIGTERM; kills what does not."""
        for how in (signal.SIGTERM, signal.SIGKILL):
            self._process.send_signal(how)
            try:
                self._process.wait(10.0)
                break
            except subprocess.TimeoutExpired:
                print(f"bench-peers: {self._command[0]} does not end", file=sys.stderr)
        for pipe in (self._process.stdin, self._process.stdout, self._errors):
            if pipe is not None:
                pipe.close()

    def wait(self) -> None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(10.0)
        self.end()


class Pair:
    """A server and its clients. The program that was started last ends first."""

    def __init__(self, candidate: Candidate, core: int, env: dict[str, str]) -> None:
        self._candidate = candidate
        self._env = env
        self._clients: list[Process] = []
        self.server = Process(candidate.server, [core], env)

    def client(self, cores: Sequence[int], user: str = "") -> Process:
        """Starts a client, which becomes `user` where one is named. Only ours can."""
        env = {**self._env, "BENCHMARK_USER": user}
        client = Process((*self._candidate.client, self.server.address), cores, env)
        self._clients.append(client)
        return client

    def close(self) -> None:
        for client in reversed(self._clients):
            client.close_input()
        for client in reversed(self._clients):
            client.wait()
        self.server.end()
