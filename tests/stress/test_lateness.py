"""A machine that did not run one of its cores was late, also while the others ran."""

from __future__ import annotations

from pathlib import Path

import lateness
import pytest
from lateness import Lateness, Watch, joined
from processes import until

MS = 1_000_000


def test_times_of_two_cores_that_meet_are_one() -> None:
    assert joined([(10, 20), (40, 50), (15, 30), (30, 31), (42, 44)]) == [(10, 31), (40, 50)]


def test_the_longest_of_those_that_ended_after_a_time_counts() -> None:
    watch = Watch()
    watch.late = [(0, 900 * MS), (1000 * MS, 1200 * MS), (1100 * MS, 1150 * MS)]
    assert watch.longest_s(since=0) == pytest.approx(0.9)
    assert watch.longest_s(since=900 * MS) == pytest.approx(0.2)
    assert watch.longest_s(since=1200 * MS) == 0


def test_a_watch_notes_a_wake_up_that_is_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lateness, "WORTH_NOTING_S", 0.0)  # each wake-up is a little late
    with Lateness(tmp_path / "machine.log") as watch:
        until(lambda: bool(watch.late), "a late wake-up")
    due, _, woken = (tmp_path / "machine.log").read_text().splitlines()[0].split()
    assert int(due) < int(woken)
