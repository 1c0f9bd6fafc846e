"""What `make format` leaves alone."""

import subprocess
import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]


def test_what_gidl_generates_stays_as_gidl_lays_it_out() -> None:
    generated = subprocess.run(
        [sys.executable, "-m", "ruff", "format", "--check", "generated/python"],
        cwd=TREE,
        capture_output=True,
        text=True,
        check=False,
    )
    assert generated.returncode == 0, generated.stdout
