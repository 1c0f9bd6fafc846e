"""`make bench-peers` runs with what is always there, ours and the limits. No figure is judged."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from processes import WITH_OTHER_USERS

TREE = Path(__file__).resolve().parents[2]


def bench_peers(build: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [
            *WITH_OTHER_USERS,
            sys.executable,
            TREE / "benchmarks" / "peers" / "bench_peers.py",
            "--build",
            build,
            *words,
        ],
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_ours_and_the_limits_answer_in_every_setting(build: Path) -> None:
    done = bench_peers(build, "--smoke", "--without", "all")
    assert done.returncode == 0, done.stderr
    tables = [line for line in done.stdout.splitlines() if line.startswith(("|--", "|:-"))]
    assert len(tables) == 1 + 22, done.stdout  # the bars, and a table of each setting
    assert done.stdout.count("**ours**, 64 idle clients") >= 2
    assert done.stdout.count("| **ours**, three readers |") == 1
    assert "**not measured**" in done.stdout  # nobody was there to compare with


def test_a_peer_that_is_not_there_is_named_the_rest_is_measured_and_the_run_fails(
    build: Path, tmp_path: Path
) -> None:
    (tmp_path / "benchmarks").symlink_to(build / "benchmarks")  # and no peers beside it
    done = bench_peers(tmp_path, "--smoke", "--only", "64 outstanding", "--without", "ice")
    assert done.returncode == 3, done.stderr
    named = "not there or broken: capnp, iceoryx, iceoryx2, omniorb."
    assert done.stderr.count(named) == 2  # before, and where the eye falls when it has ended
    assert "| **ours** |" in done.stdout


def test_a_name_that_is_no_peer_is_refused_before_anything_runs(build: Path) -> None:
    done = bench_peers(build, "--without", "gRPC")
    assert done.returncode == 1
    assert done.stderr.startswith("bench-peers: gRPC is no peer: all, capnp, ice, iceoryx,")
