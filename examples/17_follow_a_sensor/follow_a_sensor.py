"""Guides the tool by corrections, as a sensor would: 500 steps of 0.1 mm down, one per ms."""

import time

import gecos
from robcl.frames import distance, mm, translate
from robcl.manipulator import CorrectionsStopped, FollowLimits, FollowMode, Manipulator


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot):
        alter = robot.alter.writer()
        before = robot.tool().result()
        follow = robot.follow(FollowMode.IN_TOOL, FollowLimits(distance=0.1))
        alter.feeds(follow)
        while follow.feedback() is None and follow.wait(0.001) is gecos.State.RUNNING:
            pass  # with the first feedback the arm takes corrections
        due = time.monotonic()
        for _ in range(500):
            alter.send(translate(0.0, 0.0, mm(0.1)))  # along the tool's z, down
            due += 0.001
            time.sleep(max(0.0, due - time.monotonic()))

        # Without corrections the arm stands at once, and the command ends by itself.
        try:
            follow.result()
        except CorrectionsStopped as stopped:
            state = stopped.state
            print(f"{state.applied} corrections, {state.dropped} dropped")
        print(f"moved by {distance(before, robot.tool().result()) * 1000:.1f} mm")


if __name__ == "__main__":
    main()
