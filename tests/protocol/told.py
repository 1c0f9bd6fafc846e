"""Our clients, which do what they are told while the speaker answers them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from processes import Laboratory, Program
from speaker.lcm import Loop

PROGRAMS = Path(__file__).resolve().parent / "programs"
LANGUAGES = ["cpp", "python"]
OPEN = ("SENT", "QUEUED", "EXECUTING", "CANCELING", "UNREACHABLE")


def command_of(lab: Laboratory, language: str) -> list[str | Path]:
    if language == "cpp":
        return [lab.build / "tests" / "protocol" / "partner_client"]
    return [sys.executable, PROGRAMS / "partner_client.py"]


class Client:
    """A client program, and the lines of it that nobody asked for yet."""

    def __init__(self, program: Program, loop: Loop) -> None:
        self.program = program
        self._loop = loop
        self._read = len(program.lines)
        self._fresh: list[str] = []

    def tell(self, line: str) -> None:
        self.program.tell(line)

    def _collect(self) -> None:
        lines = self.program.lines[self._read :]
        self._read += len(lines)
        self._fresh += lines

    def has(self, start: str) -> bool:
        self._collect()
        return any(line.startswith(start) for line in self._fresh)

    def says(self, start: str, patience: float = 30.0) -> str:
        """The rest of its next line that begins so; the speaker speaks meanwhile."""

        def happened() -> bool:
            return self.has(start) or not self.program.running()

        self._loop.until(happened, f"{start!r} from {self.program}", patience)
        if not self.has(start):
            self.program.finish()  # it has ended: what it said last is read by then
        assert self.has(start), f"it ended without saying {start!r}: {self.program}"
        line = next(line for line in self._fresh if line.startswith(start))
        self._fresh.remove(line)
        return line.removeprefix(start).strip()

    def opens(self, name: str) -> None:
        self.tell(f"open {name}")
        self.says(f"opened {name}")

    def issues(self, tag: str, what: str) -> None:
        self.tell(f"issue {tag} {what}")

    def ends(self, tag: str, patience: float = 30.0) -> str:
        """State, detail, and the result or why there is none."""
        return self.says(f"{tag} ended", patience)

    def stands(self, tag: str, like: str) -> str:
        """Looks at a command until it stands so."""
        while True:
            self.tell(f"look {tag}")
            at = self.says(f"{tag} stands")
            if at.startswith(like):
                return at
            assert at.startswith(OPEN), f"{tag} ended {at!r}, was not {like!r}: {self.program}"

    def acquires(self) -> int:
        self.tell("acquire")
        return int(self.says("acquired"))

    def end(self) -> None:
        """It ends when nobody tells it anything any more."""
        self.program.end_of_input()
        self.says("done")
        assert self.program.finish() == 0, str(self.program)


@contextmanager
def client_of(lab: Laboratory, language: str, loop: Loop) -> Iterator[Client]:
    program = lab.start(*command_of(lab, language), ready="ready", listens=True)
    client = Client(program, loop)
    yield client
    client.end()
