"""A short command imports only what it needs, because imports take most of its time."""

from __future__ import annotations

import os
import subprocess
import sys

import gecos
from robcl.frames import Frame
from robcl.laser_distance_sensor import Distance, LaserDistanceSensorServant

CODE = """
import sys
from gecos.cli import main

code = main()
print(*sorted(sys.modules), file=sys.stderr)
sys.exit(code)
"""
# Only other commands, or failures, need these modules. Each takes milliseconds to import.
SLOW = {"asyncio", "difflib", "numpy", "pathlib", "rich", "subprocess", "tomllib", "traceback"}
OTHERS = {"gecos.cli.report", "gecos.cli.up", "gecos.laboratory", "gecos.reader", "gecos.server"}


class Sensor(LaserDistanceSensorServant):
    def parent(self) -> str:
        return ""

    def mount(self, carrier: str, offset: Frame) -> None: ...

    def base(self) -> Frame:
        return Frame()

    def beam(self) -> Distance:
        return self.measure()

    def measure(self) -> Distance:
        return Distance(value=0.25, valid=True)

    def power(self, on: bool) -> None: ...


def test_a_call_imports_only_what_it_needs(lab: gecos.Lab) -> None:
    with gecos.Server(lab) as server:
        server.add("LDS", Sensor(), simulated=True)
        called = subprocess.run(
            [sys.executable, "-S", "-c", CODE, "call", "LDS", "measure", "--json"],
            env=os.environ | {"PYTHONPATH": ":".join(filter(None, sys.path))},
            capture_output=True,
            text=True,
        )
    assert called.returncode == 0, called.stderr
    assert '"value": 0.25' in called.stdout
    modules = set(called.stderr.split())
    assert "gecos.dynamic_client" in modules
    assert not modules & (SLOW | OTHERS)
