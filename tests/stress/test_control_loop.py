"""The control loop of the soak, for a moment. That it misses no more cycles than is promised is
asserted by `make soak` alone: the other tests use the processor meanwhile."""

from __future__ import annotations

from pathlib import Path

import control_loop
import pytest
from control_loop import Cycles, Loops


def test_a_client_answers_the_ticks_of_a_loop_at_1_khz(build: Path, env: dict[str, str]) -> None:
    loops = control_loop.run(2, build, env)
    print(f"\n{loops}")
    for cycles in (loops.closed, loops.bare):
        assert cycles.count >= 2000
        assert sum(cycles.woke) <= cycles.count
    assert sum(loops.closed.answered) + loops.closed.missed == loops.closed.count
    assert sum(loops.closed.answered) > 0
    assert sum(loops.bare.answered) == 0


@pytest.mark.parametrize(("closed", "kept"), [(0, True), (1, True), (4, True), (5, False)])
def test_the_promise_compares_with_the_bare_loop(closed: int, kept: bool) -> None:
    loops = Loops("real-time", Cycles(100, closed), Cycles(100, 2))
    assert loops.keeps_its_promise() == kept
    assert f"{closed} of 100 cycles missed, at most 4 promised" in str(loops)
