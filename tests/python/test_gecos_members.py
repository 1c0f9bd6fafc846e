"""The verbs of `gecos` for the members of an object, driven on a served arm."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click
import gecos
import pytest
from click.shell_completion import BashComplete
from command_output import Run, valid
from gecos.cli import members, stopping
from gecos.cli.app import app
from gecos.dynamic_client import connect
from jsonschema import Draft202012Validator
from robcl.frames import Frame
from robcl.manipulator import (
    Configuration,
    CorrectionsStopped,
    FollowLimits,
    FollowMode,
    FollowState,
    ManipulatorServant,
    MotionProgress,
    OutOfReach,
    Shoulder,
    Trajectory,
)

HOME = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}
GOAL = HOME | {"position": {"x": 0.4, "y": 0, "z": 0.3}}


class Arm(ManipulatorServant):
    """An arm that stands where it was sent."""

    def __init__(self) -> None:
        self.at = Frame()
        self.offset = Frame()
        self.carrier = ""
        self.factor = 1.0
        self.mounts = threading.Event()
        self.mounts.set()
        self.mounting = threading.Event()
        self.readable = threading.Event()
        self.readable.set()
        self.counts = threading.Event()
        self.counts.set()
        self.hangs = False
        self.override: float | None = None  # of the progress of `move`
        self.moving = threading.Event()
        self.canceled = threading.Event()
        self.brake: Callable[[], Any] = self.brakes
        self.stops: Callable[[], Any] = lambda: None

    def gecos_on_stop(self) -> None:
        self.stops()

    def brakes(self) -> None:
        self.canceled.set()
        raise gecos.Interrupted

    def parent(self) -> str:
        return self.carrier

    def mount(self, carrier: str, offset: Frame) -> None:
        self.mounting.set()
        self.mounts.wait(30)

    def base(self) -> Frame:
        return Frame()

    def cycle(self) -> float:
        return 0.004

    def braking_time(self) -> float:
        return 0.25

    def clock_speed(self) -> float:
        return 1.0

    def reached_clock_speed(self) -> float:
        return 1.0

    def set_configuration(self, wanted: Configuration, run: gecos.Execution) -> None:
        pass

    def override_speed(self, factor: float) -> None:
        self.factor = factor

    def speed_override(self) -> float:
        return self.factor

    def standing(self) -> bool:
        return True

    def missed_cycles(self) -> int:
        self.counts.wait(30)
        return 0

    def follow(
        self, axes: FollowMode, limits: FollowLimits | None, run: gecos.Execution[FollowState]
    ) -> None:
        raise CorrectionsStopped(FollowState())

    def tool(self) -> Frame:
        return self.at

    def flange(self) -> Frame:
        return self.at

    def posture(self) -> Configuration:
        self.readable.wait(30)
        return Configuration(arm=Shoulder.LEFTY)

    def tool_offset(self) -> Frame:
        return self.offset

    def set_tool_offset(self, value: Frame) -> None:
        self.mounts.wait(30)
        self.offset = value

    def pose_epoch(self) -> int:
        return 1

    def move(
        self,
        goal: Frame,
        how: Trajectory | None,
        pose_epoch: int | None,
        run: gecos.Execution[MotionProgress],
    ) -> None:
        self.moving.set()
        if goal.position[2] < 0:
            raise OutOfReach("the floor")
        run.progress(0.5, MotionProgress(0.5, 1.0, speed_override=self.override))
        if self.hangs:
            run.wait_interrupted(30.0)
            self.brake()
        self.at = goal


@pytest.fixture
def arm(lab: gecos.Lab) -> Iterator[Arm]:
    servant = Arm()
    with gecos.Server(lab) as server:
        server.add("ARM", servant, simulated=True)
        yield servant


def test_get_reads_an_attribute(arm: Arm, run: Run) -> None:
    assert run("get", "ARM", "parent") == (0, "\n", "")
    code, out, _ = run("get", "ARM", "tool")
    assert (code, json.loads(out)) == (0, HOME)


def test_get_as_json_says_what_was_read(arm: Arm, run: Run) -> None:
    code, out, _ = run("get", "ARM", "posture", "--json")
    value = {"arm": "LEFTY", "bend": None, "hand": None}
    expected = {"name": "ARM", "attribute": "posture", "value": value, "unit": ""}
    assert (code, json.loads(out)) == (0, expected)


def test_set_changes_an_attribute_under_status_for_the_call(arm: Arm, run: Run) -> None:
    assert run("set", "ARM", "tool_offset", json.dumps(GOAL)) == (
        0,
        "ARM: tool_offset is set\n",
        "",
    )
    assert arm.offset.position[2] == 0.3
    assert run("holders", "ARM")[1] == "ARM: nobody holds actor or master status\n"


def test_set_refuses_a_value_that_does_not_fit_by_its_path(arm: Arm, run: Run) -> None:
    wrong = json.dumps({"position": {"x": "near"}})
    code, out, err = run("set", "ARM", "tool_offset", wrong)
    assert (code, out) == (2, "")
    assert err.startswith("gecos: tool_offset.value.position.x: a number is expected")


def test_set_of_a_readonly_attribute_says_so(arm: Arm, run: Run) -> None:
    assert run("set", "ARM", "tool", "{}") == (
        2,
        "",
        "gecos: ARM.tool is readonly and cannot be set\n",
    )


def test_call_moves_and_says_finished(arm: Arm, run: Run) -> None:
    given = json.dumps({"goal": GOAL, "how": {"speed": 0.5, "path": "STRAIGHT"}})
    assert run("call", "ARM", "move", given) == (0, "ARM.move: FINISHED\n", "")
    assert arm.at.position[0] == 0.4


@pytest.mark.parametrize(
    ("password", "todo"),
    [
        ([], "end this call, and set the factor by gecos call ARM override_speed factor=1"),
        (
            ["--password", "two"],
            "gecos call ARM override_speed factor=1 with the same --password lets it go on",
        ),
    ],
)
def test_call_says_once_that_the_motion_is_paused(
    password: list[str], todo: str, arm: Arm, run: Run
) -> None:
    arm.hangs, arm.override = True, 0.0
    words = ["call", "ARM", "move", f"goal={json.dumps(GOAL)}", "--timeout", "0.5", *password]
    code, out, err = run(*words)
    assert (code, out) == (3, "")
    notice, rest = err.split("\n", 1)
    assert notice == f"ARM is paused, because its speed_override is 0; {todo}"
    assert "paused" not in rest


def test_call_of_a_motion_that_is_only_slowed_down_says_nothing(arm: Arm, run: Run) -> None:
    arm.hangs, arm.override = True, 0.5
    said = run("call", "ARM", "move", f"goal={json.dumps(GOAL)}", "--timeout", "0.3")
    assert "paused" not in said[2]


def test_a_status_is_shared_by_the_password_of_the_environment(
    arm: Arm, lab: gecos.Lab, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("set", "ARM", "tool_offset", json.dumps(HOME))
    with gecos.Lab() as other, gecos.actor(other.dynamic("ARM"), "shared"):
        assert run(*words)[0] == 5
        monkeypatch.setenv("GECOS_PASSWORD", "shared")
        assert run(*words)[0] == 0


def test_call_takes_parameters_one_by_one(arm: Arm, run: Run) -> None:
    code, out, _ = run("call", "ARM", "move", f"goal={json.dumps(GOAL)}", "--json")
    finished = {"name": "ARM", "operation": "move", "state": "FINISHED", "result": None}
    assert (code, json.loads(out)) == (0, finished)


def test_a_declared_exception_exits_with_3(arm: Arm, run: Run) -> None:
    under = json.dumps({"goal": GOAL | {"position": {"x": 0, "y": 0, "z": -1}}})
    code, out, err = run("call", "ARM", "move", under)
    assert (code, out, err) == (3, "", "gecos: robcl::OutOfReach(reason='the floor')\n")
    code, out, _ = run("call", "ARM", "move", under, "--json")
    shown = {
        "exit_code": 3,
        "text": "robcl::OutOfReach(reason='the floor')",
        "detail": "FAULT",
        "state": "COMMAND_FAILED",
        "exception": "robcl::OutOfReach",
    }
    assert (code, json.loads(out)) == (3, {"error": shown})


def test_an_object_that_another_client_holds_exits_with_5(
    arm: Arm, lab: gecos.Lab, run: Run
) -> None:
    with gecos.Lab() as other, gecos.master(other.dynamic("ARM")):
        code, out, err = run("call", "ARM", "move", json.dumps({"goal": GOAL}))
    assert (code, out) == (5, "")
    assert err.startswith("gecos: ")
    assert "master" in err


def test_a_value_out_of_range_is_refused_before_it_is_sent(arm: Arm, run: Run) -> None:
    given = json.dumps({"goal": GOAL, "how": {"speed": 2.0}})
    code, out, err = run("call", "ARM", "move", given)
    assert (code, out) == (2, "")
    assert "move.how.speed" in err
    assert "[0.01, 1.0]" in err
    assert not arm.moving.is_set()


def test_a_frame_without_its_orientation_is_refused_with_the_reason(arm: Arm, run: Run) -> None:
    code, out, err = run("set", "ARM", "tool_offset", '{"position": {"z": 0.1}}')
    assert (code, out) == (3, "")
    assert "0 is the length of the orientation's quaternion, which must be 1" in err
    assert arm.offset == Frame()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("get", "ARM", "toool"), "has no attribute 'toool'; did you mean tool?"),
        (("call", "ARM", "fly"), "has no operation 'fly'; it has mount, move"),
        (("watch", "ARM", "tol"), "has no attribute or event 'tol'; did you mean tool?"),
        (("hz", "ARM", "posture"), "has no stream 'posture'; it has tool, flange"),
        (("call", "ARM", "move", "{"), "not JSON: Expecting property name"),
        (("call", "ARM", "move", "fast"), "'fast' is neither a JSON object nor PARAMETER=VALUE"),
        (("call", "ARM", "move"), "move() needs its parameter goal"),
        (("call", "ARM", "move", "gaol={}"), "move() has no parameter gaol"),
    ],
)
def test_wrong_words_exit_with_2(arm: Arm, run: Run, words: tuple[str, ...], said: str) -> None:
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert said in err


def test_an_unknown_object_exits_with_4(arm: Arm, run: Run) -> None:
    code, out, err = run("get", "AMR", "tool")
    assert (code, out) == (4, "")
    assert "did you mean ARM?" in err


def test_a_timeout_cancels_the_call(arm: Arm, run: Run) -> None:
    arm.hangs = True
    code, out, err = run("call", "ARM", "move", json.dumps({"goal": GOAL}), "--timeout", "0.2")
    assert (code, out) == (3, "")
    assert err == "gecos: ARM.move has not ended within 0.2 s and was canceled\n"
    assert arm.canceled.wait(10)


def test_a_timeout_ends_the_wait_for_an_attribute(arm: Arm, run: Run) -> None:
    arm.mounts.clear()
    code, _, err = run("set", "ARM", "tool_offset", json.dumps(GOAL), "--timeout", "0.1")
    arm.mounts.set()
    assert (code, err) == (3, "gecos: ARM.tool_offset has not ended within 0.1 s and goes on\n")


def test_a_timeout_of_an_operation_that_is_not_cancelable_says_that_it_goes_on(
    arm: Arm, run: Run
) -> None:
    arm.mounts.clear()
    given = json.dumps({"carrier": "", "offset": HOME})
    code, _, err = run("call", "ARM", "mount", given, "--timeout", "0.1")
    arm.mounts.set()
    assert code == 3
    assert err == "gecos: ARM.mount has not ended within 0.1 s and goes on\n"


def test_what_goes_on_after_a_timeout_has_its_state_in_json(arm: Arm, run: Run) -> None:
    arm.mounts.clear()
    given = json.dumps({"carrier": "", "offset": HOME})
    _, out, _ = run("call", "ARM", "mount", given, "--timeout", "0.1", "--json")
    arm.mounts.set()
    assert valid(out, "failure")
    assert json.loads(out)["error"]["state"] == "RUNNING"


def test_a_move_that_fails_while_it_is_canceled_says_how(arm: Arm, run: Run) -> None:
    arm.hangs = True
    arm.brake = raising(OutOfReach("the brake slips"))
    move = ("call", "ARM", "move", json.dumps({"goal": GOAL}), "--timeout", "0.1")
    assert run(*move) == (3, "", "gecos: robcl::OutOfReach(reason='the brake slips')\n")
    error = json.loads(run(*move, "--json")[1])["error"]
    assert (error["detail"], error["exception"]) == ("FAULT", "robcl::OutOfReach")


def test_a_move_that_finishes_while_it_is_canceled_has_finished(arm: Arm, run: Run) -> None:
    arm.hangs = True
    arm.brake = lambda: None
    move = ("call", "ARM", "move", json.dumps({"goal": GOAL}), "--timeout", "0.1")
    assert run(*move) == (0, "ARM.move: FINISHED\n", "")


def test_a_move_that_brakes_for_long_is_still_being_canceled(
    arm: Arm, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(members, "_CANCELED_WITHIN", 0.2)
    stands = threading.Event()
    arm.hangs = True
    arm.brake = lambda: stands.wait(30)
    move = ("call", "ARM", "move", json.dumps({"goal": GOAL}), "--timeout", "0.1", "--json")
    code, out, _ = run(*move)
    stands.set()
    error = json.loads(out)["error"]
    assert (code, error["detail"], error["state"]) == (3, "CANCELING", "RUNNING")
    assert error["text"] == "ARM.move has not ended within 0.1 s and is still being canceled"


def test_ctrl_c_says_what_became_of_the_command(arm: Arm, run: Run) -> None:
    arm.hangs = True
    with ctrl_c_after(arm.moving):
        said = run("call", "ARM", "move", json.dumps({"goal": GOAL}))
    assert said == (130, "", "gecos: interrupted: ARM.move was canceled\n")


def test_ctrl_c_says_that_a_command_goes_on(
    arm: Arm, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(members, "_CANCELED_WITHIN", 0.1)
    arm.mounts.clear()
    given = json.dumps({"carrier": "", "offset": HOME})
    with ctrl_c_after(arm.mounting):
        code, out, err = run("call", "ARM", "mount", given, "--json")
    arm.mounts.set()
    assert (code, err) == (130, "")
    assert valid(out, "failure")
    error = json.loads(out)["error"]
    assert (error["text"], error["state"]) == ("interrupted: ARM.mount goes on", "RUNNING")


def raising(error: Exception) -> Callable[[], None]:
    def act() -> None:
        raise error

    return act


@contextmanager
def ctrl_c_after(event: threading.Event) -> Iterator[None]:
    """Sends this process a SIGINT once `event` is set."""

    def press() -> None:
        if event.wait(30):
            os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    yield
    thread.join()


def test_get_ends_after_its_timeout(arm: Arm, run: Run) -> None:
    arm.readable.clear()
    code, _, err = run("get", "ARM", "posture", "--timeout", "0.1")
    arm.readable.set()
    assert code == 3
    assert err == "gecos: reading ARM.posture has not ended within 0.1 s and goes on\n"


@pytest.mark.parametrize(
    ("attribute", "said"),
    [
        ("posture", "reading ARM.posture has not ended within 0.1 s"),
        ("tool", "stream ARM.tool: no sample within 0.1 s"),
    ],
)
def test_watch_ends_when_a_value_takes_too_long(
    arm: Arm, run: Run, attribute: str, said: str
) -> None:
    arm.readable.clear()
    code, out, err = run("watch", "ARM", attribute, "--count", "1", "--timeout", "0.1")
    arm.readable.set()
    assert (code, out) == (3, "")
    assert err.startswith(f"gecos: {said}")


def test_wrong_usage_with_json_is_json(arm: Arm, run: Run) -> None:
    for words in (("call", "ARM", "move", "{"), ("get", "ARM"), ("get", "ARM", "toool")):
        code, out, err = run(*words, "--json")
        assert (code, err) == (2, ""), words
        assert valid(out, "failure")


def test_wait_sees_an_object_that_comes(lab: gecos.Lab, run: Run) -> None:
    with gecos.Server(lab) as server:
        later = threading.Timer(0.3, lambda: server.add("ARM", Arm(), simulated=True))
        later.start()
        assert run("wait", "ARM", "--timeout", "20") == (0, "ARM: online\n", "")
        later.join()


def test_wait_continues_when_the_broker_dies_while_it_is_asked(
    arm: Arm, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    dies = iter([gecos.CommandFailed(gecos.Detail.OUTCOME_UNKNOWN, "the broker is gone")])
    listed = connect.entries

    def entries(lab: gecos.Lab, *, patience: float) -> Any:
        for error in dies:
            raise error
        return listed(lab, patience=patience)

    monkeypatch.setattr(connect, "entries", entries)
    assert run("wait", "ARM", "--timeout", "20") == (0, "ARM: online\n", "")


def test_wait_ends_when_no_medium_reaches_the_object(lab: gecos.Lab) -> None:
    with gecos.Server(lab) as server:
        server.add("ARM", Arm(), media=["inproc"])
        done = in_another_process("wait", "ARM")
    assert done.returncode == 4
    assert done.stderr.startswith("gecos: ARM: QOS_UNAVAILABLE: ARM cannot be reached (inproc: ")


def test_ls_says_why_a_server_cannot_answer(lab: gecos.Lab) -> None:
    with gecos.Server(lab) as server:
        server.add("ARM", Arm(), media=["inproc"])
        shown = in_another_process("ls").stdout
        (arm,) = json.loads(in_another_process("ls", "--json").stdout)
    assert not arm["answers"]
    assert arm["problem"] == "cannot be reached (inproc: it is in another process)"
    assert f"hardware, {arm['problem']}" in shown


def in_another_process(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "gecos.cli", *words], capture_output=True, text=True, timeout=60
    )


def test_text_of_a_server_does_not_command_the_terminal(arm: Arm, run: Run) -> None:
    arm.carrier = "\x1b[2Jgone"
    assert run("get", "ARM", "parent") == (0, "\\x1b[2Jgone\n", "")


def test_watch_prints_a_line_for_each_sample(arm: Arm, run: Run) -> None:
    with publishing(arm):
        code, out, _ = run("watch", "ARM", "tool", "--count", "3", "--json")
    samples = [json.loads(line) for line in out.splitlines()]
    assert code == 0
    assert [s["value"] for s in samples] == [HOME] * 3
    assert samples[0]["sequence"] < samples[2]["sequence"]


def test_watch_reads_an_attribute_without_a_stream(arm: Arm, run: Run) -> None:
    code, out, _ = run("watch", "ARM", "posture", "--count", "2", "--every", "0.01")
    assert (code, out.splitlines()) == (0, ['{"arm": "LEFTY", "bend": null, "hand": null}'] * 2)


def test_watch_without_an_attribute_ends_when_the_holders_do_not_change(arm: Arm, run: Run) -> None:
    code, out, err = run("watch", "ARM", "--timeout", "0")
    assert (code, out) == (3, "ARM: nobody holds actor or master status\n")
    assert err == "gecos: ARM: its holders have not changed within 0.0 s\n"


def test_hz_counts_samples_and_losses(arm: Arm, run: Run) -> None:
    with publishing(arm):
        code, out, _ = run("hz", "ARM", "tool", "--count", "2", "--window", "0.3", "--json")
    first, second = (json.loads(line) for line in out.splitlines())
    assert code == 0
    assert first["samples"] > 0
    assert second["rate"] > 0


def test_hz_does_not_count_a_sample_from_before_the_measurement(arm: Arm, run: Run) -> None:
    arm.publish_tool(arm.at)
    _, out, _ = run("hz", "ARM", "tool", "--count", "1", "--window", "0.1", "--json")
    line = json.loads(out)
    assert (line["samples"], line["rate"]) == (0, 0)


def test_wait_returns_when_the_object_is_online(arm: Arm, run: Run) -> None:
    assert run("wait", "ARM", "--timeout", "5") == (0, "ARM: online\n", "")
    assert run("wait", "ROBOT", "--timeout", "0")[0] == 4


def test_describe_shows_members_with_units_ranges_and_access(arm: Arm, run: Run) -> None:
    code, out, _ = run("describe", "ARM")
    assert code == 0
    assert (
        "  tool: robcl::Frame  (stream out at 250 Hz, class SOFT_REALTIME, latency 0.005 s, "
        "lifespan 1 s)\n" in out
    )
    assert (
        "  alter: robcl::Frame  (stream in at 1000 Hz, watchdog 48 ms, send: actor, class "
        "HARD_REALTIME, depth 64, media shm|can)\n" in out
    )
    assert "  tool_offset: robcl::Frame  (set: actor)\n" in out
    assert (
        "  move(goal: robcl::Frame, how: robcl::Trajectory?, pose_epoch: uint64?)  (actor, "
        "cancelable, on_new blend, feedback robcl::MotionProgress, raises " in out
    )
    code, out, _ = run("describe", "ARM", "--json")
    shown = json.loads(out)
    assert shown["interface_name"] == "robcl::Manipulator"
    assert {m["interface"]["name"] for m in shown["models"]} == {
        "robcl::Device",
        "robcl::Manipulator",
    }


def test_describe_shows_the_values_of_single_readings(arm: Arm, run: Run) -> None:
    _, out, _ = run("describe", "ARM")
    assert "  braking_time: double [s] = 0.25\n" in out
    assert "  standing: boolean = true\n" in out
    assert "  posture: robcl::Configuration\n" in out, "a value with members is not shown"
    assert "  tool: robcl::Frame  (stream out at 250 Hz, " in out, "nor one that streams"
    assert "  tool_offset: robcl::Frame  (set: actor)\n" in out, "nor one that is set"
    _, out, _ = run("describe", "ARM", "--json")
    assert valid(out, "describe")
    readings = json.loads(out)["readings"]
    assert (readings["braking_time"], readings["cycle"]) == (0.25, 0.004)
    assert not {"posture", "tool", "tool_offset", "alter"} & set(readings)


def test_describe_does_not_wait_for_a_reading_that_hangs(arm: Arm, run: Run) -> None:
    arm.counts.clear()
    try:
        code, out, _ = run("describe", "ARM")
    finally:
        arm.counts.set()
    assert code == 0
    assert "  missed_cycles: uint64\n" in out
    assert "  standing: boolean = true\n" in out, "it was read before"
    assert "\noperations\n" in out


def test_describe_shows_the_members_and_enumerators_of_types(arm: Arm, run: Run) -> None:
    _, out, _ = run("describe", "ARM")
    assert "  robcl::PathType: STRAIGHT, JOINT\n" in out
    assert "  robcl::Vector: x: double [m], y: double [m], z: double [m]\n" in out
    assert "  robcl::Trajectory: speed: double [0.01 to 1.0] = 1.0, " in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("call", "ARM", "move", '{"goal": {}, "goal": {}}'), "the member occurs twice"),
        (("call", "ARM", "move", '{"goal": {"position": {"x": 1e999}}}'), "too large for a number"),
        (("call", "ARM", "move", 'goal={"position": {"x": NaN}}'), "not JSON: NaN"),
        (("call", "ARM", "move", "goal=" + 3000 * "[" + 3000 * "]"), "nested deeper than 100"),
        (
            ("set", "ARM", "tool_offset", '{"position": {"x": 1' + 400 * "0" + "}}"),
            "is too large for a",
        ),
        (("watch", "ARM", "posture", "--every", "inf"), "inf is not from 0.01 to 1e+06"),
        (("hz", "ARM", "tool", "--window", "nan"), "nan is not from 0.1 to 1e+06"),
        (("wait", "ARM", "--timeout", "nan"), "nan is not from 0 to 1e+06"),
    ],
)
def test_odd_values_exit_with_2(arm: Arm, run: Run, words: tuple[str, ...], said: str) -> None:
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert said in err
    assert not arm.moving.is_set()


def test_stop_stops_all(arm: Arm, run: Run) -> None:
    assert run("stop", "--all") == (0, "ARM: stopped\n", "")
    code, out, err = run("stop", "ROBOT", "ARM", "--json")
    shown = json.loads(out)
    assert (code, shown["stopped"]) == (4, ["ARM"])
    assert valid(out, "stop")
    assert (shown["failed"][0]["name"], shown["failed"][0]["detail"]) == ("ROBOT", "NO_SERVER")
    assert err.startswith("gecos: ROBOT was not stopped: NO_SERVER: no such object is online")
    assert run("stop")[0] == 2
    assert run("stop", "ARM", "--all")[0] == 2


def test_stop_names_an_object_that_may_still_move(
    arm: Arm, lab: gecos.Lab, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Unanswered:
        def result(self, timeout: float) -> None:
            raise TimeoutError(f"stop is still running after {timeout} s")

    stop = gecos.stop

    def stops(robot: gecos.Object) -> Any:
        stuck = robot._gecos_session.object_name == "STUCK"
        return Unanswered() if stuck else stop(robot)

    monkeypatch.setattr(gecos, "stop", stops)
    with gecos.Server(lab) as server:
        server.add("STUCK", Arm())
        code, out, err = run("stop", "--all", "--json")
    shown = json.loads(out)
    assert valid(out, "stop")
    assert (code, shown["stopped"], shown["failed"][0]["name"]) == (3, ["ARM"], "STUCK")
    said = "its server has not confirmed the stop within 5 s; the object may still move"
    assert err == f"gecos: STUCK was not stopped: {said}\n"


def test_stop_without_a_broker_names_the_objects(place: object, run: Run) -> None:
    code, out, err = run("stop", "ARM", "--json")
    assert code == 4
    assert valid(out, "stop")
    assert [failure["name"] for failure in json.loads(out)["failed"]] == ["ARM"]
    assert err.startswith("gecos: ARM was not stopped: BROKER: NO_SERVER: no broker answers")


def test_stop_reaches_the_objects_of_this_host_without_a_broker(place: object, run: Run) -> None:
    arm, stopped = Arm(), threading.Event()
    arm.stops = stopped.set
    with gecos.Lab() as lab, gecos.Server(lab) as server:
        with gecos.Broker(lab):
            server.add("ARM", arm, simulated=True)
        code, out, err = run("stop", "ARM", "ROBOT", "--json")
        assert stopped.wait(10)
        shown = json.loads(out)
        assert valid(out, "stop")
        assert (code, shown["stopped"]) == (4, ["ARM"])
        assert [failure["name"] for failure in shown["failed"]] == ["ROBOT"]
        assert run("stop", "ARM") == (0, "ARM: stopped\n", "")
        code, out, err = run("stop", "--all")
        assert (code, out) == (4, "ARM: stopped\n"), "there may be objects that only a broker knows"
        assert err.startswith("gecos: the broker did not say which other objects are silent: ")
    code, out, err = run("stop", "--all")
    assert (code, out) == (4, "") and "no broker answers" in err


def test_stop_lists_the_objects_once(arm: Arm, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    listed = connect.entries

    def entries(lab: gecos.Lab, *, patience: float = 2.0) -> Any:
        asked.append(patience)
        return listed(lab, patience=patience)

    for module in (connect, stopping):
        monkeypatch.setattr(module, "entries", entries)
    assert run("stop", "ARM", "ROBOT")[0] == 4
    assert len(asked) == 1


def test_stop_all_stops_when_the_broker_does_not_say_what_is_silent(
    arm: Arm, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped = threading.Event()
    arm.stops = stopped.set

    def silent_objects(lab: gecos.Lab) -> Any:
        raise gecos.CreateError([gecos.Attempt("BROKER", gecos.Detail.NO_SERVER, "it is gone")])

    for module in (connect, stopping):
        monkeypatch.setattr(module, "silent_objects", silent_objects)
    code, out, err = run("stop", "--all", "--json")
    assert stopped.wait(10)  # the server answers before it calls gecos_on_stop
    assert code == 4
    assert valid(out, "stop")
    assert json.loads(out)["silent_unknown"]["detail"] == "NO_SERVER"
    assert err.startswith("gecos: the broker did not say which other objects are silent: BROKER: ")


JSON_VERBS = [
    ("ls",),
    ("describe", "ARM"),
    ("holders", "ARM"),
    ("get", "ARM", "tool"),
    ("set", "ARM", "tool_offset", json.dumps(HOME)),
    ("call", "ARM", "move", json.dumps({"goal": GOAL})),
    ("watch", "ARM", "tool", "--count", "1"),
    ("watch", "ARM", "posture", "--count", "1"),
    ("hz", "ARM", "tool", "--count", "1", "--window", "0.1"),
    ("wait", "ARM"),
    ("stop", "ARM"),
]


@pytest.mark.parametrize("words", JSON_VERBS, ids=" ".join)
def test_json_is_as_the_schema_says(
    arm: Arm, lab: gecos.Lab, run: Run, words: tuple[str, ...]
) -> None:
    with publishing(arm), gecos.Lab() as other, gecos.actor(other.dynamic("ARM"), "shared"):
        with_status = words[0] in ("set", "call")
        code, out, err = run(*words, "--json", *(["--password", "shared"] if with_status else []))
    assert code == 0, err
    assert valid(out, words[0])


@pytest.mark.parametrize("words", [*JSON_VERBS[1:-1], ("watch", "ARM")], ids=" ".join)
def test_a_failure_as_json_is_as_the_schema_says(
    lab: gecos.Lab, run: Run, words: tuple[str, ...]
) -> None:
    limit = ["--timeout", "0"] if words[0] == "wait" else []
    code, out, _ = run(*words, "--json", *limit)
    assert code == 4
    assert valid(out, "failure")
    assert json.loads(out)["error"]["exit_code"] == 4


def test_every_verb_has_json_and_the_schema_describes_it(run: Run) -> None:
    code, out, _ = run("schema")
    schema = json.loads(out)
    Draft202012Validator.check_schema(schema)
    verbs = {context.command_path: context.command for context in contexts(app)}
    del verbs["schema"]  # JSON always
    del verbs["completion"]  # a program for a shell
    for group in ("lab", "policy"):
        del verbs[group]  # does nothing without the name of a verb below
    assert code == 0
    without = [
        path for path, verb in verbs.items() if "as_json" not in {p.name for p in verb.params}
    ]
    assert not without
    assert verbs.keys() == schema["$defs"].keys() - {
        "failure",
        "error",
        "key",
        "ls --watch",
        "roster",
    }


def contexts(group: click.Group, above: click.Context | None = None) -> Iterator[click.Context]:
    """All verbs, "keys" and "keys add"."""
    here = above or click.Context(group)
    for name in group.list_commands(here):
        command = group.get_command(here, name)
        assert command is not None
        context = click.Context(command, info_name=name, parent=above)
        yield context
        if isinstance(command, click.Group):
            yield from contexts(command, context)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("gecos de", ["describe"]),
        ("gecos get A", ["ARM"]),
        ("gecos get ARM to", ["tool", "tool_offset"]),
        ("gecos set ARM to", ["tool_offset"]),
        ("gecos hz ARM ", ["tool", "flange", "stood"]),
        ("gecos call ARM ", ["mount", "move", "set_configuration", "override_speed", "follow"]),
        ("gecos call NOBODY ", []),
        ("gecos plot A", ["ARM"]),
        ("gecos stop A", ["ARM"]),
    ],
)
def test_a_shell_completes_verbs_names_and_members(
    arm: Arm, words: str, expected: list[str]
) -> None:
    completion = BashComplete(app, {}, "gecos", "_GECOS_COMPLETE")
    given = words.split(" ")
    found = completion.get_completions(given[1:-1], given[-1])
    assert [item.value for item in found] == expected


def test_the_completion_of_a_misspelt_verb_does_not_fail_into_the_prompt() -> None:
    completion = BashComplete(app, {}, "gecos", "_GECOS_COMPLETE")
    assert "watch" in [item.value for item in completion.get_completions(["wacth"], "")]


def test_completion_prints_the_script_of_a_shell(run: Run) -> None:
    code, out, _ = run("completion", "bash")
    assert code == 0
    assert "_GECOS_COMPLETE=bash_complete" in out


@contextmanager
def publishing(arm: Arm) -> Iterator[None]:
    """Publishes the tool again and again."""
    ended = threading.Event()

    def publish() -> None:
        while not ended.wait(0.005):
            arm.publish_tool(arm.at)

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def test_explain_measures_the_media_on_request(arm: Arm, run: Run) -> None:
    code, out, _ = run("explain", "ARM")
    assert code == 0
    assert "measured" not in out
    code, out, _ = run("explain", "ARM", "--measure")
    assert code == 0
    measured = [line.split() for line in out.splitlines() if line.startswith("  measured over ")]
    assert {"shm:", "lcm:"} <= {words[2] for words in measured}
    # Within one process the answer can come in the moment of the ping.
    assert all(float(words[3]) >= 0 and words[4] == "ms" for words in measured)
    for flags in ([], ["--measure"]):
        code, out, _ = run("explain", "ARM", "--json", *flags)
        assert code == 0
        assert valid(out, "explain")
        for medium in json.loads(out)["media"]:
            assert (medium["round_trip"] is not None) == (bool(flags) and medium["suitable"])


def test_a_medium_that_explain_cannot_reach_does_not_hide_the_others(
    arm: Arm, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    create = gecos.Lab.create

    def refused_over_lcm(lab: gecos.Lab, interface: Any, name: str, **how: Any) -> Any:
        if how.get("medium") == "lcm":
            attempt = gecos.Attempt(name, gecos.Detail.REFUSED, "this key is not admitted")
            raise gecos.CreateError([attempt])
        return create(lab, interface, name, **how)

    monkeypatch.setattr(gecos.Lab, "create", refused_over_lcm)
    code, out, _ = run("explain", "ARM", "--measure")
    assert code == 0
    assert "  measured over shm: " in out
    assert "  lcm: not reached: this key is not admitted\n" in out
    code, out, _ = run("explain", "ARM", "--measure", "--json")
    assert (code, valid(out, "explain")) == (0, True)
    media = {each["medium"]: each for each in json.loads(out)["media"]}
    assert media["lcm"]["not_reached"] == "this key is not admitted"
    assert media["lcm"]["round_trip"] is None
    assert media["shm"]["not_reached"] is None


def test_policy_says_what_reading_and_setting_an_attribute_needs(arm: Arm, run: Run) -> None:
    def told(member: str, *flags: str) -> str:
        code, out, _ = run("policy", "test", "root", socket.gethostname(), "ARM", member, *flags)
        assert code == 0
        return out

    assert told("tool_offset").splitlines()[-2:] == [
        "reading tool_offset needs no status, for every caller",
        "setting tool_offset needs actor status, for every caller",
    ]
    found = json.loads(told("tool_offset", "--json"))
    assert (found["status"], found["status_to_set"]) == ("SENSOR", "ACTOR")
    sending = "sending samples of alter needs actor status, for every caller"
    assert told("alter").splitlines()[-1] == sending
    assert "reading alter" not in told("alter")
    assert told("move").splitlines()[-1] == "move needs actor status, for every caller"
