"""The lessons of the tutorial, in their order."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path

from hosts import Hosts
from pages import TREE, Reader, variables
from terminals import Terminal

STAND_INS = Path(__file__).parent / "stand_ins"
LESSONS = [
    f"docs/tutorial/{page.name}" for page in sorted((TREE / "docs/tutorial").glob("[1-9]-*"))
]


class Course:
    """The lessons, followed one after the other in one laboratory, which runs on from lesson to
    lesson. After a failure, a new laboratory begins with the first lesson."""

    def __init__(self) -> None:
        self._laboratory = ExitStack()
        self._reader: Reader | None = None
        self._followed: list[str] = []

    def follow(self, lesson: str) -> None:
        """Follows the lessons before it, too, unless that has been done."""
        if self._reader is None:
            self._reader = self._begin()
        try:
            for page in LESSONS[: LESSONS.index(lesson) + 1]:
                if page not in self._followed:
                    self._reader.follow(page)
                    self._followed.append(page)
        except BaseException as error:
            self._reader, self._followed = None, []
            self._laboratory.__exit__(type(error), error, error.__traceback__)
            raise

    def close(self) -> None:
        self._laboratory.close()

    def _begin(self) -> Reader:
        hosts = self._laboratory.enter_context(Hosts())
        folder = self._laboratory.enter_context(tempfile.TemporaryDirectory(prefix="pages-"))
        env = variables(Path(folder) / "home", STAND_INS)
        reader = Reader(lambda _: Terminal(env, TREE, hosts.on(0)))
        return self._laboratory.enter_context(reader)
