"""`@qos(deadline=…)` and `@qos(start_by=…)` of an operation, as its interface declares them."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import gecos
import pytest
from gecos import Detail, State
from generated_module import imported

OVEN = """\
#pragma once

module kitchen {
  interface Oven {
    @actor @cancelable @qos(deadline="1s") void bake();
    @actor @cancelable void clean();
    @actor @qos(start_by="1s") void light();
  };
};
"""
PATIENCE_S = 30.0


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The generated module of OVEN."""
    out = tmp_path_factory.mktemp("kitchen")
    source = out / "kitchen.gidl"
    source.write_text(OVEN)
    with imported("kitchen", source, out, out) as module:
        yield module


class Served:
    """What the handlers of the oven do is noted here, and what they wait for."""

    def __init__(self) -> None:
        self.starts: list[str] = []
        self.begun = threading.Event()
        self.finish = threading.Event()
        self.interrupted = threading.Event()

    def run(self, what: str, run: gecos.Execution[None]) -> None:
        """Until it is interrupted or may finish."""
        self.starts.append(what)
        self.begun.set()
        while not self.finish.is_set():
            if run.wait_interrupted(0.005):
                self.interrupted.set()
                raise gecos.Interrupted


@pytest.fixture
def served(lab: gecos.Lab, kitchen: Any) -> Iterator[Served]:
    noted = Served()

    class Oven(kitchen.OvenServant):  # type: ignore[misc]
        def bake(self, run: gecos.Execution[None]) -> None:
            noted.run("bake", run)

        def clean(self, run: gecos.Execution[None]) -> None:
            noted.run("clean", run)

        def light(self) -> None:
            noted.starts.append("light")

    with gecos.Server(lab) as server:
        server.add("OVEN", Oven(), simulated=True)
        yield noted


@pytest.fixture(params=["generated", "dynamic"])
def oven(
    request: pytest.FixtureRequest, lab: gecos.Lab, served: Served, kitchen: Any
) -> Iterator[Any]:
    """A proxy over shm that holds the status."""
    if request.param == "generated":
        proxy = lab.create(kitchen.Oven, "OVEN", medium="shm")
    else:
        proxy = lab.dynamic("OVEN", medium="shm")
    with gecos.actor(proxy):
        yield proxy


def missed(oven: gecos.Object, operation: str) -> tuple[int, int]:
    """Calls of that operation that missed their deadline, and their start_by."""
    counted = gecos.stats(oven).result().operations
    (found,) = (one for one in counted if one.operation == operation)
    return found.deadline_missed, found.start_by_missed


def test_a_call_that_runs_beyond_its_deadline_is_interrupted_and_timed_out(
    oven: Any, served: Served
) -> None:
    baking = oven.bake()
    assert served.begun.wait(PATIENCE_S)
    assert baking.wait(PATIENCE_S) is State.COMMAND_FAILED
    assert str(baking.exception()) == (
        "TIMED_OUT: the deadline of 'bake' passed while the call was executing; its handler was "
        "told to stop: allow the call more time"
    )
    assert served.interrupted.wait(PATIENCE_S)
    assert missed(oven, "bake") == (1, 0)


def test_a_call_without_a_declared_deadline_runs_on(oven: Any, served: Served) -> None:
    cleaning = oven.clean()
    assert served.begun.wait(PATIENCE_S)
    queued = oven.bake()
    assert queued.wait(PATIENCE_S) is State.COMMAND_FAILED  # so its deadline has passed
    assert queued.progress().detail is Detail.EXPIRED
    assert cleaning.state is State.RUNNING
    served.finish.set()
    cleaning.result(PATIENCE_S)
    assert served.starts == ["clean"], "what has expired is not carried out later"
    assert missed(oven, "bake") == (1, 0)


def test_a_call_that_did_not_start_by_its_time_has_expired_and_is_not_carried_out(
    oven: Any, served: Served
) -> None:
    cleaning = oven.clean()
    assert served.begun.wait(PATIENCE_S)
    late = oven.light()
    assert late.wait(PATIENCE_S) is State.COMMAND_FAILED
    assert late.progress().detail is Detail.EXPIRED
    assert str(late.exception()) == (
        "EXPIRED: 'light' did not start within its start_by of 1000 ms; the call was not carried "
        "out"
    )
    served.finish.set()
    cleaning.result(PATIENCE_S)
    oven.light().result(PATIENCE_S)
    assert served.starts == ["clean", "light"], "the second one alone"
    assert missed(oven, "light") == (0, 1)
