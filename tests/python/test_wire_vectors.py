"""The vectors that C++ and Python share: the same bytes, the same values, the same verdicts."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from wire_reads import run_reads

VECTORS = Path(__file__).parent.parent / "vectors"
DECODER = json.loads((VECTORS / "decoder.json").read_text(encoding="utf-8"))


def ids(case: dict[str, Any]) -> str:
    return str(case["name"])


@pytest.mark.parametrize("case", DECODER["accepted"], ids=ids)
def test_good_bytes_are_read(case: dict[str, Any]) -> None:
    assert run_reads(bytes.fromhex(case["bytes"]), case["reads"]) == {"values": case["values"]}


@pytest.mark.parametrize("case", DECODER["refused"], ids=ids)
def test_bad_bytes_are_refused_for_the_right_reason(case: dict[str, Any]) -> None:
    verdict = {"refused": case["refused"]}
    data = bytes.fromhex(case["bytes"])
    assert run_reads(data, case["reads"]) == verdict
    assert run_reads(memoryview(data), case["reads"]) == verdict


def test_mutated_bytes_get_the_recorded_verdict() -> None:
    for case in DECODER["mutations"]:
        verdict = run_reads(bytes.fromhex(case["bytes"]), DECODER["mutation_reads"])
        assert verdict == {key: case[key] for key in verdict}, case["name"]


def test_the_vectors_are_what_their_script_writes(tmp_path: Path) -> None:
    program = (
        "import sys, pathlib; sys.path[:0] = [sys.argv[1]]; import make_wire_vectors as make;"
        "make.main(pathlib.Path(sys.argv[2]))"
    )
    subprocess.run(
        [sys.executable, "-c", program, str(VECTORS), str(tmp_path)],
        check=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    for name in ("decoder", "frames", "packet"):
        written = json.loads((tmp_path / f"{name}.json").read_text(encoding="utf-8"))
        checked_in = json.loads((VECTORS / f"{name}.json").read_text(encoding="utf-8"))
        assert written == checked_in, f"run tests/vectors/make_wire_vectors.py: {name}.json differs"
