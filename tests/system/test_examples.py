"""The numbered examples do what they say, in every pairing of languages and media."""

from __future__ import annotations

import csv
import re
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import gecos
import pytest
from processes import Laboratory, Program, until
from robcl.manipulator import Manipulator
from robcl.puma560 import Puma560
from robcl.world import World

GECOS = [sys.executable, "-m", "gecos.cli"]
PRESENCE_ENDS_S = 0.25
"""Promised: from the loss of presence until the commands end."""
SLACK = 5
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
README = (EXAMPLES / "README.md").read_text(encoding="utf-8")


def read_distance(lab: Laboratory, language: str, role: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "examples" / f"lds_{role}"]
    return [sys.executable, EXAMPLES / "01_read_distance" / f"{role}.py"]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_read_distance(server: str, client: str, medium: str, lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    lab.start(*read_distance(lab, server, "server"), ready="LASER")
    asked = lab.run(*read_distance(lab, client, "client"), medium)
    assert asked.finish() == 0, str(asked)
    distance = re.fullmatch(r"(0\.\d{3}) m", asked.output())
    assert distance and 0.4 <= float(distance[1]) <= 0.6, str(asked)


@pytest.mark.parametrize("client", ["C++", "Python"])
def test_read_distance_without_a_server_says_what_is_missing(
    client: str, lab_with_broker: Laboratory
) -> None:
    asked = lab_with_broker.run(*read_distance(lab_with_broker, client, "client"))
    assert asked.finish() != 0
    assert "LASER" in asked.output() and "NO_SERVER" in asked.output(), str(asked)
    assert "Traceback" not in asked.output(), str(asked)


def grip_block(lab: Laboratory, language: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "examples" / "grip_block"]
    return [sys.executable, EXAMPLES / "02_grip_block" / "grip_block.py"]


@pytest.mark.parametrize("language", ["C++", "Python"])
def test_grip_block_says_what_it_takes(language: str, lab: Laboratory) -> None:
    helped = lab.run(*grip_block(lab, language), "--help")
    assert helped.finish() == 0, str(helped)
    assert "usage: grip_block" in helped.output()
    assert "lifts it by 200 mm" in helped.output() and "--leave" in helped.output()

    refused = lab.run(*grip_block(lab, language), "--lift")
    assert refused.finish() == 2, str(refused)
    assert "--lift" in refused.output() and "usage: grip_block" in refused.output()


@pytest.mark.usefixtures("fast_clock")
@pytest.mark.parametrize("medium", ["shm", "lcm"])
@pytest.mark.parametrize("language", ["C++", "Python"])
def test_grip_block_over_each_medium(
    language: str, medium: str, lab_with_devices: Laboratory
) -> None:
    lab = lab_with_devices
    gripped = lab.run(*grip_block(lab, language), medium)
    assert gripped.finish() == 0, str(gripped)
    assert gripped.lines[-1] == "lift: FINISHED", str(gripped)


@pytest.mark.usefixtures("here", "fast_clock")
@pytest.mark.parametrize("language", ["C++", "Python"])
def test_grip_block_moves_a_puma_that_is_served_under_another_name(
    language: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    devices = lab.build / "devices"
    lab.start(devices / "world" / "robcl-world", ready="ready")
    lab.start(devices / "puma560" / "robcl-puma560", "--name", "SIM", ready="ready")
    lab.start(devices / "gripper" / "robcl-gripper", "--carrier", "SIM", ready="ready")
    here = gecos.Lab()
    world = here.create(World, "WORLD")
    before = world.find("BLOCK").result().pose.z

    gripped = lab.run(*grip_block(lab, language))
    assert gripped.finish() == 0, str(gripped)
    assert gripped.lines[-1] == "lift: FINISHED", str(gripped)
    lifted = world.find("BLOCK").result().pose.z - before
    assert lifted == pytest.approx(0.2, abs=1e-3)
    assert here.create(Puma560, "SIM").joints().result().position[4] < 0, "the wrist is not turned"


LANGUAGES = pytest.mark.parametrize("language", ["C++", "Python"])


@pytest.fixture(scope="module")
def own_python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the modules `oven` and `cart`, which 07, 08, 14 and 15 import."""
    out = tmp_path_factory.mktemp("own")
    for own in ("07_own_interface/oven.gidl", "14_feed_a_command/cart.gidl"):
        subprocess.run(
            [sys.executable, "-m", "gidl", "gen", "--lang", "python", "--out", out, EXAMPLES / own],
            check=True,
            stdout=subprocess.DEVNULL,
        )
    return out / "python"


def example(lab: Laboratory, folder: str, program: str, language: str) -> list[str | Path]:
    if language == "C++":
        return [lab.build / "examples" / program]
    return [sys.executable, EXAMPLES / folder / f"{program}.py"]


def carried_out(program: Program) -> list[str]:
    """The lines of a program that ended well."""
    assert program.finish() == 0, str(program)
    return program.lines


@LANGUAGES
def test_corners_are_rounded_by_what_their_speed_and_acceleration_say(
    language: str, lab_with_arm: Laboratory
) -> None:
    printed = carried_out(
        lab_with_arm.run(*example(lab_with_arm, "18_round_corners", "round_corners", language))
    )
    standing, rounding = (re.fullmatch(r"(\w+): ([\d.]+) s, .* (\[.*\])", line) for line in printed)
    assert standing and standing.group(1, 3) == ("BREAK", "[]")
    # At a right angle: sqrt(2) v²/8a with .25 m/s and 3 m/s².
    assert rounding and rounding.group(1, 3) == ("NOBREAK", "['3.7', '3.7', '3.7']")
    assert float(rounding[2]) < float(standing[2])


@LANGUAGES
def test_progress_rises_until_a_third_is_done_and_the_move_is_canceled(
    language: str, lab_with_arm: Laboratory
) -> None:
    lab = lab_with_arm
    *reports, end = carried_out(
        lab.run(*example(lab, "03_progress_and_cancel", "progress_and_cancel", language))
    )
    read = [
        re.fullmatch(r"(?:EXECUTING|CANCELING) (\d+) ?%, (\S+) s left", line) for line in reports
    ]
    assert read and all(read), reports
    done = [int(report[1]) for report in read if report]
    left = [float(report[2]) for report in read if report]
    assert done == sorted(done) and left == sorted(left, reverse=True), reports
    assert done[-1] >= 33 and left[-1] > 0, reports
    assert end == "COMMAND_FAILED/CANCELED"


@LANGUAGES
def test_awaited_sequences_go_on_side_by_side(language: str, lab_with_devices: Laboratory) -> None:
    lab = lab_with_devices
    lines = carried_out(lab.run(*example(lab, "04_await", "await", language)))
    for device, steps in {
        "arm": ["at its start", "lowered"],
        "gripper": ["90 mm", "50 mm"],
    }.items():
        assert [line for line in lines if line.startswith(device)] == [
            f"{device}: {s}" for s in steps
        ]
    assert lines[-1] == "arm: lowered", "the arm takes 2 s longer, and nobody waited for it"


@LANGUAGES
def test_newest_samples_show_the_tool_going_down(language: str, lab_with_arm: Laboratory) -> None:
    lab = lab_with_arm
    lines = carried_out(lab.run(*example(lab, "05_stream_newest", "stream_newest", language)))
    shape = r"tool at (\S+) mm, (\S+) ms ago; (\d+) samples skipped"
    read = [re.fullmatch(shape, line) for line in lines]
    assert len(read) >= 2 and all(read), lines
    heights = [float(sample[1]) for sample in read if sample]
    assert all(after < before + 1 for before, after in pairwise(heights))
    assert 149 < heights[-1] < heights[0] - 10 < 241, lines
    assert all(float(sample[2]) >= 0 for sample in read if sample)
    assert all(int(sample[3]) > 0 for sample in read[1:] if sample), "it looks 5 times a second"


@LANGUAGES
def test_a_recording_has_each_sample_once_and_knows_how_many_are_missing(
    language: str, lab_with_arm: Laboratory, tmp_path: Path
) -> None:
    lab, path = lab_with_arm, tmp_path / "tool.csv"
    command = example(lab, "06_stream_record", "stream_record", language)
    lines = carried_out(lab.run(*command, path))
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 250
    numbers = [int(row["sequence"]) for row in rows]
    lost = [int(row["lost"]) for row in rows]
    assert [b - a - 1 for a, b in pairwise(numbers)] == lost[1:]
    assert lines == [f"250 samples, {sum(lost)} lost"]
    assert len({row["x"] for row in rows}) > 1, "encoders are noisy"
    assert all(abs(float(row["z"]) - float(rows[0]["z"])) < 0.01 for row in rows)


@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_an_interface_of_ones_own_is_used_and_served(
    server: str, client: str, lab_with_broker: Laboratory, own_python: Path
) -> None:
    lab = lab_with_broker
    lab.env["PYTHONPATH"] = str(own_python)
    lab.start(*example(lab, "08_serve", "serve_oven", server), ready="serving OVEN")
    outside, refused, heated = carried_out(
        lab.run(*example(lab, "07_own_interface", "use_oven", client))
    )
    assert "heat.to" in outside and "[293.0, 500.0]" in outside
    assert refused == "480 K: this oven goes up to 450 K"
    assert heated == "350 K: the oven is at 350 K"


@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_a_command_is_fed_by_a_stream_and_ends_when_no_sample_comes(
    server: str, client: str, lab_with_broker: Laboratory, own_python: Path
) -> None:
    lab = lab_with_broker
    lab.env["PYTHONPATH"] = str(own_python)
    lab.start(*example(lab, "14_feed_a_command", "serve_cart", server), ready="serving CART")
    outside, driven, used = carried_out(
        lab.run(*example(lab, "14_feed_a_command", "feed_cart", client))
    )
    assert "speed" in outside and "0.5" in outside, outside
    way = re.fullmatch(r"driven to (\d\.\d\d) m", driven)
    assert way and 0.05 < float(way[1]) < 0.5, driven
    counts = re.fullmatch(r"(\d+) of 50 speeds were used, (\d+) were replaced by newer ones", used)
    assert counts and int(counts[1]) > 0, used


@pytest.mark.parametrize("client", ["C++", "Python"])
@pytest.mark.parametrize("server", ["C++", "Python"])
def test_events_are_heard_while_a_command_runs(
    server: str, client: str, lab_with_broker: Laboratory, own_python: Path
) -> None:
    lab = lab_with_broker
    lab.env["PYTHONPATH"] = str(own_python)
    lab.start(*example(lab, "14_feed_a_command", "serve_cart", server), ready="serving CART")
    heard = carried_out(lab.run(*example(lab, "15_hear_events", "hear_bumps", client)))
    assert heard == [f"bumped at {end} m; 0 bumps were missed" for end in ("+0.5", "-0.5")]


@LANGUAGES
def test_two_programs_share_a_robot_by_a_password(language: str, lab_with_arm: Laboratory) -> None:
    lab = lab_with_arm
    command = example(lab, "09_share_by_password", "share_by_password", language)
    first = lab.start(*command, "two hands", ready="may move RX90: 1", listens=True)
    second = lab.start(*command, "two hands", ready="may move RX90: 2", listens=True)
    for program, word in [(first, "up"), (second, "down"), (first, "down"), (second, "up")]:
        program.tell(word)
        program.wait_for(f"{word}: done")

    stranger = lab.run(*command, "third hand")
    assert stranger.finish() != 0
    assert f"pid {first.pid}" in stranger.output(), f"it is told who has RX90: {stranger}"
    assert "Traceback" not in stranger.output()

    first.end_of_input()
    assert first.finish() == 0, str(first)
    second.tell("down")
    second.wait_for("down: done")
    second.end_of_input()
    assert second.finish() == 0, str(second)


@pytest.mark.parametrize("guards", ["C++", "Python"])
@pytest.mark.parametrize("movers", ["C++", "Python"])
def test_a_guard_takes_over_retreats_and_gives_back(
    movers: str, guards: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    devices = lab.build / "devices"
    lab.start(devices / "world" / "robcl-world", ready="ready")
    lab.start(devices / "rx90" / "robcl-rx90", ready="ready")
    lab.start(devices / "laser_distance_sensor" / "robcl-lds", ready="ready")
    mount = re.search(r"^gecos call LDS mount '(.*)'$", README, re.MULTILINE)
    assert mount is not None
    mounted = lab.run(*GECOS, "call", "LDS", "mount", mount[1])
    assert mounted.finish() == 0, str(mounted)
    mover_command = example(lab, "19_two_programs_one_robot", "lower_tool", movers)
    guard_command = example(lab, "19_two_programs_one_robot", "guard", guards)

    mover = lab.start(*mover_command, "two hands", ready="lowering the tool")
    guard = lab.start(*guard_command, "two hands", ready="watching", listens=True)
    roster = lab.start(*GECOS, "watch", "RX90", ready="held for")
    taken = guard.wait_for("taken over at ")
    preempted = mover.wait_for("PREEMPTED")
    assert f"pid {guard.pid}" in preempted, preempted
    held_off = mover.wait_for("DENIED")
    assert f"pid {guard.pid}" in held_off and "is held off" in held_off, held_off
    assert f"pid {guard.pid}" in roster.wait_for("has taken over")
    refusals = {(): "no password was given", ("third hand",): "the given password is wrong"}
    for given, why in refusals.items():
        stranger = lab.run(*mover_command, *given)
        assert stranger.finish() != 0
        assert f"it is shared by password, and {why}" in stranger.output()
        assert f"pid {guard.pid}" in stranger.output() and "took over" in stranger.output()
        assert "Traceback" not in stranger.output()

    guard.tell("")
    assert guard.finish() == 0, str(guard)
    assert mover.finish() == 0, str(mover)
    assert mover.lines[-1] == "at the start again"
    assert f"pid {guard.pid}" in roster.wait_for("has given back")
    for program in (guard, mover):
        assert roster.wait_for(f"pid {program.pid}) ended after").endswith(": released")
    near, far = (int(line.split()[-2]) for line in (taken, guard.lines[-1]))
    assert near <= 200 < far, (near, far)


@LANGUAGES
def test_the_arm_stands_when_the_button_of_a_person_is_released(
    language: str, lab_with_broker: Laboratory, tmp_path: Path, here: None
) -> None:
    lab = lab_with_broker
    (tmp_path / "lab.toml").write_text('[objects.RX90]\nzone = "CELL"\n')
    lab.env["GECOS_LAB_FILE"] = str(tmp_path / "lab.toml")
    lab.start(lab.build / "devices/zone/robcl-zone", "--buttons", "BUTTON", ready="ready")
    lab.start(lab.build / "devices/rx90/robcl-rx90", ready="ready")
    mover_command = example(lab, "19_two_programs_one_robot", "lower_tool", language)
    refused = lab.run(*mover_command)
    assert refused.finish() == 1
    assert "was not started: nobody is known to be present in zone CELL" in str(refused)
    assert "Traceback" not in str(refused)

    button_command = example(lab, "19_two_programs_one_robot", "hold_button", language)
    button = lab.start(*button_command, ready="the button is held", listens=True)
    presence = lab.start(*GECOS, "watch", "CELL", "presence", "--json", ready='"present": true')
    roster = lab.start(*GECOS, "watch", "RX90", ready="nobody holds")
    with gecos.Lab() as client:
        arm = client.create(Manipulator, "RX90")
        until(
            lambda: "a person is present in zone" in gecos.describe(arm).result().presence,
            "present",
        )
        bound = PRESENCE_ENDS_S + arm.braking_time().result()
        mover = lab.start(*mover_command, ready="lowering the tool")
        until(lambda: not arm.standing().result(), "the arm moves")
        button.tell("")
        assert button.finish() == 0, str(button)
        released_at = time.monotonic()
        until(lambda: arm.standing().result(), "the arm stands")
        assert time.monotonic() - released_at < SLACK * bound
    assert "BUTTON" in mover.wait_for("PRESENCE_LOST")
    assert mover.finish() == 1, str(mover)
    assert mover.lines[-1] != "at the start again", "nothing resumes"
    presence.wait_for('"present": false')
    roster.wait_for(f"pid {mover.pid}) has actor status")
    assert roster.wait_for(f"pid {mover.pid}) ended after").endswith(": released")


@LANGUAGES
def test_a_button_without_a_zone_or_owner_ends_with_one_line(
    language: str, lab_with_broker: Laboratory, tmp_path: Path
) -> None:
    lab = lab_with_broker
    button = example(lab, "19_two_programs_one_robot", "hold_button", language)
    (line,) = ended_with_one_line(lab.run(*button))
    assert line.startswith("CELL: NO_SERVER: ")
    (tmp_path / "lab.toml").write_text('[objects.CELL.sources]\nBUTTON = "door@gate"\n')
    lab.env["GECOS_LAB_FILE"] = str(tmp_path / "lab.toml")
    lab.start(lab.build / "devices/zone/robcl-zone", "--buttons", "BUTTON", ready="ready")
    (line,) = ended_with_one_line(lab.run(*button))
    assert "DENIED" in line and "binds this source to user door of host gate" in line


def ended_with_one_line(program: Program) -> list[str]:
    assert program.finish() == 1, str(program)
    return program.output().splitlines()


@LANGUAGES
def test_a_stop_by_somebody_else_ends_the_move_and_the_lease(
    language: str, lab_with_arm: Laboratory
) -> None:
    lab = lab_with_arm
    move, following, again = carried_out(lab.run(*example(lab, "10_stop", "stop", language)))
    assert re.match(r"the move: \S*STOPPED: .*by", move), move
    assert re.match(r"the next: \S*STOPPED: .*issued under a status that has ended", following)
    assert again == "with a new lease: FINISHED"


@LANGUAGES
def test_a_deadline_ends_the_motion_and_patience_does_not(
    language: str, lab_with_arm: Laboratory
) -> None:
    lab = lab_with_arm
    late, never, patient, end = carried_out(
        lab.run(*example(lab, "11_deadlines", "deadlines", language))
    )
    assert re.match(r"deadline of 0.5 s: \S*TIMED_OUT: ", late), late
    assert re.match(r"deadline of 0(\.0)? s: \S*EXPIRED: ", never), never
    assert patient == "patience of 0.5 s: RUNNING"
    assert end == "in the end: FINISHED"


@LANGUAGES
def test_an_arm_is_found_again_after_its_server_was_killed(
    language: str, lab_with_broker: Laboratory
) -> None:
    lab = lab_with_broker
    watching = lab.start(*example(lab, "12_find_again", "find_again", language))
    watching.wait_for("not found: RX90")
    for _ in range(2):
        arm = lab.start(lab.build / "devices/rx90/robcl-rx90", ready="ready")
        watching.wait_for("found: the tool is at (")
        arm.kill()
        watching.wait_for("lost")
    watching.wait_for("not found: RX90")
    watching.signal(signal.SIGTERM)
    assert watching.finish() == -signal.SIGTERM


@LANGUAGES
def test_several_devices_work_at_once(language: str, lab_with_devices: Laboratory) -> None:
    lab = lab_with_devices
    lines = carried_out(lab.run(*example(lab, "13_several_devices", "several_devices", language)))
    assert sorted(lines) == ["look has ended", "lower has ended", "open has ended"]
    assert lines[-1] == "lower has ended", "it takes 2 s; the others did not wait for it"
