"""Programs are killed at random instants, and every command ends: short forms of `make soak`."""

from __future__ import annotations

from pathlib import Path

import pytest
import rampage
from history import History
from rampage import Plan

EVERYBODY = {"client": 6, "server": 3, "broker": 1}
CLIENTS = {"client": 1}
PAUSES_S = {"shm": 0.05, "lcm": 0.12}
"""Over lcm a death is noticed by silence, so that its commands last longer."""


def carry_out(plan: Plan, build: Path, records: Path, env: dict[str, str]) -> History:
    told = rampage.run(plan, build, records, env)
    assert len(told.kills) == plan.kills
    print(f"\n{plan}\n{told.summary()}")
    return told


@pytest.mark.parametrize(("medium", "kills"), [("shm", 110), ("lcm", 50)])
def test_killed_is_everybody_but_a_witness(
    medium: str, kills: int, build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan(medium, seed, kills=kills, victims=EVERYBODY, pause_s=PAUSES_S[medium])
    told = carry_out(plan, build, tmp_path, env)
    assert medium != "shm" or told.sent_again() > 0, (
        "no idempotent command went on at the next server"
    )


@pytest.mark.parametrize(("medium", "kills"), [("shm", 60), ("lcm", 40)])
def test_killed_are_clients_of_a_server_that_goes_on(
    medium: str, kills: int, build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan(medium, seed, kills=kills, victims=CLIENTS)
    carry_out(plan, build, tmp_path, env)


def test_killed_is_everybody_while_the_line_loses_repeats_reorders_and_damages(
    build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan("lcm", seed, kills=20, victims=EVERYBODY, faults=f"0.1,0.1,0.3,0.01,{seed}")
    carry_out(plan, build, tmp_path, env)


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_killed_are_programs_in_python(
    medium: str, build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan(
        medium,
        seed,
        kills=10,
        victims={"client": 3, "server": 1},
        pause_s=0.4,
        clients=1,
        python_clients=2,
        python_server=True,
    )
    carry_out(plan, build, tmp_path, env)


@pytest.mark.parametrize(("medium", "kills"), [("shm", 40), ("lcm", 4)])
@pytest.mark.parametrize("children", [False, True])
def test_who_waits_without_time_out_hears_of_the_death(
    medium: str,
    kills: int,
    children: bool,
    build: Path,
    tmp_path: Path,
    env: dict[str, str],
    seed: int,
) -> None:
    plan = Plan(
        medium,
        seed,
        kills=kills,
        victims={"server": 1},
        pause_s=0.1 if medium == "shm" else 0.5,
        clients=0,
        waiters=1,
        children=children,
    )
    told = rampage.run(plan, build, tmp_path, env)
    print(f"\n{plan}\n{told.summary()}")
    waits = [call for client in told.clients for call in client.calls.values()]
    assert len(waits) >= kills, "nobody waited for a server that was killed"
