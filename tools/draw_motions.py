"""Draws the pictures of docs/motion.md: runs the simulated RX90, moves it, and has `gecos plot`
draw each motion.

Two runs do not draw exactly the same picture, because the measured values have noise.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import gecos
from robcl.frames import Frame, mm, translate
from robcl.manipulator import Blend, Manipulator, PathType, Trajectory

TREE = Path(__file__).resolve().parent.parent
PICTURES = TREE / "docs" / "pictures"
STANDS = 0.2  # s for which a picture shows the arm before it moves, or a little less
ARM = TREE / "devices" / "arms" / "rx90.toml"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=Path("build"))
    build = parser.parse_args().build.resolve()
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        os.environ["GECOS_RUNTIME_DIR"] = folder
        os.environ["GECOS_BROKER"] = "shm"
        with (
            started("ready", build / "runtime/cpp/gecos/broker/gecos-broker"),
            started("ready", build / "devices/rx90/robcl-rx90"),
            gecos.Lab() as lab,
        ):
            robot = lab.create(Manipulator, "RX90")
            start = robot.tool().result()
            with gecos.actor(robot):
                for name, (before, move) in MOTIONS.items():
                    before(robot, start)
                    draw(name, lambda move=move: move(robot, start))  # type: ignore[misc]


def draw(name: str, move: Callable[[], None]) -> None:
    """Draws what the arm does in `move`."""
    picture = PICTURES / f"{name}.svg"
    words = ("plot", "RX90", "-o", picture, "--limits", ARM)
    with started("waits until", sys.executable, "-m", "gecos.cli", *words) as plot:
        time.sleep(STANDS)
        move()
        if plot.wait(60) != 0:
            sys.exit(f"draw_motions: gecos plot has not drawn {picture}")
    print(f"{picture.relative_to(TREE)}: {picture.stat().st_size / 1000:.0f} kB")


@contextmanager
def started(ready: str, *command: str | Path) -> Iterator[subprocess.Popen[str]]:
    """Starts a program, waits for a line with `ready`, and ends the program after the block."""
    program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert program.stdout is not None
    try:
        if not any(ready in line for line in program.stdout):
            sys.exit(f"draw_motions: {command[0]} ended before it was ready")
        yield program
    finally:
        program.terminate()
        program.wait()
        program.stdout.close()


LEFT, RIGHT = (translate(mm(550), mm(y), mm(500)) for y in (350, -350))


def stand_left(robot: Manipulator, start: Frame) -> None:
    robot.move(LEFT * turned(start)).result()


def turned(start: Frame) -> Frame:
    """Returns the frame `start`, moved to the origin of the world with the same orientation."""
    x, y, z = start.position
    return translate(-x, -y, -z) * start


def joints_then_straight(robot: Manipulator, start: Frame) -> None:
    """Moves the tool to the right by a joint move, and back to the left on a straight line."""
    robot.move(RIGHT * turned(start)).result()
    robot.move(LEFT * turned(start), Trajectory(path=PathType.STRAIGHT)).result()


def stand_at_start(robot: Manipulator, start: Frame) -> None:
    robot.move(start).result()


def square(at_corners: Blend) -> Callable[[Manipulator, Frame], None]:
    """Returns a motion along a square of 200 mm, whose four moves are requested at once."""

    def move(robot: Manipulator, start: Frame) -> None:
        corners = [(200, 0), (200, -200), (0, -200), (0, 0)]
        moves = []
        for number, (y, z) in enumerate(corners, 1):
            at_goal = at_corners if number < len(corners) else Blend.BREAK
            how = Trajectory(path=PathType.STRAIGHT, at_goal=at_goal, tool_speed=0.5)
            moves.append(robot.move(start * translate(0.0, mm(y), mm(z)), how))
        for each in moves:
            each.result()

    return move


def slowed_and_paused(robot: Manipulator, start: Frame) -> None:
    """Moves along a straight line while the speed is scaled to 40 %, then to 0, then to 100 %."""
    how = Trajectory(path=PathType.STRAIGHT, tool_speed=0.4)
    moving = robot.move(RIGHT * turned(start), how)
    for factor, until in ((0.4, 0.6), (0.0, 0.6), (1.0, 0.5)):
        time.sleep(until)
        robot.override_speed(factor).result()
    moving.result()


Move = Callable[[Manipulator, Frame], None]
MOTIONS: dict[str, tuple[Move, Move]] = {
    "joint-and-straight": (stand_left, joints_then_straight),
    "square-break": (stand_at_start, square(Blend.BREAK)),
    "square-nobreak": (stand_at_start, square(Blend.NOBREAK)),
    "override": (stand_left, slowed_and_paused),
}
"""For each picture, the motion that is made before it, and the motion that it shows."""


if __name__ == "__main__":
    main()
