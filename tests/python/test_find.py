"""What `gecos.dynamic_client.connect.find` says when it has waited in vain, with a fake clock."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

import pytest
from gecos.dynamic_client import connect
from gecos.errors import Attempt, CreateError, Detail

REFUSAL = 'the broker refuses this program: add "ben" to its users'


@dataclass(slots=True)
class Clock:
    now: float = 0.0

    def monotonic(self) -> float:
        return self.now


@dataclass(slots=True)
class RefusingLab:
    """A Lab whose broker refuses this program, and takes `takes` s for that. It is the Lab's watch
    of the objects, too."""

    clock: Clock
    takes: float
    asked: list[float] = field(default_factory=list)  # when, in s

    def broker(self, interface: object, *, patience: float) -> Any:
        self.asked.append(self.clock.now)
        self.clock.now += min(patience, self.takes)
        late = patience <= self.takes
        reason = "shm:BROKER.sock: the broker did not answer" if late else REFUSAL
        raise CreateError([Attempt("BROKER", Detail.NO_SERVER, reason)])

    @contextlib.contextmanager
    def watch(self) -> Iterator[RefusingLab]:
        yield self

    def next(self, timeout: float) -> Any:
        self.clock.now += timeout
        raise TimeoutError


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(connect, "time", clock)
    return clock


@pytest.mark.parametrize("wait", [0.0, 0.5, 1.0, 1.5, 2.0, 10.0])
@pytest.mark.parametrize("takes", [0.0, 0.01, 0.15, 0.5])
def test_a_wait_of_a_refused_user_ends_with_the_refusal(
    clock: Clock, wait: float, takes: float
) -> None:
    lab: Any = RefusingLab(clock, takes)
    with pytest.raises(CreateError) as failed:
        connect.find(lab, "LDS", wait=wait)
    assert failed.value.attempts[0].reason == REFUSAL
    assert wait <= clock.now <= wait + max(takes, 0.2), "the wait is as long as it was asked for"


class LateRefusal(RefusingLab):
    """A broker that does not answer at first, and refuses after the whole patience of the last
    attempt, which is shorter than the others. That is a refusal for good, as of a wrong key."""

    def broker(self, interface: object, *, patience: float) -> Any:
        self.asked.append(self.clock.now)
        self.clock.now += patience
        if patience < 2.0:
            raise CreateError([Attempt("BROKER", Detail.REFUSED, REFUSAL)])
        raise CreateError([Attempt("BROKER", Detail.NO_SERVER, "the broker did not answer")])


def test_a_wait_ends_with_a_definite_answer_that_came_in_the_last_moment(clock: Clock) -> None:
    lab: Any = LateRefusal(clock, 2.0)
    with pytest.raises(CreateError) as failed:
        connect.find(lab, "LDS", wait=3.5)
    assert failed.value.attempts[0].detail is Detail.REFUSED
    assert len(lab.asked) > 1, "the first attempt has another error"


class ListingLab(RefusingLab):
    """A Lab whose broker lists no object, and which is the command with the answer, too."""

    patiences: ClassVar[list[float]] = []

    def broker(self, interface: object, *, patience: float) -> Any:
        self.patiences.append(patience)
        return self

    def __getattr__(self, name: str) -> Any:  # `list` or `silent`
        return lambda: self

    def result(self) -> tuple[Any, ...]:
        return ()


def test_the_question_about_silence_has_the_patience_of_the_attempt(clock: Clock) -> None:
    lab: Any = ListingLab(clock, 0.0)
    with pytest.raises(CreateError, match="no such object is online"):
        connect.find(lab, "LDS", patience=0.3)
    assert lab.patiences == [0.3, 0.3]


def test_a_broker_that_refuses_may_admit_later(clock: Clock) -> None:
    lab: Any = RefusingLab(clock, 0.01)
    with pytest.raises(CreateError):
        connect.find(lab, "LDS", wait=10.0)
    assert len(lab.asked) >= 10, "a server that starts may make this user a visitor"


def test_a_broker_that_never_answers_is_said_to_be_silent(clock: Clock) -> None:
    lab: Any = RefusingLab(clock, 60.0)
    with pytest.raises(CreateError, match="did not answer"):
        connect.find(lab, "LDS", wait=1.5)
