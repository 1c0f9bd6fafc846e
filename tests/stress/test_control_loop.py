"""The control loop of the soak, for a moment. That it misses no more cycles than is promised is
asserted by `make soak` alone: the other tests use the processor meanwhile."""

from __future__ import annotations

from pathlib import Path

import control_loop
import pytest
from control_loop import LoopCounts, Loops


def test_a_client_answers_the_ticks_of_a_loop_at_1_khz(build: Path, env: dict[str, str]) -> None:
    loops = control_loop.run(2, build, env)
    print(f"\n{loops}")
    closed, bare = loops.closed, loops.bare
    for each in (closed, bare):
        assert each.count >= 2000
        assert sum(each.woke) <= each.count
    assert (bare.first_due_ns - closed.first_due_ns) % 1_000_000 == 0, "due at the same instants"
    assert bare.first_due_ns < closed.last_due_ns, "at the same time"
    assert closed.first_due_ns < bare.last_due_ns, "at the same time"
    assert sum(loops.closed.answered) + loops.closed.missed == loops.closed.count
    assert sum(loops.closed.answered) > 0
    assert sum(loops.bare.answered) == 0


@pytest.mark.parametrize(("closed", "kept"), [(0, True), (1, True), (4, True), (5, False)])
def test_the_promise_compares_with_the_bare_loop(closed: int, kept: bool) -> None:
    of_both = LoopCounts(count=100, missed=closed), LoopCounts(count=100, missed=2)
    loops = Loops("real-time", *of_both)
    assert loops.keeps_its_promise() == kept
    assert f"{closed} of 100 cycles missed, at most 4 promised" in str(loops)
    assert "loop of the next higher priority missed 2 of 100" in str(loops)
