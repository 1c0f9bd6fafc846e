from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NoReturn

import gecos
import pytest
from gecos import Detail, State
from lamp import Heater, Lamp, PlainLamp


def test_closing_a_server_again_leaves_what_another_serves_since(lab: gecos.Lab) -> None:
    lamp = PlainLamp()
    with gecos.Server(lab) as first, gecos.Server(lab) as second:
        first.add("LAMP", lamp)
        first.close()
        second.add("LAMP2", lamp)
        first.close()
        lamp.publish_level(1.0)
        with pytest.raises(gecos.ServeError, match="is served already under another name"):
            second.add("LAMP3", lamp)


def test_a_servant_whose_handler_closed_its_server_can_be_served_by_another(
    lab: gecos.Lab,
) -> None:
    lamp, server = PlainLamp(), gecos.Server(lab)
    server.add("LAMP", lamp)
    closed = threading.Event()
    lamp.before_label = lambda: (server.close(), closed.set())
    lab.create(Lamp, "LAMP").label().wait()
    assert closed.wait(30.0)
    with pytest.raises(gecos.ServeError, match="cannot publish while it is not served"):
        lamp.publish_level(1.0)
    server.close()
    with gecos.Server(lab) as second:
        second.add("LAMP2", lamp)


def test_an_insecure_server_serves_simulated_objects_alone_and_says_so(
    lab: gecos.Lab, capfd: pytest.CaptureFixture[str]
) -> None:
    with gecos.Server(lab, insecure=True) as server:
        lamp = PlainLamp()
        with pytest.raises(gecos.ServeError, match="LAMP does not declare itself simulated"):
            server.add("LAMP", lamp)
        assert "--insecure" not in capfd.readouterr().err
        server.add("LAMP", lamp, simulated=True)
        told = gecos.describe(lab.create(Lamp, "LAMP")).result()
        assert told.authentication.endswith("--insecure: every user of every host may connect")
    assert "* --insecure: LAMP admits every user of every host." in capfd.readouterr().err


def test_an_add_that_ctrl_c_breaks_off_can_be_repeated(
    server: gecos.Server, lab: gecos.Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    second = PlainLamp()
    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", interrupted)
        with pytest.raises(KeyboardInterrupt):
            server.add("LAMP2", second)
    server.add("LAMP2", second)
    assert lab.create(Lamp, "LAMP2").label().result() == "a lamp"


def interrupted(thread: threading.Thread) -> NoReturn:
    raise KeyboardInterrupt


def test_an_object_without_its_threads_is_not_served_and_leaves_none(
    server: gecos.Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = set(threading.enumerate())
    start, began = threading.Thread.start, list[threading.Thread]()

    def only_one(thread: threading.Thread) -> None:
        if began:
            raise RuntimeError("can't start new thread")
        began.append(thread)
        start(thread)

    second = PlainLamp()
    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", only_one)
        with pytest.raises(gecos.ServeError) as refused:
            server.add("LAMP2", second)
    assert str(refused.value) == "LAMP2: cannot start its handler threads: can't start new thread"
    began[0].join(30.0)
    assert set(threading.enumerate()) <= before
    server.add("LAMP2", second)


def test_the_first_name_that_is_online_and_of_the_right_type_is_taken(
    lab: gecos.Lab, server: gecos.Server
) -> None:
    assert repr(lab.create(Lamp, ["TORCH", "LAMP"])).startswith("<test::Lamp 'LAMP' over ")


def test_create_gives_a_reason_for_each_name(lab: gecos.Lab, server: gecos.Server) -> None:
    with pytest.raises(gecos.CreateError) as caught:
        lab.create(Heater, ["TORCH", "LAMP"])
    torch, lamp = caught.value.attempts
    assert (torch.name, torch.detail) == ("TORCH", Detail.NO_SERVER)
    assert (lamp.name, lamp.detail) == ("LAMP", Detail.REFUSED)
    assert "test::Lamp" in lamp.reason
    assert "test::Heater" in lamp.reason


def test_without_a_broker_create_says_what_was_tried(place: Path) -> None:
    with gecos.Lab() as alone, pytest.raises(gecos.CreateError) as caught:
        alone.create(Lamp, "LAMP", patience=0.2)
    assert str(caught.value) == (
        "LAMP: NO_SERVER: no broker answers; start `gecos up` (a laboratory on this machine) or "
        "`gecos broker`, or give the broker's address in GECOS_BROKER or below [broker] in the lab "
        "file "
        f"(tried shm:{place}/BROKER.sock: no server listens at this address (only servers of uid "
        f"{os.getuid()} are in the directory of this address; use GECOS_BROKER=lcm to reach "
        "programs of other users))"
    )


def test_a_lab_says_where_its_broker_is_sought(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with gecos.Lab() as by_default, gecos.Lab("lcm") as named:
        assert repr(by_default) == "<Lab: open, broker of the lab file, else of this host>"
        assert repr(named) == "<Lab: open, broker lcm>"
    monkeypatch.setenv("GECOS_BROKER", "shm")
    with gecos.Lab() as by_variable:
        assert repr(by_variable) == "<Lab: open, broker shm>"


def test_create_says_what_its_first_parameter_is(lab: gecos.Lab, server: gecos.Server) -> None:
    with pytest.raises(TypeError, match=r"the class that gidl generated.*not 'LAMP'"):
        lab.create("LAMP", "LAMP")  # type: ignore[type-var]
    with pytest.raises(TypeError, match="not the class PlainLamp"):
        lab.create(PlainLamp, "LAMP")  # type: ignore[type-var]
    with pytest.raises(TypeError, match="not None"):
        lab.broker(None)  # type: ignore[type-var]


def test_a_proxy_of_a_closed_lab_says_so(server: gecos.Server) -> None:
    with gecos.Lab() as closed:
        lamp = closed.create(Lamp, "LAMP")
    why = "'label' of LAMP was called on a proxy whose Lab is closed"
    with pytest.raises(gecos.ConnectionFailed, match=why) as caught:
        lamp.label().result()
    assert caught.value.detail is Detail.NO_SERVER
    with pytest.raises(gecos.ConnectionFailed, match="a proxy whose Lab is closed"):
        lamp.level.stream()
    assert repr(lamp) == "<test::Lamp 'LAMP' over inproc>"
    with pytest.raises(ValueError, match="this Lab is closed"):
        closed.create(Lamp, "LAMP")


def test_a_second_broker_is_refused(lab: gecos.Lab) -> None:
    with gecos.Lab() as other, pytest.raises(gecos.ServeError, match="already in this process"):
        gecos.Broker(other)


def test_a_second_broker_is_told_where_the_first_is_and_what_to_do(
    lab: gecos.Lab, place: Path
) -> None:
    second = subprocess.run(
        [sys.executable, "-m", "gecos.cli", "broker"],
        env={"PYTHONPATH": ":".join(filter(None, sys.path)), "GECOS_RUNTIME_DIR": str(place)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert second.returncode == 1
    assert f"{place}/BROKER.sock is served already by uid {os.getuid()}, pid {os.getpid()};" in (
        second.stderr
    )
    pid = os.getpid()
    assert f"end it first (kill {pid}; if it is suspended, kill -CONT {pid}" in second.stderr


def test_a_name_that_is_taken_is_refused(server: gecos.Server) -> None:
    with (
        gecos.Lab() as other,
        gecos.Server(other) as second,
        pytest.raises(gecos.ServeError, match=r"^LAMP is not served: the name LAMP is taken by"),
    ):
        second.add("LAMP", PlainLamp())


def test_an_object_that_was_refused_can_be_added_under_another_name(
    lab: gecos.Lab, server: gecos.Server
) -> None:
    with gecos.Lab() as other, gecos.Server(other) as second:
        with pytest.raises(gecos.ServeError):
            second.add("LAMP", PlainLamp())
        second.add("LAMP2", PlainLamp())
        assert lab.create(Lamp, "LAMP2").label().result() == "a lamp"


class LabelledLamp(PlainLamp):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.text = text

    def label(self) -> str:
        return self.text


def test_an_object_that_could_not_be_added_answers_for_no_other(
    lab: gecos.Lab, server: gecos.Server
) -> None:
    with pytest.raises(ValueError, match="no medium is called 'radio'"):
        server.add("TORCH", LabelledLamp("a torch"), media=["radio"])
    server.add("LANTERN", LabelledLamp("a lantern"), simulated=True)
    assert lab.create(Lamp, "LANTERN").label().result() == "a lantern"


class BrokenOff:
    """An extension's server whose `add` has done its work when Ctrl-C comes."""

    def __init__(self, server: gecos.Server) -> None:
        self._server = server._core

    def add(self, *arguments: Any) -> NoReturn:
        self._server.add(*arguments)
        raise KeyboardInterrupt

    def __getattr__(self, name: str) -> Any:
        return getattr(self._server, name)


def test_what_an_add_that_was_broken_off_serves_answers_for_no_other(
    lab: gecos.Lab, server: gecos.Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(server, "_core", BrokenOff(server))
        with pytest.raises(KeyboardInterrupt):
            server.add("LEFT", LabelledLamp("left"))
    server.add("RIGHT", LabelledLamp("right"))
    assert lab.create(Lamp, "LEFT").label().result(30) == "left"
    assert lab.create(Lamp, "RIGHT").label().result(30) == "right"


@pytest.mark.parametrize("given", [PlainLamp, Lamp, None])
def test_what_is_no_servant_is_not_served(server: gecos.Server, given: Any) -> None:
    with pytest.raises(TypeError, match=r"^TORCH: the servant must be an object of a class that"):
        server.add("TORCH", given)


def test_serve_says_that_it_belongs_to_the_main_thread() -> None:
    with (
        ThreadPoolExecutor(1) as other,
        pytest.raises(RuntimeError, match="that thread receives signals; in another thread use"),
    ):
        other.submit(gecos.serve, {}).result()


def test_serve_publishes_until_a_signal_ends_it(lab: gecos.Lab) -> None:
    lamp = PlainLamp()
    read: list[float] = []

    def publish(ended: threading.Event) -> None:
        with lab.create(Lamp, "LAMP").level.stream() as levels:
            lamp.publish_level(0.5)
            read.append(levels.next(timeout=30.0).value)
        os.kill(os.getpid(), signal.SIGTERM)
        assert ended.wait(30.0)
        read.append(0.0)

    gecos.serve({"LAMP": lamp}, lab=lab, simulated=True, publish=publish)
    assert read == [0.5, 0.0]


def test_an_exception_of_publish_ends_serve_which_raises_it(lab: gecos.Lab) -> None:
    def publish(ended: threading.Event) -> None:
        raise OSError("the thermometer does not answer")

    with pytest.raises(OSError, match="the thermometer does not answer"):
        gecos.serve({"LAMP": PlainLamp()}, lab=lab, simulated=True, publish=publish)


def test_an_object_of_this_process_is_reached_without_leaving_it(lamp: Lamp) -> None:
    assert repr(lamp) == "<test::Lamp 'LAMP' over inproc>"


@pytest.mark.parametrize("medium", ["inproc", "shm", "lcm"])
def test_the_named_medium_is_used(lab: gecos.Lab, server: gecos.Server, medium: str) -> None:
    lamp = lab.create(Lamp, "LAMP", medium=medium)
    assert repr(lamp).endswith(f"over {medium}>")
    assert lamp.label().result() == "a lamp"


def test_a_medium_that_the_server_does_not_offer_is_refused(
    lab: gecos.Lab, server: gecos.Server
) -> None:
    server.add("SHY", PlainLamp(), media=["shm"])
    with pytest.raises(gecos.CreateError, match="lcm"):
        lab.create(Lamp, "SHY", medium="lcm")


def test_an_unknown_medium_is_named(lab: gecos.Lab, server: gecos.Server) -> None:
    with pytest.raises(ValueError, match="no medium is called 'pigeon'"):
        lab.create(Lamp, "LAMP", medium="pigeon")
    with pytest.raises(ValueError, match="no medium is called 'pigeon'"):
        server.add("LAMP3", PlainLamp(), media=["pigeon"])


def test_a_call_that_waits_for_its_handler_when_the_server_closes_was_not_started(
    lamp: Lamp, server: gecos.Server, servant: PlainLamp
) -> None:
    begun, go_on = threading.Event(), threading.Event()
    servant.before_label = lambda: (begun.set(), go_on.wait(30))
    running, waiting = lamp.label(), lamp.label()
    assert begun.wait(30)
    gecos.ping(lamp).result(30)  # so both have arrived
    closing = threading.Thread(target=server.close)
    closing.start()
    with pytest.raises(gecos.CommandFailed, match="the server is about to end") as caught:
        waiting.result(30)
    assert caught.value.detail is Detail.REJECTED
    go_on.set()
    closing.join(30)
    assert running.wait(30) is not State.RUNNING


def test_one_that_was_refused_may_be_served_by_another_server(
    lab: gecos.Lab, server: gecos.Server
) -> None:
    lamp = PlainLamp()
    with pytest.raises(gecos.ServeError):
        server.add("LAMP", lamp)
    with gecos.Server(lab) as other:
        other.add("LAMP2", lamp)
        server.close()
        lamp.publish_level(1.0)


def test_one_servant_is_one_object(server: gecos.Server, servant: PlainLamp) -> None:
    with pytest.raises(gecos.ServeError, match="TWIN: this PlainLamp is served already"):
        server.add("TWIN", servant)
    server.close()
    with pytest.raises(gecos.ServeError, match="a closed server serves nothing"):
        servant.publish_level(1.0)


@pytest.mark.parametrize("name", ["", "LA\0MP"])
def test_a_name_that_is_none_is_refused(server: gecos.Server, name: str) -> None:
    with pytest.raises(gecos.ServeError, match="at least one character and must not contain NUL"):
        server.add(name, PlainLamp())


def test_a_server_may_be_closed_twice(server: gecos.Server) -> None:
    server.close()
    server.close()


def test_a_closed_server_takes_no_object(server: gecos.Server) -> None:
    server.close()
    with pytest.raises(gecos.ServeError, match="closed"):
        server.add("LATE", PlainLamp())


def test_many_threads_may_call_through_one_proxy(lamp: Lamp) -> None:
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(8) as pool:
        labels = list(pool.map(lambda _: lamp.label().result(), range(200)))
    assert labels == ["a lamp"] * 200


def test_a_server_waits_for_a_broker_that_is_starting(
    place: object, capfd: pytest.CaptureFixture[str]
) -> None:
    with gecos.Lab() as ours, gecos.Server(ours) as server:
        with pytest.raises(gecos.ServeError, match="no broker answers"):
            server.await_broker(0.0)
        assert not capfd.readouterr().err
        adding = threading.Thread(target=server.add, args=("EARLY", PlainLamp()))
        adding.start()
        told = ""
        while "goes on asking" not in told:
            assert adding.is_alive(), told
            told += capfd.readouterr().err
        assert told.count("no broker answers") == 1
        with gecos.Lab() as theirs, gecos.Broker(theirs):
            adding.join()
            assert theirs.create(Lamp, "EARLY").label().result() == "a lamp"
            server.close()


def test_create_waits_for_an_object_that_comes_online(lab: gecos.Lab, servant: PlainLamp) -> None:
    with ThreadPoolExecutor() as pool, gecos.Server(lab) as server:
        created = pool.submit(lab.create, Lamp, ["TORCH", "LAMP"], wait=300)
        with pytest.raises(TimeoutError):
            created.result(timeout=0.3)
        server.add("LAMP", servant)
        assert created.result().label().result() == "a lamp"


def test_create_waits_no_longer_than_it_is_told(lab: gecos.Lab) -> None:
    with pytest.raises(gecos.CreateError, match="no object is called LAMP"):
        lab.create(Lamp, "LAMP", wait=0.05)


WITH_NO_NAMES: list[Any] = [{"A", "B"}, (name for name in "AB"), None, 5, b"LAMP", ["LAMP", 5]]


@pytest.mark.parametrize("names", WITH_NO_NAMES, ids=lambda names: type(names).__name__)
def test_create_says_what_its_second_parameter_is(lab: gecos.Lab, names: Any) -> None:
    with pytest.raises(TypeError) as refused:
        lab.create(Lamp, names)
    assert str(refused.value) == (
        "the second argument must be the name of an object, a sequence of names, such as "
        f'`["LEFT", "RIGHT"]`, or a reference, not {names!r}'
    )


def test_create_says_that_its_arguments_are_exchanged(lab: gecos.Lab) -> None:
    swapped: Any = ("LAMP", Lamp)
    with pytest.raises(TypeError, match=r"are exchanged.*`lab\.create\(Lamp, 'LAMP'\)`$"):
        lab.create(*swapped)


TAKING_A_PROXY: dict[str, Callable[[Any], object]] = {
    "stop(robot)": gecos.stop,
    "ping(robot)": gecos.ping,
    "describe(robot)": gecos.describe,
    "deny(robot, …)": lambda given: gecos.deny(given, 1),
    "outcome(robot, …)": lambda given: gecos.outcome(given, "1-2-3"),
    "line_state(robot)": gecos.line_state,
    "LineWatch(robot)": gecos.LineWatch,
    "reference(robot)": gecos.reference,
    "with_deadline(robot, …)": lambda given: gecos.with_deadline(given, 1.0),
}


@pytest.mark.parametrize("use", TAKING_A_PROXY)
def test_a_name_in_place_of_a_proxy_is_told_what_to_write(use: str) -> None:
    with pytest.raises(TypeError) as refused:
        TAKING_A_PROXY[use]("LAMP")
    name = use.partition("(")[0]
    assert str(refused.value) == (
        f"gecos.{name} takes a proxy, not 'LAMP': write `robot = gecos.dynamic('LAMP')` and "
        f"`gecos.{use}`"
    )


def test_serve_refuses_to_serve_nothing() -> None:
    with pytest.raises(ValueError, match=r"was given no servant: write gecos\.serve\(\{'NAME'"):
        gecos.serve({})


def test_serve_says_that_it_takes_a_name_for_each_servant() -> None:
    servant: Any = PlainLamp()
    with pytest.raises(TypeError, match=r"by their names: write gecos\.serve\(\{'NAME': servant"):
        gecos.serve(servant)
