"""`make soak`: the stress tests for hours. Says at the end what was done, and how it ended.

Every round is a laboratory of its own, with a seed of its own that its line shows; its history is
judged when it ends, and its records are kept when something was wrong.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import cycle, product
from pathlib import Path

import control_loop
import crowd
import rampage
from crowd import Crowd
from rampage import Plan

EVERYBODY = {"client": 6, "server": 3, "broker": 1}
ROUND = 200
"""Kills of one laboratory."""
ROUND_OF_FREEZES = 25
"""Freezes of one laboratory."""


@dataclass(slots=True)
class Figures:
    kills: int = 0
    waits: int = 0
    freezes: int = 0
    in_vain: int = 0
    cuts: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    failed: list[str] = field(default_factory=list)


def killing(kills: int, seeds: random.Random, clock: Path) -> Iterator[Plan]:
    """Rounds of all kinds in turn until so many have been killed."""
    kinds = cycle(["shm", "lcm", "shm clients", "lcm clients", "faults", "clock", "python"])
    while kills > 0:
        seed, some = seeds.randrange(1 << 30), min(kills, ROUND)
        match next(kinds).split():
            case [("shm" | "lcm") as medium]:
                yield Plan(medium, seed, some, EVERYBODY)
            case [("shm" | "lcm") as medium, "clients"]:
                yield Plan(medium, seed, some, {"client": 1})
            case ["faults"]:
                yield Plan("lcm", seed, some, EVERYBODY, faults=f"0.1,0.1,0.3,0.01,{seed}")
            case ["clock"]:
                yield Plan("shm", seed, some, EVERYBODY, preload=clock)
            case _:
                some = min(some, 40)
                yield Plan(
                    seeds.choice(["shm", "lcm"]),
                    seed,
                    some,
                    {"client": 3, "server": 1},
                    pause_s=0.4,
                    clients=1,
                    python_clients=2,
                    python_server=True,
                )
        kills -= some


def waiting(instants: int, seeds: random.Random) -> Iterator[Plan]:
    """Servers die while somebody is blocked in wait(), every other with a child that holds all."""
    at = 0
    for children in cycle([False, True]):
        if at >= instants:
            return
        some = min(100, instants - at)
        at += some
        seed = seeds.randrange(1 << 30)
        yield Plan(
            "shm", seed, some, {"server": 1}, pause_s=0.1, clients=0, waiters=1, children=children
        )
    seed = seeds.randrange(1 << 30)
    yield Plan("lcm", seed, 20, {"server": 1}, pause_s=0.5, clients=0, waiters=1)


def freezing(freezes: int, seeds: random.Random) -> Iterator[list[Plan]]:
    """Ten laboratories beside each other, in which programs stand still for up to ten seconds;
    two of them have a zone."""
    while freezes > 0:
        each = min(ROUND_OF_FREEZES, -(-freezes // 10))
        plans = rampage.freezing(each, 10.0, seeds)
        for medium in ("shm", "lcm"):
            plans.append(rampage.around_a_zone(medium, seeds.randrange(1 << 30), 0, each))
        freezes -= sum(plan.freezes for plan in plans)
        yield plans


def disturbing(times: int, seeds: random.Random) -> Iterator[Plan]:
    yield Plan("lcm", seeds.randrange(1 << 30), cuts=times, longest_cut_s=10.0, pause_s=0.3)


def carry_out(plan: Plan, build: Path, env: Mapping[str, str], figures: Figures) -> None:
    records = Path(tempfile.mkdtemp(prefix="soak-"))
    began = time.monotonic()
    try:
        told = rampage.run(plan, build, records, env)
    except Exception as wrong:  # whatever it is: the other laboratories go on
        figures.failed.append(f"{plan}\nrecords: {records}\n{wrong}")
        print(f"WRONG {figures.failed[-1]}", flush=True)
        return
    figures.kills += len(told.kills)
    figures.freezes += plan.freezes
    figures.in_vain += sum(1 for _ in told.frozen_before_they_began())
    figures.cuts += len(told.cuts)
    calls = [call for client in told.clients for call in client.calls.values()]
    figures.waits += len(calls) if plan.waiters else 0
    figures.outcomes.update(call.detail() or "client killed" for call in calls)
    print(f"right in {time.monotonic() - began:.0f} s, {plan}: {told.summary()}", flush=True)
    shutil.rmtree(records)


def call_over_a_faulty_line(calls: int, seed: int, build: Path, figures: Figures) -> None:
    env = {**os.environ, "STRESS_CALLS": str(calls), "STRESS_SEED": str(seed)}
    done = subprocess.run([build / "tests" / "stress" / "faulty_line_test"], env=env)
    if done.returncode != 0:
        figures.failed.append(f"faulty_line_test with STRESS_CALLS={calls} STRESS_SEED={seed}")


def attack_the_channel(packets: int, build: Path, figures: Figures) -> None:
    env = {**os.environ, "GECOS_HOSTILE_PACKETS": str(packets)}
    test = [build / "tests" / "cpp" / "crypto" / "crypto_test", "--gtest_filter=Hostile.*"]
    if subprocess.run(test, env=env).returncode != 0:
        figures.failed.append(f"crypto_test, Hostile, with GECOS_HOSTILE_PACKETS={packets}")


def stream(seconds: int, build: Path, figures: Figures) -> None:
    env = {**os.environ, "STREAM_SECONDS": str(seconds)}
    done = subprocess.run([build / "tests" / "cpp" / "session" / "stream_rate_test"], env=env)
    if done.returncode != 0:
        figures.failed.append(f"stream_rate_test with STREAM_SECONDS={seconds}")


def close_a_loop(seconds: int, build: Path, env: Mapping[str, str], figures: Figures) -> None:
    loops = control_loop.run(seconds, build, env)
    print(loops, flush=True)
    if not loops.keeps_its_promise():
        figures.failed.append(f"control loop for {seconds} s: {loops.closed.missed} cycles missed")


def move(moves: int, build: Path, figures: Figures) -> None:
    """Straight and joint moves of each arm, stopped, held up and overridden at any time; and chains
    of such moves that go over into each other. 0 leaves them out."""
    if moves == 0:
        return
    env = {**os.environ, "MOTION_MOVES": str(moves)}
    tests = build / "tests" / "cpp" / "robcl"

    def try_moves(test_of: tuple[str, str]) -> None:
        name, arm = test_of
        asked = f"{name} with MOTION_MOVES={moves} of {arm}"
        began = time.monotonic()
        test = [tests / name, f"--gtest_filter=*Random*/{arm}*", "--gtest_brief=1"]
        done = subprocess.run(test, env=env, stdout=subprocess.PIPE, text=True)
        if done.returncode == 0:
            print(f"right in {time.monotonic() - began:.0f} s, {asked}", flush=True)
        else:
            figures.failed.append(f"{asked}:\n{done.stdout}")
            print(f"WRONG {figures.failed[-1]}", flush=True)

    names = ("robcl_random_moves_test", "robcl_move_chain_test")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        # Those that last longest begin. The list raises what a thread raised, such as that a test
        # was not built.
        list(pool.map(try_moves, product(names, ("seven_axes", "puma560", "rx90"))))


def hand_over(times: int, build: Path, figures: Figures) -> None:
    """A block from one arm to another one and back, at so many random places."""
    chosen = {"GECOS_BUILD": str(build), "HAND_OVERS": str(times)}
    test = Path(__file__).resolve().parents[1] / "system" / "test_hand_over.py"
    command = [sys.executable, "-m", "pytest", "-n0", "-q", "-s", test, "-k", "random"]
    if subprocess.run(command, env={**os.environ, **chosen}).returncode != 0:
        figures.failed.append(f"{test.name} with HAND_OVERS={times}")


def gather_a_crowd(clients: int, build: Path, env: Mapping[str, str], figures: Figures) -> None:
    """One client process for 20 clients, and one object for ten, in 20 servers at most: this crowd
    must keep the promised bounds. Then one client process that reaches as many objects as it has
    clients, whose costs are shown."""
    for medium in ("shm", "lcm"):
        for objects, processes in ((max(clients // 10, 1), max(clients // 20, 1)), (clients, 1)):
            servers = next(count for count in (20, 10, 5, 2, 1) if objects % count == 0)
            plan = Crowd(medium, objects, servers, clients, processes)
            costs = crowd.measure(plan, build, env)
            print(f"{plan}: {costs}", flush=True)
            broken = costs.broken_bounds(quiet=True) if objects < clients else []
            figures.failed.extend(f"{plan}: {bound}" for bound in broken)


def main() -> int:
    parser = argparse.ArgumentParser(description="The stress tests for hours.")
    parser.add_argument("--build", type=Path, default=Path("build"))
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 30))
    parser.add_argument("--kills", type=int, default=10_000)
    parser.add_argument("--waits", type=int, default=1_000)
    parser.add_argument("--freezes", type=int, default=1_000)
    parser.add_argument("--disturbances", type=int, default=50, help="cut lines")
    parser.add_argument("--calls", type=int, default=1_000_000, help="over each faulty line")
    parser.add_argument("--packets", type=int, default=1_000_000, help="to the secure channel")
    parser.add_argument("--stream", type=int, default=60, help="seconds of a stream at 1 kHz")
    parser.add_argument("--loop", type=int, default=60, help="seconds of a control loop at 1 kHz")
    parser.add_argument("--moves", type=int, default=20_000, help="of each arm")
    parser.add_argument("--hand-overs", type=int, default=100, help="at random places, both ways")
    parser.add_argument("--clients", type=int, default=1_000, help="idle ones, over each medium")
    asked = parser.parse_args()
    print(f"soak: seed {asked.seed}", flush=True)

    build, seeds, figures = asked.build.resolve(), random.Random(asked.seed), Figures()
    clock = build / "tests" / "stress" / "libwild_clock.so"
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="workbench-") as made:
        rampage.generate_python(Path(made))
        paths = [f"{made}/python", *filter(None, [os.environ.get("PYTHONPATH")])]
        env = {"PYTHONPATH": os.pathsep.join(paths), "GECOS_KEY_DIR": f"{made}/keys"}
        os.environ["GECOS_AUDIT_DIR"] = env["GECOS_AUDIT_DIR"] = f"{made}/audit"
        os.environ["GECOS_KEY_DIR"] = env["GECOS_KEY_DIR"]
        gather_a_crowd(asked.clients, build, env, figures)
        close_a_loop(asked.loop, build, env, figures)
        move(asked.moves, build, figures)
        hand_over(asked.hand_overs, build, figures)
        attack_the_channel(asked.packets, build, figures)
        stream(asked.stream, build, figures)
        call_over_a_faulty_line(asked.calls, asked.seed, build, figures)
        for beside in freezing(asked.freezes, seeds):
            with ThreadPoolExecutor(len(beside)) as pool:
                for plan in beside:
                    pool.submit(carry_out, plan, build, env, figures)
        for plans in (
            disturbing(asked.disturbances, seeds),
            waiting(asked.waits, seeds),
            killing(asked.kills, seeds, clock),
        ):
            for plan in plans:
                carry_out(plan, build, env, figures)

    told = ", ".join(f"{count} {what}" for what, count in figures.outcomes.most_common())
    print(
        f"\nsoak: seed {asked.seed}, {(time.monotonic() - began) / 60:.0f} min:"
        f" {figures.kills} kills, {figures.waits} waits without time-out,"
        f" {figures.freezes} freezes ({figures.in_vain} handlers began in vain after one),"
        f" {figures.cuts} cuts,"
        f" {asked.calls} calls over each of two faulty lines,"
        f" {2 * asked.hand_overs} hand-overs,"
        f" {asked.packets} hostile packets, {asked.stream} s of a stream over each of two media,"
        f" {asked.loop} s of a control loop,"
        f" {figures.outcomes.total()} commands ({told})"
    )
    for wrong in figures.failed:
        print(f"soak: WRONG {wrong}")
    print("soak: FAILED" if figures.failed else "soak: all right")
    return 1 if figures.failed else 0


if __name__ == "__main__":
    sys.exit(main())
