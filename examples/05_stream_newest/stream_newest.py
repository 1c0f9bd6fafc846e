"""Watches the tool while the arm lifts it. The arm publishes 250 samples a second; this program
looks five times a second, and each time gets the newest one."""

import gecos
from robcl.frames import in_mm, mm, translate
from robcl.manipulator import Manipulator, Trajectory


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot):
        here = robot.tool().result()  # one value, by a call
        tool = robot.tool.stream()  # all values, as they are published

        slowly = Trajectory(tool_speed=0.05)  # m/s
        move = robot.move(translate(0.0, 0.0, mm(100)) * here, slowly)
        while move.wait(0.2) is gecos.State.RUNNING:
            newest = tool.latest()  # never waits; raises StreamLost once the server is lost
            if newest is None:
                continue
            print(
                f"tool at {in_mm(newest.value.z):.1f} mm, {1e3 * newest.age:.2f} ms ago; "
                f"{newest.lost} samples skipped",
                flush=True,
            )
        move.result()


if __name__ == "__main__":
    main()
