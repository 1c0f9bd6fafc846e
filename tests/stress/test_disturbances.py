"""Programs survive disturbances other than kills: suspension, a cut network, a changing clock."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
import rampage
import statuses
from rampage import Plan

FREEZES = 5
"""Freezes of each laboratory; there are eight laboratories, so forty freezes in all."""


def test_programs_that_stand_still_start_nothing_that_was_given_up_and_leave_no_command_open(
    build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plans = rampage.freezing(FREEZES, 10.0, random.Random(seed))
    histories = rampage.run_beside_each_other(plans, build, tmp_path, env)
    checked = [statuses.figures(told) for told in histories]
    assert any(figures.takes for figures in checked), "nobody took over"
    for plan, told in zip(plans, histories, strict=True):
        print(f"\n{plan}\n{told.summary()}")
        assert len(told.freezes) >= FREEZES


def test_two_hosts_that_are_cut_off_from_each_other_leave_no_command_open(
    build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan("lcm", seed, cuts=6, clients=2, pause_s=0.3)
    told = rampage.run(plan, build, tmp_path, env)
    assert len(told.cuts) == plan.cuts
    print(f"\n{plan}\n{told.summary()}")


def test_the_wild_clock_is_wild(build: Path) -> None:
    """A precondition of the next test."""
    look = "import time; print(abs(time.time() - time.time()))"
    preloaded = {**os.environ, "LD_PRELOAD": str(build / "tests" / "stress" / "libwild_clock.so")}
    said = subprocess.run(
        [sys.executable, "-c", look], env=preloaded, check=True, stdout=subprocess.PIPE
    )
    assert float(said.stdout) > 3600


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_jumps_of_the_wall_clock_change_nothing(
    medium: str, build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan(
        medium,
        seed,
        kills=12,
        victims={"client": 3, "server": 1, "broker": 1},
        preload=build / "tests" / "stress" / "libwild_clock.so",
    )
    told = rampage.run(plan, build, tmp_path, env)
    print(f"\n{plan}\n{told.summary()}")
