"""The short form of the gate (tests/generated/gate): every accepted file of the corpus and five
random sets of files through the compiler, both languages and the encoder of the gate itself.
`make fuzz` has the long form. GIDL_GATE_SEED begins five other sets."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

GATE = Path(__file__).with_name("gate")


@pytest.mark.timeout(1800)
def test_both_languages_and_the_gates_own_encoder_give_the_same_verdicts() -> None:
    seed = os.environ.get("GIDL_GATE_SEED", "1")
    done = subprocess.run(
        [sys.executable, str(GATE), "--corpus", "--random", "5", "--seed", seed, "--values", "8"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-20_000:] + done.stderr
