"""Terminals at which a page's commands are typed: shells that run one block after the other."""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

PATIENCE_S = 100.0
"""How long a test waits for a line or the end of a block: a miss is a defect."""

# Reads blocks of commands, each up to a NUL; says which commands fail, and when a block is done.
# The shell survives Ctrl-C, as one at a terminal does; the command that runs does not.
SHELL = r"""
set -E
trap 'failed=$?; [[ $BASH_COMMAND == eval* ]] || echo "<failed $failed> $BASH_COMMAND"' ERR
trap : INT
while IFS= read -r -d '' block; do eval "$block" </dev/null; echo "<done>"; done
"""
DONE = "<done>"
FAILED = re.compile(r"<failed (\d+)> ")


def pattern_of(line: str) -> re.Pattern[str]:
    """Finds an expected line: … stands for any text, a blank for any number of them."""
    words = map(re.escape, line.split())
    return re.compile(r"\s+".join(words).replace("…", ".*"))


class Terminal:
    """A shell in a folder. Its programs are in one process group, which ends with the terminal."""

    def __init__(self, env: Mapping[str, str], folder: Path, within: Sequence[str] = ()) -> None:
        """`within`: words in front of the shell, which enter a namespace."""
        self._alive, held = os.pipe()  # held open by all programs that this terminal starts
        self._shell = subprocess.Popen(
            [*within, "bash", "-c", SHELL],
            cwd=folder,
            env=dict(env),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
            pass_fds=(held,),
        )
        os.close(held)
        self.running: str | None = None
        """The block that was typed and has not ended."""
        self._lines: list[str] = []
        self._of_block: list[str] = []
        self._fresh: queue.Queue[str] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def found(self, pattern: re.Pattern[str]) -> list[str]:
        """What the blocks have printed that matches, in its order."""
        return [found[0] for line in self._lines for found in pattern.finditer(line)]

    def type(self, block: str) -> None:
        assert self.running is None, f"still runs here: {self.running}\n{self}"
        assert self._shell.stdin is not None
        self.running, self._of_block = block, []
        self._shell.stdin.write(block + "\0")
        self._shell.stdin.flush()

    def see(self, lines: Sequence[str]) -> None:
        """Waits until the block has printed each of the lines, in their order."""
        for wanted in lines:
            self._until(pattern_of(wanted).search, repr(wanted))

    def finish(self, status: int = 0) -> list[str]:
        """Waits for the end of the block; what it printed. Asserts that all its commands succeed,
        or that one fails with `status`."""
        self._until(DONE.__eq__, "the end")
        block, self.running = self.running, None
        failed = [int(found[1]) for line in self._of_block if (found := FAILED.match(line))]
        wanted = [status] if status else []
        assert failed == wanted, f"{block}failed with {failed}, not with {wanted}:\n{self}"
        return self._of_block[:-1]

    def interrupt(self, lines: Sequence[str] = ()) -> None:
        """Ctrl-C: waits until the block has printed the lines and has ended."""
        os.killpg(self._shell.pid, signal.SIGINT)
        self.see(lines)
        self._until(DONE.__eq__, "the end after Ctrl-C")
        self.running = None

    def close(self) -> None:
        """Ends the shell and all programs that it started. Asserts that they end on SIGTERM."""
        os.killpg(self._shell.pid, signal.SIGCONT)
        os.killpg(self._shell.pid, signal.SIGTERM)
        stuck = threading.Event()

        def insist() -> None:
            stuck.set()
            os.killpg(self._shell.pid, signal.SIGKILL)

        killer = threading.Timer(PATIENCE_S, insist)
        killer.start()
        os.read(self._alive, 1)  # returns when the last of them has ended
        killer.cancel()
        os.close(self._alive)
        assert self._shell.stdin is not None and self._shell.stdout is not None
        self._shell.wait()
        self._reader.join()
        self._shell.stdin.close()
        self._shell.stdout.close()
        assert not stuck.is_set(), f"a program does not end on SIGTERM:\n{self}"

    def __str__(self) -> str:
        return "--- printed ---\n" + "\n".join(self._lines) + "\n---"

    def _until(self, found: Callable[[str], object], what: str) -> None:
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                line = self._fresh.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                raise AssertionError(f"not within {PATIENCE_S} s: {what}\n{self}") from None
            self._of_block.append(line)
            if found(line):
                return
            if line == DONE:
                block, self.running = self.running, None
                raise AssertionError(f"ended before it printed {what}: {block}\n{self}")

    def _read(self) -> None:
        assert self._shell.stdout is not None
        for line in self._shell.stdout:
            self._lines.append(line.rstrip("\n"))
            self._fresh.put(line.rstrip("\n"))
        self._fresh.put(DONE)
