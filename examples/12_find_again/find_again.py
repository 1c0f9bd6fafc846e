"""Watches the tool of an arm, whenever the arm is there: start, end and kill `robcl-rx90` as you
like. Ctrl-C ends this program."""

import gecos
from robcl.manipulator import Manipulator


def main() -> None:
    lab = gecos.Lab()
    # A proxy does not outlive the server that it was created for: the stream creates a new one.
    tool = gecos.ReconnectingStream(lab, Manipulator, "RX90", lambda robot: robot.tool.stream())
    found = False
    while True:
        try:
            sample = tool.next(timeout=1.0)  # use each sample here
        except (TimeoutError, gecos.CreateError) as missing:
            print("lost" if found else f"not found: {missing}", flush=True)
            found = False
            continue
        if not found:
            print(f"found: the tool is at {sample.value}", flush=True)
        found = True


if __name__ == "__main__":
    main()
