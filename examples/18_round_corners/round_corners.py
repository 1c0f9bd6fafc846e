"""Moves the tool along a square of 100 mm: first it stands at each corner, then it rounds them."""

import time

import gecos
from robcl.frames import mm, translate
from robcl.manipulator import Blend, Manipulator, MotionProgress, PathType, Trajectory

Move = gecos.Command[None, MotionProgress]


def along_square(robot: Manipulator, at_corners: Blend) -> list[Move]:
    """Asks for all moves at once: the arm looks ahead."""
    start = robot.tool().result()
    corners = [translate(0.0, mm(100), 0.0), translate(0.0, mm(100), mm(-100))]
    corners += [translate(0.0, 0.0, mm(-100))]

    def how(at_goal: Blend) -> Trajectory:
        return Trajectory(path=PathType.STRAIGHT, at_goal=at_goal, tool_speed=0.25)

    moves = [robot.move(start * corner, how(at_corners)) for corner in corners]
    return [*moves, robot.move(start, how(Blend.BREAK))]


def main() -> None:
    lab = gecos.Lab()
    robot = lab.create(Manipulator, "RX90")
    with gecos.actor(robot):
        for at_corners in (Blend.BREAK, Blend.NOBREAK):
            begun = time.monotonic()
            moves = along_square(robot, at_corners)
            for move in moves:
                move.result()
            took = time.monotonic() - begun
            passed = [f"{corner * 1000:.1f}" for move in moves if (corner := corner_of(move))]
            print(f"{at_corners.name}: {took:.1f} s, corners passed by mm: {passed}")


def corner_of(move: Move) -> float | None:
    """How far the tool passed the goal, in m; None if it stood there."""
    feedback = move.feedback()
    return feedback.corner if feedback else None


if __name__ == "__main__":
    main()
