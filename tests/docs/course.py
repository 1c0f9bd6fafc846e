"""The lessons of the tutorial, in their order."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from hosts import Hosts
from lateness import Watch
from pages import TREE, Reader, variables
from terminals import Terminal

STAND_INS = Path(__file__).parent / "stand_ins"
LESSONS = [
    f"docs/tutorial/{page.name}" for page in sorted((TREE / "docs/tutorial").glob("[1-9]-*"))
]
ATTEMPTS = 3
STOOD_STILL_S = 0.2
"""A simulated arm ends its motion when its program has stood still for 0.5 s, and the programs of
the lessons stop it when their newest sample is older than 0.2 s. No page expects that."""


def laboratory(until_its_end: ExitStack) -> Reader:
    """Somebody at the terminals of a new laboratory."""
    hosts = until_its_end.enter_context(Hosts())
    folder = until_its_end.enter_context(tempfile.TemporaryDirectory(prefix="pages-"))
    env = variables(Path(folder) / "home", STAND_INS)
    reader = Reader(lambda _: Terminal(env, TREE, hosts.on(0)))
    return until_its_end.enter_context(reader)


class Course:
    """The lessons, followed one after the other in one laboratory, which runs on from lesson to
    lesson. After a failure, a new laboratory begins with the first lesson."""

    def __init__(
        self,
        tell: Callable[[str], object],
        begin: Callable[[ExitStack], Reader] = laboratory,
        watch: Callable[[], Watch] = Watch,
    ) -> None:
        self._tell, self._begin, self._watch = tell, begin, watch
        self._laboratory = ExitStack()
        self._reader: Reader | None = None
        self._followed: list[str] = []

    def follow(self, lesson: str) -> None:
        """Follows the lessons before it, too, unless that has been done. Raises AssertionError with
        the first block that does not do what the page says. If the machine stood still meanwhile,
        tells so with that block, and begins again."""
        for attempt in range(1, ATTEMPTS + 1):
            with self._watch() as machine:
                try:
                    self._follow(lesson)
                    return
                except AssertionError as failure:
                    late = machine.longest_s()
                    if late < STOOD_STILL_S or attempt == ATTEMPTS:
                        raise
                    self._tell(f"{lesson}: a core stood still for {late:.2f} s; again after")
                    self._tell(f"    {str(failure).splitlines()[0]}")

    def close(self) -> None:
        self._laboratory.close()

    def _follow(self, lesson: str) -> None:
        if self._reader is None:
            self._reader = self._begin(self._laboratory)
        try:
            for page in LESSONS[: LESSONS.index(lesson) + 1]:
                if page not in self._followed:
                    self._reader.follow(page)
                    self._followed.append(page)
        except BaseException as error:
            self._reader, self._followed = None, []
            self._laboratory.__exit__(type(error), error, error.__traceback__)
            raise
