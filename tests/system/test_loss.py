"""What happens to a command when its server dies, and to a robot when its holder dies."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import gecos
import pytest
from lab.rail_sensor import RailSensor
from processes import PATIENCE_S, Laboratory, Program, until
from robcl.manipulator import Manipulator
from robcl.six_axis import SixAxis

HERE = Path(__file__).parent
GRACE_S = 1.0  # default of LabOptions.grace
SILENCE_S = 0.5  # default of LabOptions.lease_ttl
SLACK = 5.0  # how much longer than promised real processes may take on a busy machine


def riding(
    lab: Laboratory, server: list[str | Path], medium: str
) -> tuple[Program, RailSensor, gecos.Lease, gecos.Command[None]]:
    served = lab.start(*server, ready="serving RAIL")
    rail = gecos.Lab().create(RailSensor, "RAIL", medium=medium)
    lease = gecos.actor(rail)
    ride = rail.travel(1.0)
    until(lambda: ride.progress().fraction > 0.0, "the ride is under way")
    return served, rail, lease, ride


@pytest.fixture(params=["C++", "Python"])
def rail_server(request: pytest.FixtureRequest, build: Path) -> list[str | Path]:
    if request.param == "C++":
        return [build / "tests" / "system" / "rail" / "rail_server"]
    return [sys.executable, HERE / "rail" / "server.py"]


@pytest.mark.usefixtures("here")
class TestServerKilled:
    def test_over_shm_the_move_is_server_crashed_at_once(
        self, lab_with_broker: Laboratory, rail_server: list[str | Path]
    ) -> None:
        server, rail, _lease, ride = riding(lab_with_broker, rail_server, "shm")
        began = time.monotonic()
        server.kill()
        assert ride.wait(PATIENCE_S) is gecos.State.COMMAND_FAILED
        assert ride.progress().detail is gecos.Detail.SERVER_CRASHED
        assert time.monotonic() - began < GRACE_S, "a death that the kernel reports does not wait"
        with pytest.raises(gecos.ConnectionFailed):
            rail.measure().result()

    def test_over_lcm_the_outcome_is_unknown_after_grace(
        self, lab_with_broker: Laboratory, rail_server: list[str | Path]
    ) -> None:
        server, rail, _lease, ride = riding(lab_with_broker, rail_server, "lcm")
        began = time.monotonic()
        server.kill()
        until(lambda: ride.progress().detail is gecos.Detail.UNREACHABLE, "the silence is noticed")
        assert ride.state is gecos.State.RUNNING
        assert ride.wait(PATIENCE_S) is gecos.State.COMMAND_FAILED
        assert ride.progress().detail is gecos.Detail.OUTCOME_UNKNOWN
        took = time.monotonic() - began
        assert GRACE_S <= took <= SLACK * (SILENCE_S + GRACE_S)
        with pytest.raises(gecos.ConnectionFailed):
            rail.measure().result()


@pytest.mark.usefixtures("here", "lab_with_devices")
@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_a_stream_that_has_ended_gives_no_sample_when_its_server_goes_on(medium: str) -> None:
    lab = gecos.Lab()
    joints = lab.create(SixAxis, "RX90", medium=medium).joints.stream()
    joints.next(PATIENCE_S)
    (server,) = (one.pid for one in lab.objects() if one.name == "RX90")
    os.kill(server, signal.SIGSTOP)
    with pytest.raises(gecos.StreamLost):
        while joints.next(PATIENCE_S):
            pass
    last = joints.history()[-1].stamp
    os.kill(server, signal.SIGCONT)
    others = gecos.Lab().create(SixAxis, "RX90", medium=medium, wait=PATIENCE_S).joints.stream()
    for _ in range(100):
        assert others.next(PATIENCE_S), "the server publishes again"
        with pytest.raises(gecos.StreamLost):
            joints.next(0.0)
        assert all(sample.stamp <= last for sample in joints.history())


@pytest.mark.usefixtures("here")
class TestHolderOfTheRobot:
    def holder(self, lab: Laboratory) -> Program:
        program = lab.start(sys.executable, HERE / "programs" / "hold.py")
        program.wait_for("moving")
        return program

    def test_a_second_program_is_refused_and_told_who_holds_it(
        self, lab_with_devices: Laboratory
    ) -> None:
        holder = self.holder(lab_with_devices)
        robot = gecos.Lab().create(Manipulator, "RX90")
        with pytest.raises(gecos.LeaseRefused) as refused:
            gecos.actor(robot)
        assert [held.pid for held in refused.value.holders] == [holder.pid]
        assert str(holder.pid) in str(refused.value)
        with pytest.raises(gecos.CommandFailed) as denied:
            robot.move(robot.tool().result()).result()
        assert denied.value.detail is gecos.Detail.DENIED

    def test_when_it_is_killed_the_status_is_free_and_the_arm_stands(
        self, lab_with_devices: Laboratory
    ) -> None:
        holder = self.holder(lab_with_devices)
        arm = gecos.Lab().create(SixAxis, "RX90")
        holder.kill()

        def free() -> bool:
            return not gecos.holders(arm).result()

        assert until(free, "the status is free") < SLACK * SILENCE_S
        until(lambda: not gecos.describe(arm).result().executing, "the move has ended")
        joints = arm.joints.stream()
        first = joints.next(2.0)
        for _ in range(50):
            later = joints.next(2.0)
        assert first is not None and later is not None
        moved = max(abs(first.value.position - later.value.position))
        assert moved < 2e-4, "noise of the encoders, but no motion"
        gecos.actor(arm).release()

    def test_a_third_program_can_stop_it(self, lab_with_devices: Laboratory) -> None:
        holder = self.holder(lab_with_devices)
        stopped = lab_with_devices.run(sys.executable, "-m", "gecos.cli", "stop", "RX90")
        assert stopped.finish() == 0, str(stopped)
        assert "COMMAND_FAILED/STOPPED" in holder.wait_for("ended")


@pytest.mark.usefixtures("here")
def test_create_falls_through_with_a_reason_per_name(lab_with_devices: Laboratory) -> None:
    lab = gecos.Lab()
    with pytest.raises(gecos.CreateError) as nothing:
        lab.create(Manipulator, ["PUMA", "GRIPPER"])
    puma, gripper = nothing.value.attempts
    assert puma.name == "PUMA" and "RX90" in puma.reason, "names what is online"
    assert "robcl::Gripper" in gripper.reason and "robcl::Manipulator" in gripper.reason
    robot = lab.create(Manipulator, ["PUMA", "GRIPPER", "RX90"])
    assert gecos.describe(robot).result().name == "RX90"
