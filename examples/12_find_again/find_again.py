"""Watches the tool of an arm, whenever the arm is there: start, end and kill `robcl-rx90` as you
like. Ctrl-C ends this program."""

import time

import gecos
from robcl.manipulator import Manipulator


def watch(robot: Manipulator) -> None:
    """Reads until the server is lost."""
    tool = robot.tool.stream()
    print(f"found: the tool is at {tool.next(timeout=5.0).value}", flush=True)
    for _ in tool:
        pass  # use each sample here


def main() -> None:
    lab = gecos.Lab()
    while True:  # a proxy does not outlive the server that it was created for: create a new one
        try:
            watch(lab.create(Manipulator, "RX90"))
        except gecos.CreateError as error:
            print(f"not found: {error}", flush=True)
            time.sleep(0.5)  # before the next try
        except (gecos.StreamLost, gecos.CommandFailed, gecos.ConnectionFailed):
            print("lost", flush=True)


if __name__ == "__main__":
    main()
