"""The watch over how late the machine is."""

from __future__ import annotations

import os
from pathlib import Path

import lateness
import pytest
from lateness import Lateness, Watch, joined
from processes import until

MS = 1_000_000


def test_times_of_two_cores_that_overlap_are_one() -> None:
    assert joined([(10, 20), (40, 50), (15, 30), (30, 31), (42, 44)]) == [(10, 31), (40, 50)]


def test_the_longest_lateness_counts() -> None:
    watch = Watch()
    assert watch.longest_s() == 0
    watch.late = [(0, 900 * MS), (1000 * MS, 1200 * MS)]
    assert watch.longest_s() == pytest.approx(0.9)


def test_each_core_has_a_thread_of_its_own() -> None:
    with Watch() as watch:
        assert watch.cores() == [{core} for core in sorted(os.sched_getaffinity(0))]


def test_a_watch_notes_a_wake_up_that_is_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lateness, "WORTH_NOTING_S", 0.0)  # each wake-up is a little late
    with Lateness(tmp_path / "machine.log") as watch:
        until(lambda: bool(watch.late), "a late wake-up")
    due, _, woken = (tmp_path / "machine.log").read_text().splitlines()[0].split()
    assert int(due) < int(woken)
