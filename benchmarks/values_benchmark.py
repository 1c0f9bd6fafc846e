"""Generated Python beside LCM's Python and protobuf, in paired rounds: ratios within rounds.

python3 -m venv /tmp/peers && /tmp/peers/bin/pip install -r benchmarks/requirements.txt
/tmp/peers/bin/python benchmarks/values_benchmark.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import timeit
from collections.abc import Callable
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from statistics import median, quantiles
from typing import Any

TREE = Path(__file__).resolve().parent.parent
VALUES = TREE / "benchmarks" / "values"
ROUNDS = 501
BURST = 200e-6  # seconds, of each in each round


def generate(out: Path) -> None:
    """Our Python, lcm-gen's of the same interface, and protobuf's."""
    ours = [sys.executable, "-m", "gidl", "gen", "-I", VALUES, "-I", TREE / "idl", "--out", out]
    environment = {**os.environ, "PYTHONPATH": str(TREE / "codegen")}
    gidl = Path(TREE / ".venv" / "bin" / "python")
    ours[0] = gidl if gidl.exists() else sys.executable
    quiet = subprocess.DEVNULL
    subprocess.run([*ours, VALUES / "values.gidl"], check=True, env=environment, stdout=quiet)
    lcm_gen = Path(sys.executable).parent / "lcm-gen"
    lcm = [lcm_gen, "--python", "--ppath", out / "lcm", out / "lcm" / "values.lcm"]
    subprocess.run([*lcm, "--package-prefix", "theirs"], check=True, stdout=quiet)
    protoc = [sys.executable, "-m", "grpc_tools.protoc", f"-I{VALUES}", f"--python_out={out}"]
    subprocess.run([*protoc, VALUES / "values.proto"], check=True)
    sys.path[:0] = [str(TREE / "runtime/python"), *(str(out / f) for f in ("python", "lcm", ""))]


def show(what: str, calls: dict[str, Callable[[], object]]) -> None:
    """A row for each; the first is ours. Bursts of all take turns: a ratio is of one round."""
    timers = {name: timeit.Timer(call) for name, call in calls.items()}
    numbers = {}
    for name, timer in timers.items():
        number, took = timer.autorange()
        numbers[name] = max(1, int(BURST * number / took))
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, timer in timers.items():
            times[name].append(timer.timeit(numbers[name]) / numbers[name])
    ours = next(iter(times.values()))
    for name, each in times.items():
        ratios = [theirs / mine for theirs, mine in zip(each, ours, strict=True)]
        low, middle, high = quantiles(ratios, n=4)
        cells = f"{1e6 * median(each):.2f} | {middle:.2f} | {low:.2f} to {high:.2f}"
        print(f"| {what} | {name} | {cells} |")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        generate(Path(folder))
        import numpy as np
        from gecos import wire
        from google.protobuf.internal import api_implementation

        ours: Any = import_module("values_types")
        lcm: Any = import_module("theirs.values")
        proto: Any = import_module("values_pb2")
        proto_name = f"protobuf ({api_implementation.Type()})"
        print("| Python | | p50 µs | x ours | half of the rounds |\n|---|---|--:|--:|--:|")

        members = {"x": 0.1, "y": 0.2, "z": 0.3, "qw": 0.5, "qx": 0.5, "qy": -0.5, "qz": 0.5}
        pose, protos = ours.PoseOfNumbers(**members), proto.PoseOfNumbers(**members)

        def filled(message: Any) -> Any:  # LCM's constructor takes nothing
            message.x, message.y, message.z = 0.1, 0.2, 0.3
            message.qw, message.qx, message.qy, message.qz = 0.5, 0.5, -0.5, 0.5
            return message

        lcms = filled(lcm.PoseOfNumbers())
        read = attrgetter(*members)  # what is decoded is read
        raw, lcm_raw, proto_raw = wire.to_message(pose), lcms.encode(), protos.SerializeToString()
        assert raw == lcm_raw, "ours and LCM's are the same bytes"
        show(
            "make and encode pose",
            {
                "ours": lambda: wire.to_message(ours.PoseOfNumbers(**members)),
                "lcm": lambda: filled(lcm.PoseOfNumbers()).encode(),
                proto_name: lambda: proto.PoseOfNumbers(**members).SerializeToString(),
            },
        )
        show(
            "encode pose",
            {
                "ours": lambda: wire.to_message(pose),
                "lcm": lcms.encode,
                proto_name: protos.SerializeToString,
            },
        )
        show(
            "decode pose",
            {
                "ours": lambda: wire.from_message(ours.PoseOfNumbers, raw),
                "lcm": lambda: lcm.PoseOfNumbers.decode(lcm_raw),
                proto_name: lambda: proto.PoseOfNumbers.FromString(proto_raw),
            },
        )
        show(
            "decode and read pose",
            {
                "ours": lambda: read(wire.from_message(ours.PoseOfNumbers, raw)),
                "lcm": lambda: read(lcm.PoseOfNumbers.decode(lcm_raw)),
                proto_name: lambda: read(proto.PoseOfNumbers.FromString(proto_raw)),
            },
        )

        numbers = np.linspace(0, 1, 1000)
        doubles, protod = ours.Doubles(numbers), proto.Doubles(numbers=numbers.tolist())
        lcmd = lcm.Doubles()
        lcmd.numbers_n, lcmd.numbers = len(numbers), numbers.tolist()
        raw_d, lcm_d, proto_d = wire.to_message(doubles), lcmd.encode(), protod.SerializeToString()
        assert raw_d == lcm_d, "ours and LCM's are the same bytes"
        show(
            "encode 1000 doubles",
            {
                "ours": lambda: wire.to_message(doubles),
                "lcm": lcmd.encode,
                proto_name: lambda: proto.Doubles(numbers=numbers).SerializeToString(),
            },
        )
        show(
            "decode 1000 doubles",
            {
                "ours": lambda: wire.from_message(ours.Doubles, raw_d).numbers,
                "lcm": lambda: lcm.Doubles.decode(lcm_d).numbers,
                proto_name: lambda: np.array(proto.Doubles.FromString(proto_d).numbers),
            },
        )


if __name__ == "__main__":
    main()
