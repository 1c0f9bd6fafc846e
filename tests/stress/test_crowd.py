"""Many idle clients: the promised bounds, in a laboratory that is smaller than that of the soak."""

from __future__ import annotations

from pathlib import Path

import crowd
import pytest
from crowd import Crowd


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_a_crowd_of_idle_clients_keeps_the_bounds(
    medium: str, build: Path, env: dict[str, str]
) -> None:
    small = Crowd(medium, objects=20, servers=4, clients=200, client_processes=4, idle_s=2.0)
    costs = crowd.measure(small, build, env)
    print(f"\n{small}: {costs}")
    assert costs.broken_bounds() == []
