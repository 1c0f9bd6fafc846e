"""Generates code as a user does."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]


def generate(out: Path, *files: Path | str) -> None:
    """`gidl gen` as a user calls it."""
    search = ["-I", str(TREE / "idl"), "-I", str(TREE / "tests" / "idl")]
    subprocess.run(
        [sys.executable, "-m", "gidl", "gen", *search, "--out", str(out), *map(str, files)],
        check=True,
        cwd=TREE,
        env={"PYTHONPATH": str(TREE / "codegen"), "PATH": "/usr/bin:/bin"},
    )
