"""On which threads the handlers of a Python servant run, and what becomes of what they do."""

from __future__ import annotations

import asyncio
import os
import re
import sys
import threading
from queue import SimpleQueue
from typing import NoReturn

import gecos
import pytest
from gecos import Detail, State
from gecos.cli import main
from lamp import Burnt, Lamp, PlainLamp


def test_a_sensor_call_is_answered_while_a_command_runs(held: Lamp, servant: PlainLamp) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    assert held.label().result() == "a lamp"
    assert burning.state is State.RUNNING
    servant.finish.set()
    burning.result()


def test_objects_of_one_server_do_not_wait_for_each_other(
    lab: gecos.Lab, server: gecos.Server, held: Lamp, servant: PlainLamp
) -> None:
    server.add("LAMP2", PlainLamp())
    lamp2 = lab.create(Lamp, "LAMP2")
    asked, go = threading.Event(), threading.Event()
    servant.before_label = lambda: (asked.set(), go.wait(30.0))
    with gecos.actor(lamp2):
        burning, labelled = held.burn_in(), held.label()
        servant.burning.wait()
        asked.wait()
        assert lamp2.dim(1.0).result() == 0.0
        assert lamp2.label().result() == "a lamp"
        assert (burning.state, labelled.state) == (State.RUNNING, State.RUNNING)
    servant.finish.set()
    go.set()
    burning.result()
    labelled.result()


class Asking(PlainLamp):
    """Does what it is asked by asking another one."""

    def __init__(self, other: Lamp) -> None:
        super().__init__()
        self.other = other

    def dim(self, by: float) -> float:
        return self.other.dim(by).result()

    def label(self) -> str:
        return self.other.label().result()


def test_a_handler_may_wait_for_another_object_of_its_server(
    lab: gecos.Lab, server: gecos.Server, held: Lamp
) -> None:
    server.add("ASKING", Asking(held))
    asking = lab.create(Lamp, "ASKING")
    with gecos.actor(asking):
        assert asking.dim(1.0).result() == 0.0
        assert asking.label().result() == "a lamp"


class Leaving(PlainLamp):
    """`burn_in` leaves a thread behind that waits for an interruption of its call."""

    def __init__(self) -> None:
        super().__init__()
        self.ended: SimpleQueue[str] = SimpleQueue()

    def burn_in(self, run: gecos.Execution[None]) -> None:
        waits = threading.Event()

        def watch() -> None:
            try:
                while not run.wait_interrupted(0.0 if not waits.is_set() else 30.0):
                    waits.set()
                self.ended.put("interrupted")
            except ValueError as error:
                self.ended.put(str(error))

        threading.Thread(target=watch, daemon=True).start()
        waits.wait()


def test_a_thread_that_waits_longer_than_its_handler_runs_is_told_so(
    lab: gecos.Lab, server: gecos.Server
) -> None:
    servant = Leaving()
    server.add("LEAVING", servant)
    leaving = lab.create(Lamp, "LEAVING")
    with gecos.actor(leaving):
        for _ in range(3):
            leaving.burn_in().result()
            assert servant.ended.get(timeout=20.0) == "the call was answered already"
        assert leaving.dim(1.0).result() == 0.0, "the server goes on"


def test_a_stop_does_not_wait_for_readings(lamp: Lamp, servant: PlainLamp) -> None:
    asked, go = threading.Event(), threading.Event()
    servant.before_label = lambda: (asked.set(), go.wait(30.0))
    first, second = lamp.label(), lamp.label()
    asked.wait()
    gecos.stop(lamp).result()
    assert servant.stopped.wait(30.0)
    assert first.state is State.RUNNING
    go.set()
    assert [first.result(), second.result()] == ["a lamp", "a lamp"]


def test_a_reading_that_is_canceled_while_a_command_has_the_thread_never_starts(
    held: Lamp, servant: PlainLamp
) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    watched = held.watch()
    watched.cancel()
    gecos.ping(held).result()  # behind the cancel
    servant.finish.set()
    burning.result()
    assert watched.wait() is State.COMMAND_FAILED
    assert watched.progress().detail is Detail.CANCELED
    assert servant.starts == ["burn_in"]


class Unspeakable(Exception):
    def __init__(self, instead: BaseException) -> None:
        self.instead = instead

    def __str__(self) -> str:
        raise self.instead


class Unquotable(Exception):
    @property
    def __notes__(self) -> NoReturn:
        raise ValueError


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (SystemExit(3), "the handler of 'label' raised SystemExit, which it does not declare: 3"),
        (KeyboardInterrupt(), "'label' raised KeyboardInterrupt, which it does not declare"),
        (asyncio.CancelledError(), "'label' raised CancelledError, which it does not declare"),
        (
            Unspeakable(ValueError()),
            "Unspeakable, which it does not declare: str() of the exception raised ValueError",
        ),
        (
            Unspeakable(SystemExit()),
            "Unspeakable, which it does not declare: str() of the exception raised SystemExit",
        ),
        (Unquotable("burnt"), "'label' raised Unquotable, which it does not declare: burnt"),
        (RuntimeError("\ud800\0"), r"raised RuntimeError, which it does not declare: \ud800\0"),
        (
            RuntimeError("x" * 1_000_000),
            "'label' raised RuntimeError, which it does not declare: xxx",
        ),
        (
            Burnt(hours="many"),
            "'label' raised Burnt, which it does not declare: test::Burnt(hours='many')",
        ),  # type: ignore[arg-type]
        (
            gecos.CommandFailed(Detail.SERVER_CRASHED, "another one"),
            "raised CommandFailed, which it does not declare: SERVER_CRASHED: another",
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else "",
)
@pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
def test_whatever_a_handler_raises_ends_its_call_and_no_other(
    lamp: Lamp, servant: PlainLamp, raised: BaseException, said: str
) -> None:
    def fail() -> None:
        raise raised

    servant.before_label = fail
    with pytest.raises(gecos.CommandFailed, match=re.escape(said)) as caught:
        lamp.label().result(30)
    assert caught.value.detail is Detail.FAULT
    servant.before_label = lambda: None
    assert lamp.label().result(30) == "a lamp"


def test_a_child_that_a_handler_forked_ends_and_leaves_the_answer_to_its_parent(
    lamp: Lamp, servant: PlainLamp
) -> None:
    children: list[int] = []
    servant.before_label = lambda: children.append(os.fork())
    assert lamp.label().result() == "a lamp"
    (child,) = (pid for pid in children if pid != 0)
    assert os.waitpid(child, 0)[0] == child
    servant.before_label = lambda: None
    assert lamp.label().result() == "a lamp"


def test_a_handler_knows_its_caller(held: Lamp, servant: PlainLamp) -> None:
    import os

    seen: list[gecos.Caller] = []

    def shine(goal: float, run: gecos.Execution[object]) -> None:
        seen.append(run.caller)

    servant.shine = shine  # type: ignore[method-assign,assignment]
    held.shine(1.0).result()
    assert seen[0].pid == os.getpid()


def names_while_it_closes(
    server: gecos.Server, handler: str, capfd: pytest.CaptureFixture[str], go_on: threading.Event
) -> None:
    """Closing says that it waits for `handler`, and ends when that may go on."""
    closing = threading.Thread(target=server.close)
    closing.start()
    said = ""
    while f"closing waits for the handler {handler}" not in said:
        assert closing.is_alive(), said
        said += capfd.readouterr().err
    go_on.set()
    closing.join(30)
    assert not closing.is_alive()


def test_a_handler_that_closing_waits_for_is_named(
    lamp: Lamp,
    server: gecos.Server,
    servant: PlainLamp,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("gecos.server._PATIENCE_WITH_HANDLERS", 0.01)
    begun, go_on = threading.Event(), threading.Event()
    servant.before_label = lambda: (begun.set(), go_on.wait(30))
    running = lamp.label()
    assert begun.wait(30)
    names_while_it_closes(server, "PlainLamp.label", capfd, go_on)
    assert running.wait(30) is not State.RUNNING


def test_a_stop_that_closing_waits_for_is_named(
    lamp: Lamp,
    server: gecos.Server,
    servant: PlainLamp,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("gecos.server._PATIENCE_WITH_HANDLERS", 0.01)
    begun, go_on = threading.Event(), threading.Event()
    monkeypatch.setattr(servant, "gecos_on_stop", lambda: (begun.set(), go_on.wait(30)))
    gecos.stop(lamp).result(30)
    assert begun.wait(30)
    names_while_it_closes(server, "PlainLamp.gecos_on_stop", capfd, go_on)


def test_handlers_may_close_their_server_both_at_once(
    held: Lamp, server: gecos.Server, servant: PlainLamp, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = threading.Barrier(2)

    def close() -> str:
        inside.wait(30)
        server.close()
        return ""

    monkeypatch.setattr(servant, "label", close)
    monkeypatch.setattr(servant, "shine", lambda *_: close())
    running = [held.label(), held.shine(1)]
    for command in running:
        assert command.wait(30) is not State.RUNNING
    server.close()


def test_an_exception_that_only_other_operations_declare_is_named_as_undeclared(
    lamp: Lamp, servant: PlainLamp
) -> None:
    def fail() -> None:
        raise Burnt(hours=9)

    servant.before_label = fail
    with pytest.raises(gecos.CommandFailed) as caught:
        lamp.label().result()
    assert not isinstance(caught.value, Burnt)
    assert caught.value.text == (
        "the handler of 'label' raised Burnt, which it does not declare: test::Burnt(hours=9)"
    )


def test_a_handler_that_nothing_interrupted_cannot_end_as_canceled(
    lamp: Lamp, servant: PlainLamp
) -> None:
    def fail() -> None:
        raise gecos.Interrupted

    servant.before_label = fail
    with pytest.raises(gecos.CommandFailed, match="but nothing interrupted it") as caught:
        lamp.label().result()
    assert caught.value.detail is gecos.Detail.FAULT


@pytest.mark.parametrize("medium", ["inproc", "shm", "lcm"])
def test_a_handler_that_waits_for_its_own_thread_is_told_so(
    lab: gecos.Lab, server: gecos.Server, servant: PlainLamp, medium: str
) -> None:
    lamp = lab.create(Lamp, "LAMP", medium=medium)
    servant.before_label = lambda: lamp.label().result()
    with pytest.raises(gecos.CommandFailed, match="raised CommandFailed, which") as caught:
        lamp.label().result()
    assert (
        "REJECTED: 'label' of LAMP was not started: the handler of 'label' of LAMP waits for"
        in (caught.value.text)
    )
    servant.before_label = lambda: None
    assert lamp.label().result() == "a lamp"


def test_two_handlers_that_wait_for_each_other_are_told_so(
    lab: gecos.Lab, server: gecos.Server, lamp: Lamp, servant: PlainLamp
) -> None:
    other = PlainLamp()
    server.add("OTHER", other)
    far = lab.create(Lamp, "OTHER")
    told: list[BaseException] = []

    def ask_back() -> None:
        try:
            lamp.label().result()
        except gecos.CommandFailed as error:
            told.append(error)

    servant.before_label = lambda: far.label().result()
    other.before_label = ask_back
    assert lamp.label().result() == "a lamp"
    assert len(told) == 1
    assert (
        "the handler of 'label' of OTHER waits for this call, and this call cannot start before"
        in str(told[0])
    )


def test_a_handler_that_waits_in_its_objects_queue_is_told_so(
    held: Lamp, servant: PlainLamp
) -> None:
    """What it waits for is an actor command, which has not come to the thread of the handlers."""
    outcomes: list[State] = []

    def shine(goal: float, run: gecos.Execution[object]) -> None:
        outcomes.append(held.dim(1.0).wait())

    servant.shine = shine  # type: ignore[method-assign,assignment]
    held.shine(1.0).result()
    assert outcomes == [State.COMMAND_FAILED]


def test_describe_shows_a_handler_that_runs_and_what_it_waits_for(
    lab: gecos.Lab,
    server: gecos.Server,
    lamp: Lamp,
    servant: PlainLamp,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    other = PlainLamp()
    server.add("OTHER", other)
    far = lab.create(Lamp, "OTHER")
    go_on = threading.Event()
    other.before_label = go_on.wait
    servant.before_label = lambda: far.label().result()
    label = lamp.label()
    while not [h for h in gecos.describe(lamp).result().handlers if h.waits_for]:
        assert label.state is State.RUNNING
    monkeypatch.setattr(sys, "argv", ["gecos", "describe", "LAMP"])
    assert main() == 0
    go_on.set()
    assert label.result() == "a lamp"
    lines = capsys.readouterr().out.splitlines()
    (line,) = [line for line in lines if line.lstrip().startswith("handler")]
    assert re.fullmatch(
        rf" *handler +label for \d+\.\d s, called by .+ on .+ \(.+, pid {os.getpid()}\), "
        r"waits for OTHER.label",
        line,
    )
