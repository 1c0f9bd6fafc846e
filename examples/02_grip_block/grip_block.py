"""The paper's program: a robot grips a block and lifts it by 200 mm.

`grip_block.py [--leave] [shm|lcm]`; with --leave it ends without waiting for the lift, as the
paper's does. The block is lifted all the same: status that is given back drains first.
"""

import argparse
import sys
from typing import TypeVar

import gecos
from robcl.frames import Frame, deg, mm, translate
from robcl.gripper import Gripper
from robcl.manipulator import Manipulator, PathType, Trajectory

# Where the robot stands and where the block is gripped, in the world. The grip frame's z axis is
# the direction in which the tool approaches, so it points down.
ROBOT_BASE = Frame()
BLOCK = Frame.from_euler_zyz(mm(500), mm(200), mm(50), 0.0, deg(180), 0.0)
ABOVE_BLOCK = BLOCK * translate(0.0, 0.0, -mm(200))


T = TypeVar("T")
F = TypeVar("F")


def follow(what: str, command: gecos.Command[T, F]) -> T:
    """Waits for a command and tells its states and how far it is."""
    told: gecos.Detail | None = None
    told_fraction = 0.0
    while True:
        now = command.progress()
        if now.detail != told or now.fraction >= told_fraction + 0.25:
            state = command.state
            print(f"{what}: {state.name}/{now.detail.name} {now.fraction:.0%}", flush=True)
            told, told_fraction = now.detail, now.fraction
        if command.wait(0.02) is not gecos.State.RUNNING:
            break
    result = command.result()
    print(f"{what}: {command.state.name}", flush=True)
    return result


def grip_and_lift(leave: bool, medium: str | None) -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, ["RX90", "SIM"], medium=medium)
    gripper = lab.create(Gripper, "GRIPPER", medium=medium)

    with gecos.actor(robot), gecos.actor(gripper):
        follow("mount", robot.mount("", ROBOT_BASE))

        # Approach and opening overlap: both are on their way before either is waited for.
        approach = robot.move(ABOVE_BLOCK)
        opening = gripper.open(mm(100))
        follow("open", opening)
        follow("approach", approach)

        slowly = Trajectory(speed=0.5, path=PathType.STRAIGHT)
        follow("go down", robot.move(BLOCK, slowly))
        follow("close", gripper.close(0.3 * gripper.max_force().result()))

        lift = robot.move(ABOVE_BLOCK, slowly)
        if leave:
            print("lift: left to the robot", flush=True)
        else:
            follow("lift", lift)


def main() -> None:
    parser = argparse.ArgumentParser(description="Grips a block and lifts it by 200 mm.")
    parser.add_argument(
        "--leave",
        action="store_true",
        help="end without waiting for the lift: the block is lifted all the same",
    )
    parser.add_argument(
        "medium",
        nargs="?",
        choices=["shm", "lcm"],
        help="medium to use, else the best for this host",
    )
    words = parser.parse_args()
    try:
        grip_and_lift(words.leave, words.medium)
    except (
        gecos.CreateError,
        gecos.CommandFailed,
        gecos.ConnectionFailed,
        gecos.LeaseRefused,
    ) as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
