"""The short form of the comparison with lcm-gen; `make fuzz` has the long one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).with_name("lcm_differential.py")


@pytest.mark.timeout(600)
def test_random_types_agree_with_lcm_gen_in_bytes_values_and_fingerprints() -> None:
    done = subprocess.run(
        [sys.executable, str(PROGRAM), "--types", "12", "--batch", "12", "--values", "200"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    last = done.stdout.splitlines()[-1]
    assert last == "lcm-gen: 12 random types x 200 values, 0 differences"
