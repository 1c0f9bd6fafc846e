"""The whole system at work: broker and devices as processes, the block gripped and lifted twice.

Runs `02_grip_block` in C++ and then in Python, each in a laboratory of its own, and asks the
simulated world how high the block was before and after. Exits 0 exactly when it was lifted by
200 mm ± 1 mm both times. Everything it started is gone when it ends, also after Ctrl-C.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import gecos
from gecos.laboratory import LaboratoryDescription, LaboratoryError, Program, running
from robcl.device import Device
from robcl.frames import mm
from robcl.world import World

HERE = Path(__file__).resolve().parent
LIFT = mm(200)
TOLERANCE = mm(1)
# Below the build folder. The Makefile builds these alone for `make demo`.
SERVERS = (
    "runtime/cpp/gecos/broker/gecos-broker",
    "devices/zone/robcl-zone",
    "devices/world/robcl-world",
    "devices/rx90/robcl-rx90",
    "devices/gripper/robcl-gripper",
    "devices/laser_distance_sensor/robcl-lds",
)
ZONE = "CELL"
IN_ZONE = ("RX90", "GRIPPER")
OPTIONS = {"robcl-zone": ("--name", ZONE, "--doors", "DOOR", "--simulate", "DOOR,BUTTON",
                          "--buttons", "BUTTON")}  # fmt: skip
PROGRAM = "examples/grip_block"
PATIENCE_S = 60.0  # for the program to end


class DemoError(RuntimeError):
    """The demonstration did not show what it should; the text says why."""


def with_us(command: Sequence[str | Path]) -> list[str]:
    """The command, for a process that is asked to end when this one is killed (kill -9)."""
    return ["setpriv", "--pdeathsig", "TERM", "--", *map(str, command)]


def end(process: subprocess.Popen[bytes]) -> None:
    """Asks a process to end, insists after 5 s."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(5.0)
        except subprocess.TimeoutExpired:
            print(f"{process.args!r} does not end: killed", file=sys.stderr)
            process.kill()
    process.wait()


@contextmanager
def laboratory(build: Path, clock_speed: float | None) -> Iterator[None]:
    """Broker, world, devices and the zone in which the robot is, whose sources are simulated, as
    processes of their own; all gone when the block ends."""
    servers = [build / server for server in SERVERS]
    programs = tuple(
        Program(server.name, (str(server.resolve()), *OPTIONS.get(server.name, ())))
        for server in servers
    )
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        lab_file = Path(folder) / "lab.toml"
        lab_file.write_text("".join(f'[objects.{one}]\nzone = "{ZONE}"\n' for one in IN_ZONE))
        os.environ["GECOS_LAB_FILE"] = str(lab_file)
        os.environ["GECOS_RUNTIME_DIR"] = folder
        os.environ.pop("GECOS_BROKER", None)
        described = LaboratoryDescription(programs, starts_broker=False, clock_speed=clock_speed)
        with running(described):
            yield


def block_height(world: World) -> float:
    """m, as the simulated world says."""
    return world.find("BLOCK").result().pose.z


def await_presence(lab: gecos.Lab) -> None:
    """Returns when the servers in the zone know that a person is present. Prints what one says."""
    give_up = time.monotonic() + PATIENCE_S
    for name in IN_ZONE:
        device = lab.create(Device, name)
        while f"a person is present in zone {ZONE}" not in (
            said := gecos.describe(device).result().presence
        ):
            if time.monotonic() >= give_up:
                raise DemoError(f"{name} does not know that a person is present: {said}")
            time.sleep(0.02)
    print(f"presence: {said}", flush=True)


def lift(title: str, program: Sequence[str | Path], build: Path, clock_speed: float | None) -> None:
    """Runs one program in a laboratory of its own. Raises DemoError unless the block was lifted."""
    print(f"\n== {title}", flush=True)
    with laboratory(build, clock_speed), gecos.Lab() as lab:
        await_presence(lab)
        world = lab.create(World, "WORLD")
        before = block_height(world)
        process = subprocess.Popen(with_us(program), stdin=subprocess.DEVNULL)
        try:
            status = process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            raise DemoError(f"the program still runs after {PATIENCE_S} s") from None
        finally:
            end(process)
        after = block_height(world)
    lifted = after - before
    print(
        f"block: {1e3 * before:.2f} mm before, {1e3 * after:.2f} mm after: "
        f"lifted by {1e3 * lifted:.2f} mm",
        flush=True,
    )
    if status != 0:
        raise DemoError(f"the program ended with status {status}; its own words are above")
    if abs(lifted - LIFT) > TOLERANCE:
        raise DemoError(
            f"the block was lifted by {1e3 * lifted:.2f} mm; "
            f"{1e3 * LIFT:.0f} mm ± {1e3 * TOLERANCE:.0f} mm were asked"
        )


def interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def main() -> int:
    parser = argparse.ArgumentParser(description="Shows a block being gripped and lifted.")
    parser.add_argument("--build", type=Path, default=HERE.parent / "build", help="build folder")
    parser.add_argument("--medium", choices=["shm", "lcm"], help="medium (default: the best)")
    parser.add_argument(
        "--clock", type=float, help="simulated seconds that pass in a second (default: 1)"
    )
    words = parser.parse_args()
    for number in (signal.SIGTERM, signal.SIGHUP):  # the latter when a terminal is closed
        signal.signal(number, interrupt)

    medium = [words.medium] if words.medium else []
    cpp = words.build / PROGRAM
    python = HERE / "02_grip_block" / "grip_block.py"
    try:
        lift("02_grip_block in C++", [cpp, *medium], words.build, words.clock)
        command = [sys.executable, python, *medium]
        lift("02_grip_block in Python", command, words.build, words.clock)
    except (DemoError, LaboratoryError, gecos.CommandFailed, ConnectionError) as error:
        print(f"\ndemo: failed: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\ndemo: interrupted; everything it started is gone", file=sys.stderr)
        return 130
    print("\ndemo: the block was lifted by 200 mm, from C++ and from Python")
    return 0


if __name__ == "__main__":
    sys.exit(main())
