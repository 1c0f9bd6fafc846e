"""Inward streams in Python: what generated and dynamic clients send, and what the command line
says."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import Queue
from typing import Any

import gecos
import pytest
from command_output import Run

TREE = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def feeder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The generated module of feeder.gidl."""
    out = tmp_path_factory.mktemp("feeder")
    root = TREE / "tests" / "idl" / "inward"
    words = ["--lang", "python", "-I", root, "--out", out, root / "feeder.gidl"]
    subprocess.run(
        [sys.executable, "-m", "gidl", "gen", *words], check=True, stdout=subprocess.DEVNULL
    )
    with pytest.MonkeyPatch.context() as path:
        path.syspath_prepend(str(out / "python"))
        path.syspath_prepend(str(TREE / "tests" / "system" / "inward"))
        import feeder

        yield feeder


@pytest.fixture
def servant(feeder: Any) -> Any:
    from server import PlainFollower  # type: ignore[import-not-found, unused-ignore]

    return PlainFollower()


@pytest.fixture
def served(lab: gecos.Lab, servant: Any) -> Iterator[gecos.Server]:
    with gecos.Server(lab) as server:
        server.add("DANCER", servant, simulated=True)
        yield server


@pytest.fixture
def dancer(lab: gecos.Lab, served: gecos.Server, feeder: Any) -> Any:
    return lab.create(feeder.Dancer, "DANCER")


def settles(holds: Callable[[], bool]) -> bool:
    end = time.monotonic() + 10
    while not holds():
        if time.monotonic() >= end:
            return False
    return True


def test_a_servant_that_is_not_served_has_no_samples(servant: Any) -> None:
    assert servant.speed.next() is None
    assert servant.speed.newest() is None
    assert servant.speed.expired
    assert not servant.remark.expired, "it has no watchdog"
    with pytest.raises(gecos.ServeError, match=r"feeding::Dancer\.speed: no samples come"):
        servant.speed.report()


def test_a_sample_says_who_sent_it_and_how_old_it_is(dancer: Any, servant: Any) -> None:
    with gecos.actor(dancer):
        speed = dancer.speed.writer()
        speed.send(0.5)
        speed.send(1.5, stamp=time.time() - 3)
        first = servant.speed.next()
        second = servant.speed.next()
    assert (first.value, first.sequence, first.command) == (0.5, 1, 0)
    assert 0 <= first.age < 3
    assert 2.9 < second.age < 13
    assert abs(second.stamp - time.time()) < 13
    assert first.session == second.session != 0
    assert servant.speed.next() is None


def test_a_stream_that_is_called_says_how_to_write_it(dancer: Any) -> None:
    with pytest.raises(
        TypeError, match=r"speed is an inward stream; open it with `\.speed\.writer"
    ):
        dancer.speed(0.5)
    assert repr(dancer.speed) == f"<inward stream speed of {dancer!r}>"


def test_the_first_array_is_encoded_without_an_import() -> None:
    text = (
        "import sys\n"
        "from types import SimpleNamespace as Fake\n"
        "from gecos.writer import InwardAttribute\n"
        "assert 'numpy' not in sys.modules\n"
        "session = Fake(object_name='A', open_writer=lambda code: None)\n"
        "stream = Fake(code=1, name='speed')\n"
        "InwardAttribute(Fake(_gecos_session=session), Fake(stream=stream)).writer()\n"
        "assert 'numpy' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_newest_sample_passes_over_older_ones(dancer: Any, servant: Any) -> None:
    with gecos.actor(dancer), dancer.speed.writer() as speed:
        for value in (0.5, 1.0, 1.5):
            speed.send(value)
        newest = servant.speed.newest()
    assert (newest.value, newest.sequence) == (1.5, 3)
    assert servant.speed.report().admitted == 3
    assert not servant.speed.expired
    assert speed.lost, "it is closed"
    with pytest.raises(gecos.ConnectionFailed, match="the writer is closed"):
        speed.send(1.0)


def test_a_command_that_was_canceled_takes_no_more_samples(
    lab: gecos.Lab, served: gecos.Server, feeder: Any, servant: Any
) -> None:
    del served
    stopped = threading.Event()
    seen = threading.Event()
    after: Queue[Any] = Queue()

    def follow(run: gecos.Execution[Any]) -> float:
        with servant.alter.feeds(run):
            run.progress(0, feeder.Step())
            while not run.wait_interrupted(1):
                pass
            stopped.set()
            assert seen.wait(10), "the sample was sent"
            after.put(servant.alter.next())
        return 0.0

    servant.follow = follow
    dancer = lab.create(feeder.Dancer, "DANCER")
    with gecos.actor(dancer), dancer.alter.writer() as alter:
        run = dancer.follow()
        assert settles(lambda: run.feedback() is not None)
        alter.feeds(run)
        alter.send(feeder.Step(x=0.01, count=1))
        run.cancel()
        assert stopped.wait(10), "the handler was interrupted"
        seen.set()
        assert after.get(timeout=10) is None
    assert settles(lambda: servant.alter.report().command_not_running == 1)


def test_samples_that_do_not_decode_keep_no_reader_for_long(
    dancer: Any, servant: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Flooded:
        refused = 0

        def next_inward(self, code: int, only_commands: bool) -> tuple[Any, ...]:
            return b"", 1, 0, 0, 1, 0

        def unreadable(self, code: int, session: int, why: str) -> None:
            self.refused += 1

    del dancer
    flood = Flooded()
    monkeypatch.setattr(servant, "_gecos_core", flood)
    assert servant.speed.next() is None
    assert 100 < flood.refused < 10_000
    assert servant.speed.newest() is None


def test_a_sample_outside_its_range_or_type_is_not_sent(
    dancer: Any, feeder: Any, servant: Any
) -> None:
    with gecos.actor(dancer):
        speed, alter = dancer.speed.writer(), dancer.alter.writer()
        for wrong in (2.5, -0.1, float("nan")):
            with pytest.raises(ValueError, match=r"speed: .* is outside"):
                speed.send(wrong)
        with pytest.raises((TypeError, ValueError), match="speed"):
            speed.send("fast")
        with pytest.raises(ValueError, match=r"x: 0\.5 is outside"):
            alter.send(feeder.Step(x=0.5, count=1))
        assert speed.report().result().admitted == 0
    assert servant.speed.report().admitted == 0


def test_without_a_lease_nothing_is_sent(dancer: Any) -> None:
    speed = dancer.speed.writer()
    with pytest.raises(
        gecos.CommandFailed,
        match="the stream needs actor status; hold a lease while you send: "
        r"call actor\(object\) of gecos$",
    ) as refused:
        speed.send(1.0)
    assert refused.value.detail is gecos.Detail.DENIED


def test_a_servant_that_wants_commands_refuses_free_samples(dancer: Any, servant: Any) -> None:
    servant.speed.need_command()
    with gecos.actor(dancer):
        speed = dancer.speed.writer()
        speed.send(1.0)
        assert servant.speed.next() is None
        report = speed.report().result()
    assert report.command_not_running == 1
    assert report.last_refusal == "its command does not run"


def test_a_sample_for_a_command_that_was_never_sent_is_refused(dancer: Any, feeder: Any) -> None:
    with gecos.actor(dancer):
        alter = dancer.alter.writer()
        late = gecos.with_deadline(dancer, 0).follow()
        assert late.progress().detail is gecos.Detail.EXPIRED
        alter.feeds(late)
        with pytest.raises(
            gecos.CommandFailed, match="the command that the sample feeds was not sent"
        ):
            alter.send(feeder.Step(x=0.0, count=0))
        alter.feeds(None)
        alter.send(feeder.Step(x=0.0, count=0))
        with pytest.raises(TypeError, match=r"feeds takes the command .*, or None, not 3$"):
            alter.feeds(3)


def test_a_dynamic_client_sends_plain_data(
    lab: gecos.Lab, served: gecos.Server, servant: Any
) -> None:
    dancer: Any = lab.dynamic("DANCER")
    with gecos.actor(dancer):
        alter, speed = dancer.alter.writer(), dancer.speed.writer()
        alter.send({"x": 0.05, "count": 3})
        assert servant.alter.next().value.count == 3
        with pytest.raises(ValueError, match=r"alter.*x.*outside"):
            alter.send({"x": 0.5, "count": 3})
        speed.send(1.25)
        assert servant.speed.next().value == 1.25
    remark = dancer.remark.writer()
    remark.send({"text": "plain"})
    assert servant.remark.next().value.text == "plain"
    assert remark.report().result().admitted == 1


def test_describe_shows_inward_streams_and_the_others_refuse_them(
    served: gecos.Server, run: Run
) -> None:
    code, out, _ = run("describe", "DANCER")
    assert code == 0
    assert "(stream in at 250 Hz, watchdog 20000 ms, send: actor, depth 8)" in out
    assert "(stream in, send: sensor)" in out
    for words in (("get", "DANCER", "alter"), ("watch", "DANCER", "alter")):
        code, _, err = run(*words)
        assert code != 0
        assert "DANCER.alter is an inward stream" in err
        assert "robot.alter.writer()" in err


def test_a_writer_outlives_its_lab_as_lost(
    lab: gecos.Lab, served: gecos.Server, feeder: Any
) -> None:
    with gecos.Lab() as mine:
        remark = mine.create(feeder.Dancer, "DANCER").remark.writer()
        remark.send(feeder.Remark(text="heard"))
        assert not remark.lost
    assert settles(lambda: remark.lost)
    with pytest.raises(gecos.ConnectionFailed):
        remark.send(feeder.Remark(text="unheard"))
    assert repr(remark) == "<Writer DANCER.remark: lost>"


def test_a_stream_that_is_not_open_says_how_to_open_it(dancer: Any) -> None:
    why = r"speed is an inward stream; open it first with `\.speed\.writer\(\)`; the attribute"
    with pytest.raises(AttributeError, match=why):
        dancer.speed.send(0.5)


def test_a_stamp_in_ms_is_refused(dancer: Any, servant: Any) -> None:
    with gecos.actor(dancer), dancer.speed.writer() as speed:
        with pytest.raises(ValueError, match="in s of Unix time"):
            speed.send(0.5, stamp=time.time() * 1000)
        assert servant.speed.next() is None
