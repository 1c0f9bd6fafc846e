from __future__ import annotations

import asyncio
import gc
import pydoc
import queue
import select
import sys
import threading
import warnings
from collections.abc import Callable
from types import FrameType

import gecos
import pytest
from gecos import Detail, State
from lamp import DIM, Burnt, Glow, Lamp, PlainLamp
from test_process import running


def test_a_finished_command_gives_its_result(held: Lamp) -> None:
    held.shine(80.0).result()
    dimmed = held.dim(4.0)
    assert dimmed.wait() is State.FINISHED
    assert dimmed.result() == 20.0
    assert dimmed.progress().detail is Detail.DONE
    assert dimmed.exception() is None


def test_a_command_runs_until_it_is_terminal(held: Lamp, servant: PlainLamp) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    assert burning.state is State.RUNNING
    assert burning.wait(0.0) is State.RUNNING
    servant.finish.set()
    assert burning.wait() is State.FINISHED


def test_a_result_that_takes_too_long_leaves_it_running(held: Lamp, servant: PlainLamp) -> None:
    burning = held.burn_in()
    with pytest.raises(TimeoutError, match=r"burn_in is still running after 0\.001 s"):
        burning.result(0.001)
    servant.finish.set()
    burning.result()


def test_a_declared_exception_is_raised_again_with_its_members(held: Lamp) -> None:
    shining = held.shine(1200.0)
    with pytest.raises(Burnt) as caught:
        shining.result()
    assert caught.value.hours == 1200
    assert caught.value.detail is Detail.FAULT
    assert str(caught.value) == "test::Burnt(hours=1200)"
    assert shining.state is State.COMMAND_FAILED


def test_a_declared_exception_is_a_failed_command(held: Lamp) -> None:
    with pytest.raises(gecos.CommandFailed):
        held.shine(1200.0).result()


def test_any_other_exception_is_a_fault_with_its_text(
    held: Lamp, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(gecos.CommandFailed, match="raised ZeroDivisionError, which") as caught:
        held.dim(0.0).result()
    assert caught.value.detail is Detail.FAULT
    assert not isinstance(caught.value, gecos.DeclaredError)
    written = capfd.readouterr().err.splitlines()
    assert (
        "gecos error server: LAMP: the handler of 'dim' raised ZeroDivisionError, which it does "
        "not declare: dimmed by nothing"
    ) in written
    assert "gecos error server: Traceback (most recent call last):" in written
    assert "gecos error server: ZeroDivisionError: dimmed by nothing" in written


def test_a_handler_may_reject_a_command(held: Lamp) -> None:
    with pytest.raises(gecos.CommandFailed, match="does not shine darkness") as caught:
        held.shine(-1.0).result()
    assert caught.value.detail is Detail.REJECTED


def test_arguments_that_do_not_decode_are_a_bad_parameter(held: Lamp) -> None:
    command = held._gecos_call(DIM, [b"\0\0"])
    with pytest.raises(gecos.CommandFailed, match="dim: field 'value' at byte 0") as caught:
        command.result()
    assert caught.value.detail is Detail.BAD_PARAMETER


def test_moving_without_status_is_denied(lamp: Lamp) -> None:
    with pytest.raises(gecos.CommandFailed, match="actor") as caught:
        lamp.dim(2.0).result()
    assert caught.value.detail is Detail.DENIED


def test_a_canceled_command_ends_as_canceled(held: Lamp, servant: PlainLamp) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    burning.cancel()
    assert burning.wait() is State.COMMAND_FAILED
    assert burning.progress().detail is Detail.CANCELED
    assert servant.interrupted.wait()


def test_progress_of_a_running_command_is_a_fraction(held: Lamp, servant: PlainLamp) -> None:
    burning = held.burn_in()
    while burning.progress().fraction < 0.25:
        assert burning.wait(0.001) is State.RUNNING
    assert burning.progress().detail is Detail.EXECUTING
    servant.finish.set()
    burning.result()


def test_a_queued_command_knows_its_position(held: Lamp, servant: PlainLamp) -> None:
    burning, first, second = held.burn_in(), held.dim(1.0), held.dim(1.0)
    while second.progress().detail is not Detail.QUEUED or second.progress().position != 2:
        assert second.wait(0.001) is State.RUNNING
    servant.finish.set()
    for command in (burning, first, second):
        command.wait()
    assert servant.starts == ["burn_in", "dim", "dim"]


def test_feedback_is_typed(held: Lamp) -> None:
    shining = held.shine(42.0)
    shining.result()
    assert shining.feedback() == Glow(42.0)


def test_a_command_without_feedback_has_none(held: Lamp) -> None:
    dimmed = held.dim(1.0)
    dimmed.result()
    assert dimmed.feedback() is None


def test_awaiting_gives_the_result(held: Lamp, servant: PlainLamp) -> None:
    async def program() -> float:
        burning = held.burn_in()
        asyncio.get_running_loop().call_soon(servant.finish.set)
        await burning
        return await held.dim(1.0)

    servant.value = 7.0
    assert asyncio.run(program()) == 7.0


def test_awaiting_raises_what_went_wrong(held: Lamp) -> None:
    async def program() -> None:
        await held.shine(1200.0)

    with pytest.raises(Burnt):
        asyncio.run(program())


def test_several_tasks_may_await_one_command(held: Lamp, servant: PlainLamp) -> None:
    async def wait_for(command: gecos.Command[float]) -> float:
        return await command

    async def program() -> list[float]:
        burning, dimmed = held.burn_in(), held.dim(2.0)
        tasks = [asyncio.ensure_future(wait_for(dimmed)) for _ in range(3)]
        asyncio.get_running_loop().call_soon(servant.finish.set)
        await burning
        return await asyncio.gather(*tasks)

    servant.value = 6.0
    assert asyncio.run(program()) == [3.0] * 3


def test_a_canceled_task_leaves_the_command_running(held: Lamp, servant: PlainLamp) -> None:
    async def program() -> gecos.Command[None]:
        burning = held.burn_in()
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(burning._awaited(), 0.001)
        return burning

    burning = asyncio.run(program())
    assert burning.state is State.RUNNING
    servant.finish.set()
    burning.result()


def test_dropping_a_running_command_unobserved_warns_once(
    held: Lamp, servant: PlainLamp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gecos.command._warned", set())
    with pytest.warns(gecos.UnobservedCommandWarning, match="burn_in: dropped while it was"):
        held.burn_in()
        gc.collect()
    with warnings.catch_warnings(record=True) as more:
        warnings.simplefilter("always")
        held.burn_in()
        gc.collect()
    assert more == []
    servant.finish.set()


def test_a_command_that_failed_and_was_never_asked_warns_at_the_line_that_dropped_it(
    lamp: Lamp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gecos.command._warned", set())
    command = lamp.dim(1.0)
    gecos.ping(lamp).result()  # so the refusal has come
    with pytest.warns(gecos.UnobservedCommandWarning) as warned:
        del command
    assert str(warned[0].message).startswith(
        "LAMP.dim failed, and nobody observed the failure: DENIED: 'dim' of LAMP needs actor status"
    )
    assert warned[0].filename == __file__


def test_a_command_that_fails_after_it_was_dropped_is_told_in_the_log(
    lamp: Lamp, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("gecos.command._warned", {"dim"})  # it has been warned of
    lamp.dim(1.0).detach()
    lamp.dim(1.0)
    gecos.ping(lamp).result()
    lamp.dim(1.0)
    gecos.ping(lamp).result()
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert said.startswith(
        "gecos warning command: LAMP.dim failed, and nobody observed the failure: COMMAND_"
    )
    assert ". Keep the command and wait() for it, or detach() it; later failures" in said


@pytest.mark.parametrize("observe", ["state", "cancel", "detach", "wait"])
def test_a_command_that_was_looked_at_may_be_dropped(
    held: Lamp, servant: PlainLamp, observe: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gecos.command._warned", set())
    command = held.burn_in()
    servant.burning.wait()
    if observe == "state":
        assert command.state is State.RUNNING
    elif observe == "wait":
        command.wait(0.0)
    else:
        getattr(command, observe)()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        del command
        gc.collect()
    servant.finish.set()


def python_run_by(drop: Callable[[], object]) -> list[str]:
    """The functions of Python that run within it."""
    functions: list[str] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            functions.append(frame.f_code.co_name)

    sys.setprofile(note)
    try:
        drop()
    finally:
        sys.setprofile(None)
    return functions


def test_dropping_what_was_looked_at_runs_no_python_in_which_ctrl_c_would_be_lost(
    held: Lamp, servant: PlainLamp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gecos.command._warned", set())
    kept = [held.label(), held.burn_in()]
    kept[0].result()
    kept[1].detach()
    assert python_run_by(kept.clear) == []
    kept = [held.burn_in()]
    with pytest.warns(gecos.UnobservedCommandWarning):
        assert python_run_by(kept.clear)[0] == "__del__"
    kept = [held.burn_in()]  # it has been warned of
    assert python_run_by(kept.clear) == []
    servant.finish.set()


def test_looking_at_a_command_leaves_it_a_command(held: Lamp) -> None:
    label = held.label()
    assert isinstance(label, gecos.Command)
    label.result()
    assert type(label) is gecos.Command


def test_a_dropped_command_still_runs(held: Lamp, servant: PlainLamp) -> None:
    held.dim(2.0).detach()
    held.dim(1.0).result()
    assert servant.starts == ["dim", "dim"]


def test_calls_after_the_lab_is_closed_did_not_start(lab: gecos.Lab, server: gecos.Server) -> None:
    with gecos.Lab() as other:
        lamp = other.create(Lamp, "LAMP")
    with pytest.raises(gecos.ConnectionFailed) as caught:
        lamp.label().result()
    assert caught.value.detail.state is State.CONNECTION_FAILED


def test_calls_after_the_server_closed_did_not_start(lamp: Lamp, server: gecos.Server) -> None:
    lamp.label().result()
    server.close()
    with pytest.raises(gecos.ConnectionFailed):
        lamp.label().result()


def test_closing_the_server_ends_what_runs(
    held: Lamp, server: gecos.Server, servant: PlainLamp
) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    server.close()
    assert burning.wait() is State.COMMAND_FAILED
    assert servant.interrupted.is_set()


def test_a_deadline_that_passes_ends_the_command(held: Lamp, servant: PlainLamp) -> None:
    burning = gecos.with_deadline(held, 0.05).burn_in()
    assert burning.wait() is State.COMMAND_FAILED
    assert burning.progress().detail in (Detail.TIMED_OUT, Detail.EXPIRED)


@pytest.mark.parametrize("seconds", [0.0, -0.5, -1e12])
def test_a_deadline_that_has_passed_sends_nothing(
    held: Lamp, servant: PlainLamp, seconds: float
) -> None:
    late = gecos.with_deadline(held, seconds)
    with pytest.raises(
        gecos.CommandFailed,
        match="the deadline of 'burn_in' passed before the call was sent; the call was not carried",
    ) as caught:
        late.burn_in().result()
    assert caught.value.detail is Detail.EXPIRED
    with pytest.raises(gecos.CommandFailed, match="the deadline of 'label' passed"):
        late.label().result()
    held.dim(1.0).result()
    assert servant.starts == ["dim"]


def test_the_shortest_deadline_is_one(held: Lamp) -> None:
    assert gecos.with_deadline(held, 1e-12).burn_in().wait() is State.COMMAND_FAILED


@pytest.mark.parametrize("seconds", [float("nan"), float("inf"), float("-inf")])
def test_a_deadline_that_is_no_time_is_refused(lamp: Lamp, seconds: float) -> None:
    with pytest.raises(ValueError, match=f"a finite number of seconds, not {seconds}; for calls"):
        gecos.with_deadline(lamp, seconds)


def test_the_detail_projects_onto_one_of_four_states() -> None:
    assert {detail.state for detail in Detail} == set(State)
    assert Detail.UNREACHABLE.state is State.RUNNING
    assert Detail.DONE.state is State.FINISHED
    assert Detail.OUTCOME_UNKNOWN.state is State.COMMAND_FAILED
    assert Detail.NOT_STARTED.state is State.CONNECTION_FAILED


def test_details_have_the_numbers_of_the_runtime() -> None:
    from gecos import _core

    assert [_core.detail_name(detail) for detail in Detail] == [detail.name for detail in Detail]
    assert _core.detail_name(len(Detail)) == ""


def test_a_callback_may_issue_any_number_of_commands_with_callbacks(lamp: Lamp) -> None:
    labels: list[gecos.Command[str]] = []
    told: queue.Queue[str] = queue.Queue()

    def many(_: gecos.Command[str]) -> None:
        for _ in range(1000):  # more than a socket's buffer holds bells of
            labels.append(lamp.label())
            labels[-1].add_done_callback(lambda _: told.put("over"))
            labels[-1].wait(30)

    lamp.label().add_done_callback(many)
    for _ in range(1000):
        assert told.get(timeout=30) == "over"


@pytest.mark.parametrize("interrupted", ["socket.socketpair", "os.dup", "threading.Thread"])
def test_a_callback_may_be_added_in_the_midst_of_adding_the_first_as_by_a_signal_handler(
    held: Lamp, servant: PlainLamp, monkeypatch: pytest.MonkeyPatch, interrupted: str
) -> None:
    monkeypatch.setattr("gecos.callbacks._watches", {})
    told: queue.Queue[str] = queue.Queue()
    burning = held.burn_in()
    adding = threading.Thread(
        target=burning.add_done_callback, args=[lambda _: told.put("outer")], daemon=True
    )
    place = f"gecos.callbacks.{interrupted}"
    original = pydoc.locate(interrupted)
    assert callable(original)

    def interruption(*arguments: object, **named: object) -> object:
        monkeypatch.setattr(place, original)
        burning.add_done_callback(lambda _: told.put("inner"))
        return original(*arguments, **named)

    monkeypatch.setattr(place, interruption)
    adding.start()
    adding.join(10)
    servant.finish.set()
    assert {told.get(timeout=10), told.get(timeout=10)} == {"inner", "outer"}


def test_callbacks_added_by_many_threads_at_once_are_all_called_on_one(
    held: Lamp, servant: PlainLamp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gecos.callbacks._watches", {})
    told: queue.Queue[int] = queue.Queue()
    burning = held.burn_in()
    all_here = threading.Barrier(16)

    def add() -> None:
        all_here.wait(30)
        burning.add_done_callback(lambda _: told.put(threading.get_ident()))

    threads = [threading.Thread(target=add) for _ in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    servant.finish.set()
    assert len({told.get(timeout=10) for _ in threads}) == 1


def test_a_callback_is_told_of_the_end(held: Lamp, servant: PlainLamp) -> None:
    told: queue.Queue[State] = queue.Queue()
    held.burn_in().add_done_callback(lambda command: told.put(command.state))
    servant.burning.wait()
    assert told.empty()
    servant.finish.set()
    assert told.get() is State.FINISHED


def test_a_callback_of_what_has_ended_is_called_at_once(held: Lamp) -> None:
    where: list[threading.Thread] = []
    label = held.label()
    label.wait()
    label.add_done_callback(lambda _: where.append(threading.current_thread()))
    assert where == [threading.current_thread()]


def test_a_callback_may_wait_for_other_commands(held: Lamp, servant: PlainLamp) -> None:
    told: queue.Queue[str] = queue.Queue()
    held.burn_in().add_done_callback(lambda _: told.put(held.label().result()))
    servant.finish.set()
    assert told.get() == "a lamp"


def test_a_callback_that_fails_does_not_stop_the_next(held: Lamp, servant: PlainLamp) -> None:
    told: queue.Queue[int] = queue.Queue()
    burning = held.burn_in()
    burning.add_done_callback(lambda _: 1 / 0)
    burning.add_done_callback(lambda _: told.put(1))
    servant.finish.set()
    assert told.get() == 1


@pytest.mark.parametrize(
    ("raised", "said"),
    [(SystemExit("enough"), "SystemExit: enough"), (ValueError("\ud800"), r"ValueError: \ud800")],
)
def test_whatever_a_callback_raises_is_logged_and_stops_no_other(
    held: Lamp,
    servant: PlainLamp,
    capfd: pytest.CaptureFixture[str],
    raised: BaseException,
    said: str,
) -> None:
    called = threading.Event()

    def fail(_: object) -> None:
        called.set()
        raise raised

    held.burn_in().add_done_callback(fail)
    servant.finish.set()
    called.wait()
    servant.finish.clear()
    told: queue.Queue[int] = queue.Queue()
    held.burn_in().add_done_callback(lambda _: told.put(1))
    servant.finish.set()
    assert told.get(timeout=10) == 1
    assert f"gecos error command: {said}" in capfd.readouterr().err.splitlines()


def test_a_command_can_be_selected_on(held: Lamp, servant: PlainLamp) -> None:
    burning = held.burn_in()
    assert select.select([burning], [], [], 0) == ([], [], [])
    servant.finish.set()
    assert select.select([burning], [], [], 10) == ([burning], [], [])
    assert burning.state is State.FINISHED


WITHOUT_DESCRIPTORS = """
import os, resource, threading, gecos
from lamp import Lamp
lamp = gecos.Lab().create(Lamp, "LAMP", medium="shm")
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.fileno()
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
taken = []
try:
    while True: taken.append(os.open("/dev/null", os.O_RDONLY))
except OSError:
    pass
for _ in range({left}): os.close(taken.pop())
first, later = threading.Event(), threading.Event()
try:
    burning.add_done_callback(lambda _: first.set())
except OSError as error:
    print(error.strerror, flush=True)
    first.set()
for each in taken: os.close(each)
burning.add_done_callback(lambda _: later.set())
burning.cancel()
print(first.wait(30), later.wait(30), flush=True)
"""


@pytest.mark.usefixtures("server")
@pytest.mark.parametrize("left", range(4))
def test_a_callback_that_finds_no_descriptor_says_so_and_later_ones_are_called(left: int) -> None:
    with running(WITHOUT_DESCRIPTORS.format(left=left)) as client:
        out, err = client.communicate(timeout=90)
        assert (out, err) == ("Too many open files\nTrue True\n", "")


@pytest.mark.usefixtures("server")
def test_a_callback_needs_four_descriptors() -> None:
    with running(WITHOUT_DESCRIPTORS.format(left=4)) as client:
        out, err = client.communicate(timeout=90)
        assert (out, err) == ("True True\n", "")
