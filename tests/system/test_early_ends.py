"""The broker and the mocks in C++ end in order however early a signal comes, and say why when a
thread cannot be started."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable

import gecos
import pytest
from gecos_idl.broker import Broker
from processes import PATIENCE_S, Laboratory, Program, until

MOCK = "tests/cpp/mocks/mock_laser"
BROKER = "runtime/cpp/gecos/broker/gecos-broker"


def full_pipe() -> tuple[int, int]:
    """A pipe into which nothing more can be written: a program stops where it prints."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    try:
        while os.write(writing, b"." * 4096):
            pass
    except BlockingIOError:
        pass
    os.set_blocking(writing, True)
    return reading, writing


def ends_on_a_signal_before_its_line(
    lab: Laboratory, program: str, reachable: Callable[[], bool]
) -> None:
    reading, writing = full_pipe()
    started = subprocess.Popen([lab.build / program], stdout=writing, env=lab.env)
    os.close(writing)
    try:
        until(reachable, f"{program} is reachable")
        started.send_signal(signal.SIGTERM)
        while os.read(reading, 65536):  # to its end: the program has closed the pipe
            pass
        assert started.wait(PATIENCE_S) == 0
    finally:
        started.kill()
        started.wait()
        os.close(reading)


def test_a_mock_ends_in_order_on_a_signal_before_it_says_that_it_serves(
    lab_with_broker: Laboratory, here: None
) -> None:
    with gecos.Lab() as client:
        broker = client.broker(Broker)

        def is_listed() -> bool:
            return "LASER_DISTANCE_SENSOR" in [each.name for each in broker.list().result()]

        ends_on_a_signal_before_its_line(lab_with_broker, MOCK, is_listed)
        assert not is_listed(), "it says goodbye to the broker"


def test_a_broker_ends_in_order_on_a_signal_before_it_says_that_it_is_ready(
    lab: Laboratory, here: None
) -> None:
    def answers() -> bool:
        with gecos.Lab() as client:
            try:
                client.broker(Broker, patience=0.0)
            except gecos.CreateError:
                return False
            return True

    ends_on_a_signal_before_its_line(lab, BROKER, answers)


@pytest.mark.parametrize(("program", "thread"), [(MOCK, "publishing"), (BROKER, "gecos-others")])
def test_a_program_that_cannot_start_a_thread_says_which(
    program: str, thread: str, request: pytest.FixtureRequest
) -> None:
    lab = request.getfixturevalue("lab_with_broker" if program == MOCK else "lab")
    lab.env["LD_PRELOAD"] = str(lab.build / "tests/cpp/mocks/libno_more_threads.so")
    texts = []
    for left in range(40):
        lab.env["THREADS_LEFT"] = str(left)
        started = lab.start(lab.build / program)
        if is_ready(started):
            assert started.terminate() == 0
            break
        assert started.finish() == 1, started
        texts.append(started.output())
    else:
        pytest.fail("40 threads do not suffice")
    assert texts, "no thread failed"
    assert f"the thread {thread} (see `ulimit -u`)" in texts[-1]


def is_ready(started: Program) -> bool:
    """Whether the program says that it serves; False when it ends before."""
    try:
        started.wait_for(
            "broker: ready" if started.command[0].endswith("gecos-broker") else "serving"
        )
    except AssertionError:
        return False
    return True
