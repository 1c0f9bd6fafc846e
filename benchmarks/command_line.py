"""How long one `gecos` takes, from the start of Python to its end, beside an empty Python.

Starts a broker and the simulated laser distance sensor in a laboratory of its own, and runs an
empty Python, `gecos --version`, `gecos get` and `gecos call` in turn. Shows medians of wall time.
120 ms are promised for the call of a sensor.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

TREE = Path(__file__).resolve().parents[1]
GECOS = [str(Path(sys.executable).with_name("gecos"))]
CANDIDATES = {
    "an empty Python": [sys.executable, "-c", "pass"],
    "gecos --version": [*GECOS, "--version"],
    "gecos get LDS beam": [*GECOS, "get", "LDS", "beam", "--json"],
    "gecos call LDS measure": [*GECOS, "call", "LDS", "measure", "--json"],
}
SERVERS = (  # below the build folder
    "runtime/cpp/gecos/broker/gecos-broker",
    "devices/world/robcl-world",
    "devices/laser_distance_sensor/robcl-lds",
)
LIMIT_MS = 120.0


def start(program: Path) -> subprocess.Popen[str]:
    """Starts a server and returns when it says that it is ready."""
    process = subprocess.Popen([program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for line in process.stdout:
        if "ready" in line:
            return process
    raise SystemExit(f"{program} ended before it was ready")


def seconds(command: list[str]) -> float:
    began = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures the start and end of `gecos`.")
    parser.add_argument("--build", type=Path, default=TREE / "build")
    parser.add_argument("--rounds", type=int, default=21)
    asked = parser.parse_args()
    with ExitStack() as running:
        place = running.enter_context(tempfile.TemporaryDirectory(prefix="gecos-"))
        os.environ["GECOS_RUNTIME_DIR"] = place
        os.environ.pop("GECOS_BROKER", None)
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # else every start compiles our sources
        for program in SERVERS:
            process = start(asked.build / program)
            running.callback(process.wait)
            running.callback(process.terminate)
        times: dict[str, list[float]] = {title: [] for title in CANDIDATES}
        for _ in range(asked.rounds):
            for title, command in CANDIDATES.items():
                times[title].append(seconds(command) * 1e3)
    print("| | median ms | fastest ms | slowest ms |\n|---|--:|--:|--:|")
    for title, each in times.items():
        print(f"| {title} | {statistics.median(each):.0f} | {min(each):.0f} | {max(each):.0f} |")
    called = statistics.median(times["gecos call LDS measure"])
    verdict = "met" if called < LIMIT_MS else "missed"
    print(f"\na call of a sensor: {called:.0f} ms, promised {LIMIT_MS:g} ms: {verdict}")


if __name__ == "__main__":
    main()
