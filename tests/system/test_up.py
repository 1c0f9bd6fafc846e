"""`gecos up` starts a laboratory, restarts programs on request, and leaves no process behind."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import threading
import uuid
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from gecos import cli
from gecos.laboratory import (
    LaboratoryDescription,
    LaboratoryError,
    LaboratoryFileError,
    Program,
    read_laboratory,
    running,
)
from gecos.laboratory.events import Event, What
from jsonschema import Draft202012Validator
from processes import PATIENCE_S, Laboratory, await_ends, until
from test_demo import alive_with

GECOS = [sys.executable, "-m", "gecos.cli"]
SCHEMA = json.loads((Path(cli.__file__).parent / "output.schema.json").read_text())


def test_the_simulated_laboratory_in_one_command(lab: Laboratory) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    up = lab.start(*GECOS, "up", "--programs", lab.build)
    up.wait_for("up: WORLD, RX90, GRIPPER, LDS are ready; Ctrl-C ends them")
    moved = lab.run(*GECOS, "call", "GRIPPER", "open", "width=0.04")
    assert moved.finish() == 0, str(moved)
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)
    assert "up: ending" in up.output()
    assert alive_with(marker) == {}


def test_a_program_that_is_killed_starts_again(lab: Laboratory) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    up = lab.start(*GECOS, "up", "--restart", "--programs", lab.build)
    up.wait_for("are ready; Ctrl-C")
    (gripper,) = (pid for pid, words in alive_with(marker).items() if "robcl-gripper" in words)
    os.kill(gripper, signal.SIGKILL)
    up.wait_for("GRIPPER was ended by signal 9; it is started again in 0.5 s")
    up.wait_for("[GRIPPER]")
    asked = lab.run(*GECOS, "wait", "GRIPPER", "--timeout", "20")
    assert asked.finish() == 0, str(asked)
    up.signal(signal.SIGTERM)
    assert up.finish() == 0, str(up)
    assert alive_with(marker) == {}


def test_a_program_that_ends_is_told_of_and_the_others_go_on(
    lab: Laboratory, tmp_path: Path
) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(
        '[programs.SHORT]\nrun = ["sh", "-c", "echo ready; exit 3"]\nready = ""\n'
        '[programs.LONG]\nrun = ["sh", "-c", "echo is $PLACE; exec sleep 1000"]\n'
        'ready = "is here"\nenvironment = { PLACE = "here" }\n'
    )
    up = lab.start(*GECOS, "up", file)
    up.wait_for("SHORT ended with status 3; the other programs continue")
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)


def test_programs_are_given_the_file_if_it_has_tables_for_them(
    lab: Laboratory, tmp_path: Path
) -> None:
    lab.env.pop("GECOS_LAB_FILE", None)
    program = (
        '[programs.SHOW]\nrun = ["sh", "-c", "echo file=$GECOS_LAB_FILE.; exec sleep 1000"]\n'
        'ready = "file"\n'
    )
    file = tmp_path / "lab.toml"
    tables = ("", '[allow]\nusers = ["anna"]\n', "[media.shm]\nreal_time = false\n")
    for table, given in zip(tables, ("", str(file), str(file)), strict=True):
        file.write_text(program + table)
        up = lab.start(*GECOS, "up", file, ready="SHOW is ready; Ctrl-C ends them")
        assert f"[SHOW] file={given}." in up.output()
        up.signal(signal.SIGINT)
        assert up.finish() == 0, str(up)


def test_lists_that_are_added_later_are_told_of_once(lab: Laboratory, tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    program = '[programs.A]\nrun = ["sleep", "1000"]\nready = ""\n'
    file.write_text(program)
    up = lab.start(*GECOS, "up", file, ready="A is ready; Ctrl-C ends them")
    file.write_text(f'{program}[objects.LDS.allow]\nuser = ["anna"]\n')  # with an error
    file.write_text(f'{program}[objects.LDS.allow]\nusers = ["anna"]\n')
    told = f"up: {file} now has [objects]. The running programs do not read the file: "
    up.wait_for(told)
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)
    assert up.output().count(told) == 1


def test_the_pause_before_a_restart_delays_nothing_else(lab: Laboratory, tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(
        '[programs.OTHER]\nrun = ["sh", "-c", "echo pid $$.; exec sleep 1000"]\nready = "pid"\n'
        '[programs.SHORT]\nrun = ["sh", "-c", "exit 3"]\nready = ""\nrestart = true\n'
    )
    up = lab.start(*GECOS, "up", file)
    up.wait_for("SHORT ended with status 3; it is started again in 4 s")
    other = re.search(r"\[OTHER\] pid (\d+)\.", up.output())
    assert other is not None
    os.kill(int(other[1]), signal.SIGKILL)
    up.wait_for("OTHER was ended by signal 9; the other programs continue")
    assert "it is started again in 8 s" not in up.output()
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)


def test_a_program_that_cannot_be_started_again_is_tried_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    module = sys.modules["gecos.laboratory.running"]
    monkeypatch.setattr(module, "_FIRST_PAUSE", 0.01)
    script = tmp_path / "oven"
    script.write_text("#!/bin/sh\nrm -f $0\necho serving OVEN\n")
    script.chmod(0o755)
    program = Program("OVEN", ("./oven",), restart=True)
    laboratory = LaboratoryDescription((program,), starts_broker=False, folder=tmp_path)
    with running(laboratory) as started:
        while "in 0.04 s" not in (said := capsys.readouterr().out):
            started.watch(0.01)
        script.write_text("#!/bin/sh\necho serving the new OVEN\n")
        script.chmod(0o755)
        while "serving the new OVEN" not in said:
            started.watch(0.01)
            said += capsys.readouterr().out


def test_what_a_wrapper_has_started_ends_too(lab: Laboratory, tmp_path: Path) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    (tmp_path / "start.sh").write_text(
        f"{lab.build}/devices/laser_distance_sensor/robcl-lds\nexit 1\n"
    )
    file = tmp_path / "lab.toml"
    file.write_text('[programs.LDS]\nrun = ["sh", "start.sh"]\n')
    up = lab.start(*GECOS, "up", file)
    up.wait_for("up: LDS is ready")
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)
    assert alive_with(marker) == {}


def test_a_second_interrupt_kills_what_does_not_end(lab: Laboratory, tmp_path: Path) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    file = tmp_path / "lab.toml"
    file.write_text(
        "[programs.DEAF]\n"
        'run = ["sh", "-c", "trap \'\' TERM; echo serving X; while :; do sleep 1; done"]\n'
    )
    up = lab.start(*GECOS, "up", file)
    up.wait_for("up: DEAF is ready")
    up.signal(signal.SIGINT)
    up.wait_for("up: ending")
    up.signal(signal.SIGINT)
    assert up.finish() == 130, str(up)
    await_ends(alive_with(marker))
    assert alive_with(marker) == {}


def test_the_thread_that_awaits_the_end_of_a_program_also_sees_that_it_was_killed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    await_end, reap = os.waitid, subprocess.Popen.wait
    reaped = threading.Event()
    failures: list[BaseException | None] = []

    def await_end_late(*arguments: int) -> os.waitid_result | None:
        """Gives the thread that kills the program time to reap it first."""
        with suppress(ChildProcessError):
            await_end(*arguments)
        reaped.wait(0.2)
        return await_end(*arguments)

    def reap_and_tell(process: subprocess.Popen[str], timeout: float | None = None) -> int:
        status = reap(process, timeout)
        reaped.set()
        return status

    monkeypatch.setattr(os, "waitid", await_end_late)
    monkeypatch.setattr(subprocess.Popen, "wait", reap_and_tell)
    monkeypatch.setattr(threading, "excepthook", lambda failed: failures.append(failed.exc_value))
    monkeypatch.setattr(sys.modules["gecos.laboratory.running"], "END_WITHIN", 0.1)
    deaf = "trap '' TERM; echo serving X; while :; do sleep 1; done"
    laboratory = LaboratoryDescription(
        (Program("DEAF", ("sh", "-c", deaf)),), starts_broker=False, folder=tmp_path
    )
    events: list[Event] = []
    before = set(threading.enumerate())
    with running(laboratory, report=events.append):
        pass
    for thread in set(threading.enumerate()) - before:
        thread.join(PATIENCE_S)
    assert What.KILLED in [each.event for each in events]
    assert failures == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_program_is_ended_if_a_signal_comes_while_it_is_started(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, number: signal.Signals
) -> None:
    started: list[subprocess.Popen[str]] = []

    class Interrupted(subprocess.Popen[str]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            started.append(self)
            os.kill(os.getpid(), number)

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    before = signal.signal(number, interrupt)
    laboratory = LaboratoryDescription(
        (Program("SLOW", ("sleep", "1000")),), starts_broker=False, folder=tmp_path
    )
    try:
        with pytest.raises(KeyboardInterrupt), running(laboratory, report=lambda _: None):
            pass
        assert signal.getsignal(number) is interrupt
    finally:
        signal.signal(number, before)
    assert [process.returncode for process in started] == [-signal.SIGTERM]


ORDERLY = """
trap 'echo braking; read word <go; echo stands; touch stands; exit 0' TERM
echo serving X
while :; do sleep 1; done
"""
"""A program that needs time to end: after SIGTERM it waits for a word from the test."""


@pytest.mark.parametrize("later", [signal.SIGHUP, signal.SIGTERM])
@pytest.mark.parametrize("first", [signal.SIGHUP, signal.SIGTERM, signal.SIGINT])
def test_only_ctrl_c_kills_programs_that_are_to_end(
    lab: Laboratory, tmp_path: Path, first: int, later: int
) -> None:
    (tmp_path / "orderly.sh").write_text(ORDERLY)
    file = tmp_path / "lab.toml"
    file.write_text('[programs.ARM]\nrun = ["sh", "orderly.sh"]\n')
    os.mkfifo(tmp_path / "go")
    go = os.open(tmp_path / "go", os.O_RDWR)  # does not wait for a reader
    up = lab.start(*GECOS, "up", file)
    up.wait_for("up: ARM is ready")
    up.signal(first)
    up.wait_for("[ARM] braking")
    up.signal(later)
    until(lambda: not pending_signals(up.pid), "the second signal has arrived")
    with os.fdopen(go, "w") as word:
        word.write("go\n")
        word.flush()
        assert up.finish() == 0, str(up)
    assert "[ARM] stands" in up.output()


def pending_signals(pid: int) -> int:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return sum(int(line.split()[1], 16) for line in lines if line.startswith(("SigPnd", "ShdPnd")))


def test_a_closed_terminal_ends_all_programs_in_order(lab: Laboratory, tmp_path: Path) -> None:
    """Although one of them must be killed, which nobody can be told any more."""
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    (tmp_path / "orderly.sh").write_text(ORDERLY.replace("read word <go; ", ""))
    file = tmp_path / "lab.toml"
    file.write_text(
        '[programs.ARM]\nrun = ["sh", "orderly.sh"]\n'
        "[programs.DEAF]\n"
        'run = ["sh", "-c", "trap \'\' TERM; echo serving X; while :; do sleep 1; done"]\n'
    )
    ours, terminal = pty.openpty()
    up = subprocess.Popen(
        ["setsid", "--ctty", *GECOS, "up", str(file)],
        env=lab.env,
        stdin=terminal,
        stdout=terminal,
        stderr=terminal,
    )
    os.close(terminal)
    said = b""
    while b"are ready" not in said:
        said += os.read(ours, 4096)
    os.close(ours)
    assert up.wait(30) == 0
    assert (tmp_path / "stands").exists()
    assert alive_with(marker) == {}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_start_that_is_interrupted_ends_in_order_too(
    lab: Laboratory, tmp_path: Path, number: int
) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    file = tmp_path / "lab.toml"
    file.write_text('[programs.SLOW]\nrun = ["sh", "-c", "echo warming up; exec sleep 1000"]\n')
    up = lab.start(*GECOS, "up", file)
    up.wait_for("[SLOW] warming up")
    up.signal(number)
    assert up.finish() == 0, str(up)
    assert "up: ending" in up.output()
    assert alive_with(marker) == {}


@pytest.mark.parametrize("named", ["lcm:239.255.76.67:7668/OTHER", "lcm"])
def test_a_broker_that_its_programs_would_not_use_is_not_started(
    lab: Laboratory, tmp_path: Path, named: str
) -> None:
    lab.env["GECOS_BROKER"] = named
    file = tmp_path / "lab.toml"
    text = '[programs.OVEN]\nrun = ["sh", "-c", "echo serving $GECOS_BROKER; exec sleep 1000"]\n'
    file.write_text(text)
    up = lab.run(*GECOS, "up", file)
    assert up.finish() == 1, str(up)
    assert f"gecos: GECOS_BROKER is '{named}', so the programs would not use" in up.output()
    assert "[BROKER]" not in up.output()

    file.write_text(f"{text}[broker]\nstart = false\n")
    up = lab.start(*GECOS, "up", file)
    up.wait_for(f"[OVEN] serving {named}")
    up.wait_for("up: OVEN is ready")
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)


def test_with_json_each_event_is_a_line(lab: Laboratory, tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(
        '[programs.OVEN]\nrun = ["sh", "-c", "echo serving \\u001b[2J; exec sleep 1000"]\n'
        '[programs.SHORT]\nrun = ["sh", "-c", "exit 3"]\nready = ""\nrestart = true\n'
    )
    up = lab.start(*GECOS, "up", "--json", file)
    up.wait_for('"event": "restarted"')
    up.wait_for('"restarts_in": 1.0')
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)
    validator = Draft202012Validator(SCHEMA | {"$ref": "#/$defs/up"})
    events = [json.loads(line) for line in up.lines]
    for event in events:
        validator.validate(event)
    shown = [(event["event"], event.get("program")) for event in events]
    order = [("ready", "BROKER"), ("output", "OVEN"), ("ready", "OVEN"), ("all_ready", None)]
    places = [shown.index(event) for event in [*order, ("closing", None)]]
    assert places == sorted(places), shown
    ended = next(event for event in events if event["event"] == "ended")
    assert (ended["program"], ended["status"], ended["restarts_in"]) == ("SHORT", 3, 0.5)


def test_with_json_a_failure_is_the_last_line(lab: Laboratory, tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    file.write_text('[programs.ARM]\nrun = ["sh", "-c", "exit 7"]\n')
    up = lab.run(*GECOS, "up", "--json", file)
    assert up.finish() == 1, str(up)
    *events, failure = map(json.loads, up.lines)
    assert all("event" in event for event in events)
    assert failure["error"]["text"] == "ARM ended with status 7 before it was ready"


def test_the_broker_says_as_json_that_it_is_ready(lab: Laboratory) -> None:
    broker = lab.start(*GECOS, "broker", "--json")
    line = broker.wait_for("ready")
    Draft202012Validator(SCHEMA | {"$ref": "#/$defs/broker"}).validate(json.loads(line))
    assert broker.terminate() == 0, str(broker)


def test_a_death_is_told_although_a_child_keeps_the_output_open(
    lab: Laboratory, tmp_path: Path
) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    file = tmp_path / "lab.toml"
    file.write_text(
        '[programs.PARENT]\nrun = ["sh", "-c", "echo serving X; sleep 1000 & exit 3"]\n'
        "restart = true\n"
    )
    up = lab.start(*GECOS, "up", file)
    up.wait_for("PARENT ended with status 3; it is started again in 1 s")  # the second time
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)
    await_ends(alive_with(marker))
    assert alive_with(marker) == {}


def test_programs_go_on_when_nobody_reads_their_output(lab: Laboratory, tmp_path: Path) -> None:
    """Far more is printed than a pipe holds, after the reader of `gecos up` is gone."""
    file = tmp_path / "lab.toml"
    file.write_text(
        '[programs.CHATTY]\nrun = ["sh", "-c", "echo serving X; read word <go; '
        'yes | head -c 1000000; touch done; exec sleep 1000"]\n'
    )
    os.mkfifo(tmp_path / "go")
    with subprocess.Popen(
        [*GECOS, "up", str(file)], env=lab.env, stdout=subprocess.PIPE, text=True
    ) as up:
        assert up.stdout is not None
        while "up: CHATTY is ready" not in up.stdout.readline():
            pass
        up.stdout.close()
        (tmp_path / "go").write_text("go\n")
        while not (tmp_path / "done").exists():
            assert up.poll() is None
        up.send_signal(signal.SIGINT)


def test_what_serve_prints_says_that_a_program_is_ready(lab: Laboratory, tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    file.write_text('[programs.OVEN]\nrun = ["sh", "-c", "echo serving OVEN; exec sleep 1000"]\n')
    up = lab.start(*GECOS, "up", file)
    up.wait_for("up: OVEN is ready; Ctrl-C ends them")
    up.signal(signal.SIGINT)
    assert up.finish() == 0, str(up)


def test_a_program_that_never_says_that_it_is_ready_is_refused_with_advice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules["gecos.laboratory.running"], "READY_WITHIN", 0.1)
    program = Program("OVEN", ("sh", "-c", "echo warm; exec sleep 1000"))
    wanted = r"OVEN is not ready: .* no line that begins with 'serving ' or .* `ready` in lab.toml"
    laboratory = LaboratoryDescription((program,), starts_broker=False, folder=tmp_path)
    with pytest.raises(LaboratoryError, match=wanted), running(laboratory):
        pass


def test_killed_it_leaves_nothing_running(lab: Laboratory) -> None:
    marker = f"up-{uuid.uuid4()}"
    lab.env["GECOS_TEST_MARKER"] = marker
    up = lab.start(*GECOS, "up", "--programs", lab.build)
    up.wait_for("are ready")
    alive = alive_with(marker)
    assert len(alive) >= 6, "gecos up, the broker and four devices"
    up.signal(signal.SIGKILL)
    assert up.finish() == -signal.SIGKILL
    await_ends(alive | alive_with(marker))
    assert alive_with(marker) == {}


@pytest.mark.parametrize(
    ("run", "said"),
    [
        ('["no-such-program"]', "lab.toml:2: ARM: there is no program no-such-program"),
        ('["sh", "-c", "exit 7"]', "ARM ended with status 7 before it was ready"),
        ('["sh", "-c", "echo already; exit 7"]', "ARM ended with status 7 before it was ready"),
        ('["sh", "-c", "echo is not ready; exit 7"]', "ARM ended with status 7 before it was"),
        ('["./lab.toml"]', "lab.toml:2: ARM: ./lab.toml is no executable file; run `chmod +x "),
    ],
)
def test_a_laboratory_that_cannot_start_says_why(
    run: str, said: str, lab: Laboratory, tmp_path: Path
) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(f"# a laboratory\n[programs.ARM]\nrun = {run}\n")
    up = lab.run(*GECOS, "up", file)
    assert up.finish() == 1, str(up)
    assert said in up.output()
    assert "Traceback" not in up.output()


def test_a_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(
        '[broker]\naddress = "lcm:239.255.76.67:7667"\n'
        '[programs."left arm"]\nrun = ["./arm", "--name", "LEFT"]\nrestart = true\n'
    )
    found = read_laboratory(file)
    assert not found.starts_broker
    assert found.broker_address == "lcm:239.255.76.67:7667"
    assert found.folder == tmp_path
    assert found.programs == (Program("left arm", ("./arm", "--name", "LEFT"), True, line=3),)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "1: programs: no program is named; add [programs.NAME] with run = […]"),
        ("programs = 3", "1: programs: a table is expected"),
        ("\n[brokr]\n", "2: brokr: this key is unknown; did you mean broker?"),
        ('[programs.A]\nrum = ["x"]', "2: programs.A.rum: this key is unknown; did you mean run?"),
        ('[programs.BROKER]\nrun = ["x"]', "1: programs.BROKER: this is the name of the broker"),
        ("[programs.A]\nrestart = true", "1: programs.A.run: write a list of texts"),
        ("[programs.A]\nrun = []", "2: programs.A.run: write a list of texts"),
        ('[programs.A]\nrun = "x"', "2: programs.A.run: a list of words is expected"),
        ('[programs.A]\nrun = ["x"]\nrestart = 1', "3: programs.A.restart: true or false is"),
        ("[programs]\nA = 3", "2: programs.A: a table is expected"),
        (
            '[broker]\nstart = true\naddress = "lcm:1"\n[programs.A]\nrun = ["x"]',
            "3: broker.address: this address names a broker that runs already",
        ),
        ('[programs.A]\nrun = ["x"]\nenvironment = { B = 1 }', "3: programs.A.environment: the"),
        ("[programs.A\n", "Expected ']'"),
        ("clock = 10", "1: clock: a table is expected"),
        ("[clock]\nsped = 10", "2: clock.sped: this key is unknown; did you mean speed?"),
        ("[clock]\n", "1: clock.speed: a number from 0.1 to 100000 is expected"),
        ("[clock]\nspeed = 0", "2: clock.speed: a number from 0.1 to 100000 is expected"),
        ('[clock]\nspeed = "10"', "2: clock.speed: a number from 0.1 to 100000 is expected"),
        ("[clock]\nspeed = nan", "2: clock.speed: a number from 0.1 to 100000 is expected"),
        ("[clock]\nspeed = true", "2: clock.speed: a number from 0.1 to 100000 is expected"),
    ],
)
def test_a_file_that_says_what_cannot_be_is_refused_with_its_line(
    text: str, said: str, tmp_path: Path
) -> None:
    file = tmp_path / "lab.toml"
    file.write_text(text)
    with pytest.raises(LaboratoryFileError) as refused:
        read_laboratory(file)
    assert said in str(refused.value)
    assert str(refused.value).startswith(f"{file}")
