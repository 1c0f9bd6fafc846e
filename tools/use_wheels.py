"""Tests the wheels gidl and robcl without the rest of the tree, from a .gidl file to a call.

tools/wheels.sh runs this script in an empty folder, with the interpreter of an environment in which
the two wheels are installed.
"""

import importlib
import os
import subprocess
import sys
from pathlib import Path

COMMANDS = Path(sys.executable).parent
OVEN = """\
#include "robcl/device.gidl"
module kitchen {
  interface Oven : robcl::Device { @sensor readonly attribute double warmth; };
};
"""


def run(*words: str) -> str:
    done = subprocess.run([COMMANDS / words[0], *words[1:]], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"wheels: {' '.join(words)} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout


def import_everything() -> None:
    for name in ("gidl.cli.main", "gecos", "gecos._core", "gecos.wire.plans", "gecos_idl.broker",
                 "robcl.gripper", "robcl.frames"):  # fmt: skip
        module = importlib.import_module(name)
        assert module.__file__ and Path(module.__file__).is_relative_to(sys.prefix), module
    from gecos.wire import plans
    from robcl.frames import Frame, mm, translate

    assert plans.COMPILED
    assert (Frame() * translate(0.0, 0.0, mm(200))).inverse() is not None


def build_on_an_interface_of_robcl() -> None:
    """Checks that `gidl` finds robcl/device.gidl in the wheel robcl, without an option -I."""
    Path("kitchen").mkdir()
    Path("kitchen/oven.gidl").write_text(OVEN)
    run("gidl", "gen", "-I", ".", "--lang", "python", "--out", "kitchen-out", "kitchen/oven.gidl")
    sys.path.insert(0, "kitchen-out/python")
    oven = importlib.import_module("kitchen.oven")
    from robcl.device import Device

    assert issubclass(oven.Oven, Device)


def serve_and_call() -> None:
    """Serves the device that `gidl new` writes in another process, and calls it from this one."""
    os.environ["GECOS_RUNTIME_DIR"] = os.environ["GECOS_KEY_DIR"] = str(Path.cwd())
    os.environ["GECOS_AUDIT_DIR"] = str(Path.cwd() / "audit")
    run("gidl", "new", "thermometer")
    os.chdir("thermometer")
    run("gidl", "gen")
    sys.path.insert(0, "generated/python")
    import gecos

    thermometer = importlib.import_module("lab.thermometer")
    with gecos.Lab() as lab, gecos.Broker(lab):
        server = subprocess.Popen(
            [sys.executable, "server.py"],
            env={**os.environ, "PYTHONPATH": "generated/python"},
            stdout=subprocess.PIPE,
        )
        assert server.stdout is not None
        server.stdout.readline()  # it serves
        try:
            proxy = lab.create(thermometer.Thermometer, "THERMOMETER")
            with gecos.actor(proxy):
                proxy.set_target(21.5).result()
            assert proxy.reading().result() == 21.5
            assert "THERMOMETER" in run("gecos", "ls")
        finally:
            server.terminate()
            server.communicate()


if __name__ == "__main__":
    import_everything()
    build_on_an_interface_of_robcl()
    serve_and_call()
    print("wheels: gidl and robcl work where the tree is not known")
