"""A device from nothing: what `gidl new` writes is generated, built, served and called."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from processes import Laboratory

TREE = Path(__file__).resolve().parents[2]


def run(*command: str | Path, cwd: Path) -> None:
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}:\n{done.stdout}{done.stderr}"


def test_a_new_thermometer_is_served_in_python_and_read_in_cpp(
    lab_with_broker: Laboratory, build: Path, tmp_path: Path
) -> None:
    run(sys.executable, "-m", "gidl", "new", "thermometer", cwd=tmp_path)
    folder = tmp_path / "thermometer"
    gen = ("gen", "-I", ".", "--lang", "python", "lab/thermometer.gidl")
    run(sys.executable, "-m", "gidl", *gen, cwd=folder)
    run("cmake", "-B", "build", "-G", "Ninja", f"-Drobcl_DIR={build}", cwd=folder)
    run("cmake", "--build", "build", cwd=folder)

    generated = str(folder / "generated" / "python")
    before = lab_with_broker.env.get("PYTHONPATH")
    lab_with_broker.env["PYTHONPATH"] = os.pathsep.join(filter(None, [generated, before]))
    lab_with_broker.start(sys.executable, folder / "server.py", ready="serving THERMOMETER")
    client = lab_with_broker.start(folder / "build" / "client")
    client.wait_for("it reads 20")
    client.wait_for("and now 21.5")
    assert client.finish() == 0
