"""A robot in a zone moves only while a person is known to be present, and stops when that is no
longer so: with real processes, on the shared memory of this host."""

from __future__ import annotations

import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import gecos
import pytest
from gecos_idl.presence import CheckInRefused, Zone
from processes import Laboratory, Program, until
from robcl.six_axis import Joints, SixAxis

GECOS = [sys.executable, "-m", "gecos.cli"]
TO_STOP_S = 0.25
"""Promised: from the loss of presence until the commands end."""
SLACK = 5


@pytest.fixture
def zone_program(lab_with_broker: Laboratory, tmp_path: Path) -> Program:
    """The zone CELL with the door DOOR, and RX90, which the lab file places there."""
    lab = lab_with_broker
    file = tmp_path / "lab.toml"
    file.write_text('[objects.RX90]\nzone = "CELL"\n')
    lab.env["GECOS_LAB_FILE"] = str(file)
    started = lab.start(
        lab.build / "devices" / "zone" / "robcl-zone", "--doors", "DOOR", ready="ready"
    )
    lab.start(lab.build / "devices" / "rx90" / "robcl-rx90", ready="ready")
    return started


@contextmanager
def closed_door(zone: Zone) -> Iterator[Callable[[], None]]:
    """The door DOOR, whose contact reports that it is closed until the function that is given opens
    it."""
    opened = threading.Event()

    def report() -> None:
        with suppress(gecos.CommandFailed, ConnectionError):  # the program of the zone has ended
            while not opened.wait(0.2):
                zone.report_door("DOOR", True).result()

    def open_it() -> None:
        opened.set()
        contact.join()
        zone.report_door("DOOR", False).result()

    contact = threading.Thread(target=report)
    zone.report_door("DOOR", True).result()
    contact.start()
    try:
        yield open_it
    finally:
        opened.set()
        contact.join()


def check_in(zone: Zone, program: Program) -> None:
    zone.show_code().result()
    shown = program.wait_for("the code of CELL is ")
    code = re.search(r"is (\w{6}),", shown)
    assert code is not None, shown
    with pytest.raises(CheckInRefused) as refused:
        zone.check_in("WRONG", "anna", 60.0).result()
    assert "is not the one that CELL shows in the laboratory" in str(refused.value)
    zone.check_in(code[1], "anna", 60.0).result()


def says(robot: SixAxis, text: str) -> None:
    until(lambda: text in gecos.describe(robot).result().presence, text)


def failure_of(command: gecos.Command[None]) -> gecos.CommandFailed:
    with pytest.raises(gecos.CommandFailed) as failed:
        command.result()
    assert failed.value.detail is gecos.Detail.PRESENCE_LOST, failed.value
    return failed.value


def test_an_arm_moves_while_a_person_is_present_and_stops_when_a_door_opens(
    zone_program: Program, here: None
) -> None:
    with gecos.Lab() as client:
        robot, zone = client.create(SixAxis, "RX90"), client.create(Zone, "CELL")
        at = robot.joints().result().position
        far = Joints([at[0] - 2.0, *at[1:]])
        with gecos.actor(robot), closed_door(zone) as open_door:
            says(robot, "no person has checked in")
            text = str(failure_of(robot.move_joints(far)))
            assert "was not started: nobody is known to be present in zone CELL" in text
            check_in(zone, zone_program)
            says(robot, "a person is present in zone CELL: anna has checked in")
            move = robot.move_joints(far)
            until(lambda: not robot.standing().result(), "the arm moves")

            open_door()
            lost_at = time.monotonic()
            text = str(failure_of(move))
            assert time.monotonic() - lost_at < SLACK * TO_STOP_S
            assert "DOOR is open or silent; close it; nothing resumes by itself" in text
            until(lambda: robot.standing().result(), "the arm stands")
            stopped_at = robot.joints().result().position[0]
            assert stopped_at > far.position[0] + 0.01, "it stopped on its way"
        with gecos.actor(robot), closed_door(zone):
            says(robot, "a person is present in zone CELL: ")
            assert robot.standing().result(), "nothing resumes"
            robot.move_joints(Joints(list(at))).result()


def test_an_arm_stops_when_the_program_of_its_zone_is_killed(
    zone_program: Program, here: None
) -> None:
    with gecos.Lab() as client:
        robot, zone = client.create(SixAxis, "RX90"), client.create(Zone, "CELL")
        at = robot.joints().result().position
        with gecos.actor(robot), closed_door(zone):
            check_in(zone, zone_program)
            says(robot, "a person is present in zone CELL: ")
            move = robot.move_joints(Joints([at[0] - 2.0, *at[1:]]))
            until(lambda: not robot.standing().result(), "the arm moves")
            zone_program.kill()
            assert "zone CELL" in str(failure_of(move))
            until(lambda: robot.standing().result(), "the arm stands")


def test_the_command_line_checks_in(lab_with_broker: Laboratory) -> None:
    lab = lab_with_broker
    zone = lab.start(lab.build / "devices" / "zone" / "robcl-zone", ready="ready")
    shown = lab.run(*GECOS, "call", "CELL", "show_code")
    assert shown.finish() == 0, str(shown)
    code = zone.wait_for("the code of CELL is ").split(" is ")[1][:6]
    words = ["check_in", f"code={code}", "person=anna", "stay=1800"]
    checked = lab.run(*GECOS, "call", "CELL", *words)
    assert checked.finish() == 0, str(checked)
    told = lab.run(*GECOS, "get", "CELL", "presence")
    assert told.finish() == 0, str(told)
    assert "anna has checked in" in told.output(), str(told)


def test_a_simulated_source_that_the_zone_does_not_have_is_refused(
    lab_with_broker: Laboratory,
) -> None:
    lab = lab_with_broker
    zone = lab.build / "devices" / "zone" / "robcl-zone"
    refused = lab.run(zone, "--doors", "DOOR", "--simulate", "GATE")
    assert refused.finish() == 1
    assert "the zone has no door or button 'GATE'" in str(refused)
