"""The command `gecos` with closed streams, with arguments that are no text, with few file
descriptors, and with an output that is read slowly."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import closing
from types import SimpleNamespace
from typing import Any

import gecos
import pytest
from command_output import Run, valid
from gecos.cli import events
from lamp import PlainLamp

MANY = 40  # objects; sessions with all of them at the same time need more than FEW descriptors
FEW = 64


def in_a_shell(words: str, before: str = "") -> tuple[int, str, str]:
    """Runs `gecos` with `words`, which may contain redirections, in a shell."""
    line = f"{before} exec {shlex.quote(sys.executable)} -m gecos.cli {words}"
    ended = subprocess.run(["sh", "-c", line], capture_output=True, text=True, timeout=120)
    return ended.returncode, ended.stdout, ended.stderr


@pytest.fixture
def lamps(lab: gecos.Lab) -> Iterator[list[PlainLamp]]:
    """Lamps that only other processes reach, and only over shm."""
    served = [PlainLamp() for _ in range(MANY)]
    with gecos.Server(lab) as server:
        for number, lamp in enumerate(served):
            server.add(f"LAMP{number:02}", lamp, simulated=True, media=["shm"])
        yield served


def test_a_stop_of_all_needs_few_descriptors(lamps: list[PlainLamp]) -> None:
    code, out, err = in_a_shell("stop --all", f"ulimit -n {FEW};")
    assert (code, err) == (0, "")
    assert out.splitlines() == [f"LAMP{number:02}: stopped" for number in range(MANY)]


def test_a_stop_of_all_without_a_broker_needs_few_descriptors(place: object) -> None:
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        with gecos.Broker(lab):
            for number in range(MANY):
                server.add(f"LAMP{number:02}", PlainLamp(), simulated=True, media=["shm"])
        code, out, err = in_a_shell("stop --all", f"ulimit -n {FEW};")
    assert code == 4, "there may be objects that only a broker knows"
    assert err.startswith("gecos: the broker did not say which other objects are silent: ")
    assert out.splitlines() == [f"LAMP{number:02}: stopped" for number in range(MANY)]


@pytest.mark.parametrize("words", ["schema", "keys --json", "ls", "--version", "call LAMP label"])
def test_nothing_is_done_when_the_output_is_closed(words: str) -> None:
    said = "gecos: standard output is closed; nothing was done\n"
    assert in_a_shell(f"{words} >&-") == (1, "", said)


@pytest.mark.parametrize("words", ["stop LAMP", "stop LAMP --json"])
def test_a_stop_is_carried_out_when_the_output_is_closed(
    server: gecos.Server, held: Any, servant: PlainLamp, words: str
) -> None:
    burning = held.burn_in()
    servant.burning.wait()
    assert in_a_shell(f"{words} >&-") == (0, "", "")
    burning.wait()
    assert burning.progress().detail is gecos.Detail.STOPPED


@pytest.mark.parametrize("words", ["explode", "ls --nonsense", "get NOBODY label"])
def test_no_error_goes_to_the_output_when_the_error_output_is_closed(
    lab: gecos.Lab, words: str
) -> None:
    code, out, _ = in_a_shell(f"{words} 2>&-")
    assert code in (2, 4)
    assert out == ""


@pytest.mark.parametrize(
    "words",
    [
        ("call", "LAMP", "label", "--password", "\udcff"),
        ("ls", "--broker", "\udcff"),
        ("ls", "--interface", "\udcff"),
        ("keys", "add", "file.public", "a@\udcff"),
    ],
)
def test_an_argument_that_is_no_text_is_named(
    server: gecos.Server, run: Run, words: tuple[str, ...]
) -> None:
    named = os.fsencode(words[-1])
    said = f"the argument {named!r} is not UTF-8; give valid UTF-8"
    assert run(*words) == (2, "", f"gecos: {said}\n")
    code, out, err = run(*words, "--json")
    assert (code, err) == (2, "")
    assert valid(out, "failure")
    assert json.loads(out)["error"]["text"] == said


def test_a_password_of_the_environment_that_is_no_text_is_refused(
    monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    monkeypatch.setenv("GECOS_PASSWORD", "\udcff")
    assert run("ls") == (2, "", "gecos: GECOS_PASSWORD is not UTF-8; give valid UTF-8\n")


class FastStream:
    """A stream that has the next event at once, and never an end."""

    def __init__(self) -> None:
        self.read = 0
        self.many_read = threading.Event()
        self._closed = False

    def __iter__(self) -> Iterator[Any]:
        while not self._closed:
            self.read += 1
            if self.read > events._MOST_AHEAD:
                self.many_read.set()
            yield SimpleNamespace(sequence=self.read)

    def close(self) -> None:
        self._closed = True


def test_events_are_not_read_long_before_they_are_printed() -> None:
    stream = FastStream()
    with closing(events._heard({"lit": stream})) as heard:  # type: ignore[dict-item]
        for printed in range(1000):
            _, sample = next(heard)
            assert sample.sequence == printed + 1
            assert stream.many_read.wait(10)
            assert stream.read <= printed + events._MOST_AHEAD + 1
