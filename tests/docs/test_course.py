"""A lesson that fails is followed again only if the machine stood still."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Self

import pytest
from course import ATTEMPTS, LESSONS, STOOD_STILL_S, Course
from lateness import Watch
from pages import Reader
from terminals import Terminal


class OtherReader(Reader):
    """Notes the pages, and fails at some of them."""

    def __init__(self, pages: list[str], fails: list[bool]) -> None:
        super().__init__(self._no_terminal)
        self.pages, self.fails = pages, fails

    def _no_terminal(self, host: str) -> Terminal:
        raise AssertionError(f"a terminal of {host}")

    def follow(self, page: str) -> None:
        self.pages.append(page)
        assert not self.fails.pop(0), "ended before it printed 'there'"


class Watched(Watch):
    """Of a machine that was late once."""

    def __init__(self, late_s: float) -> None:
        super().__init__()
        self.late = [(0, round(late_s * 1e9))]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None: ...


class Setting:
    """A course in laboratories of which only the pages count."""

    def __init__(self, fails: list[bool], late_s: float) -> None:
        self.pages: list[str] = []
        self.said: list[str] = []
        self.laboratories = 0
        self._fails, self._late_s = fails, late_s
        self.course = Course(self.said.append, self._begin, self._watch)

    def _begin(self, until_its_end: ExitStack) -> Reader:
        self.laboratories += 1
        return until_its_end.enter_context(OtherReader(self.pages, self._fails))

    def _watch(self) -> Watch:
        return Watched(self._late_s)


FIRST, SECOND = LESSONS[:2]


def test_lessons_follow_each_other_in_one_laboratory() -> None:
    setting = Setting([False, False], late_s=1.0)
    setting.course.follow(FIRST)
    setting.course.follow(SECOND)
    assert (setting.pages, setting.laboratories, setting.said) == ([FIRST, SECOND], 1, [])


def test_the_course_begins_again_if_the_machine_stood_still() -> None:
    setting = Setting([False, True, False, False], late_s=STOOD_STILL_S)
    setting.course.follow(SECOND)
    assert (setting.pages, setting.laboratories) == ([FIRST, SECOND, FIRST, SECOND], 2)
    assert setting.said == [
        f"{SECOND}: a core stood still for 0.20 s; again after",
        "    ended before it printed 'there'",
    ]


def test_a_failure_on_a_machine_that_ran_is_one() -> None:
    setting = Setting([True], late_s=STOOD_STILL_S / 2)
    with pytest.raises(AssertionError, match="ended before"):
        setting.course.follow(FIRST)
    assert setting.said == []


def test_a_machine_that_stands_still_again_and_again_is_a_failure() -> None:
    setting = Setting([True] * ATTEMPTS, late_s=1.0)
    with pytest.raises(AssertionError, match="ended before"):
        setting.course.follow(FIRST)
    assert setting.laboratories == ATTEMPTS
