"""Many idle clients: the promised bounds, in a laboratory that is smaller than that of the soak."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import crowd
import pytest
from crowd import Costs, Crowd


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_a_crowd_of_idle_clients_keeps_the_bounds(
    medium: str, build: Path, env: dict[str, str]
) -> None:
    small = Crowd(
        medium,
        objects=20,
        servers=4,
        clients=200,
        client_processes=4,
        idle_s=2.0,
        rounds=5,
        gatherings=2,
    )
    costs = crowd.measure(small, build, env)
    print(f"\n{small}: {costs}")
    assert costs.broken_bounds(quiet=False) == []


@pytest.mark.parametrize(
    ("cost", "quiet", "told"),
    [
        ({}, True, []),
        ({"connected_s": 10.1}, False, ["seconds until all are connected: 10.1, at most 10"]),
        (
            {"names_back_s": 2.5},
            False,
            ["seconds until a new broker has all names: 2.5, at most 2"],
        ),
        ({"server_kib": 65.0}, False, ["KiB of a client in its server: 65, at most 64"]),
        ({"idle_percent": 0.052}, True, ["% of a core of an idle client: 0.052, at most 0.05"]),
        ({"idle_percent": 0.052}, False, []),
        (
            {"beside_us": 2.5},
            True,
            ["a round trip beside idle clients, in those of the only client: 1.25, at most 1.2"],
        ),
        ({"beside_us": 2.5}, False, []),
    ],
)
def test_each_bound_is_judged(cost: dict[str, float], quiet: bool, told: list[str]) -> None:
    kept = Costs(
        connected_s=9.9,
        idle_percent=0.05,
        served_percent=1.0,
        server_kib=64.0,
        alone_us=2.0,
        beside_us=2.4,
        names_back_s=2.0,
    )
    assert replace(kept, **cost).broken_bounds(quiet=quiet) == told
