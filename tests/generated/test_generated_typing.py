"""`mypy --strict` has nothing to say about generated Python, mocks included."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
FILES = {
    "everything": TREE / "tests" / "idl" / "everything.gidl",
    "workshop": TREE / "tests" / "idl" / "workshop" / "workshop.gidl",
    "rx90": TREE / "idl" / "robcl" / "rx90.gidl",
}


def test_generated_python_and_mocks_are_well_typed(tmp_path: Path) -> None:
    roots = (FILES["workshop"].parent, FILES["everything"].parent, TREE / "idl")
    search = [word for root in roots for word in ("-I", str(root))]
    gidl = [sys.executable, "-m", "gidl"]
    environment = {**os.environ, "PYTHONPATH": str(TREE / "codegen")}
    own = [str(FILES["everything"]), str(FILES["workshop"])]
    out = ["--lang", "python", "--out", str(tmp_path)]
    subprocess.run([*gidl, "gen", *out, *search, *own], check=True, env=environment)
    for name, file in FILES.items():
        mock = ["--mock", str(file), "--into", str(tmp_path / "mocks" / name)]
        subprocess.run([*gidl, "new", *mock, *search], check=True, env=environment)
        (tmp_path / "mocks" / name / "server.py").rename(tmp_path / "python" / f"mock_{name}.py")
    sources = [TREE / "runtime" / "python", TREE / "generated" / "python", tmp_path / "python"]
    judged = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases",
         "--config-file", os.devnull, "--cache-dir", str(tmp_path / "cache"),
         str(tmp_path / "python")],
        env={**os.environ, "MYPYPATH": os.pathsep.join(map(str, sources))},
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert judged.returncode == 0, judged.stdout + judged.stderr


PROGRAM = """\
import gecos
from gecos_idl.object_types import Holder
from robcl.rx90 import Rx90

arm: Rx90 = gecos.Lab().create(Rx90, "RX90")
holders: list[Holder] = gecos.holders(arm).result()
"""


def test_programs_that_import_the_installed_ones_are_checked(tmp_path: Path) -> None:
    """Without the markers of PEP 561 mypy would take all that is imported for Any, and say so."""
    (tmp_path / "program.py").write_text(PROGRAM)
    judged = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file", os.devnull,
         "--cache-dir", str(tmp_path / "cache"), str(tmp_path / "program.py")],
        cwd=tmp_path,
        env={name: value for name, value in os.environ.items() if name != "MYPYPATH"},
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert judged.returncode == 0, judged.stdout + judged.stderr
