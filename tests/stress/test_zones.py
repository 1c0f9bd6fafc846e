"""A person comes and leaves while the zone, the server and clients are killed and suspended:
nothing starts while nobody is present. And the judge finds histories in which something does."""

from __future__ import annotations

from pathlib import Path

import history
import pytest
import rampage

SECOND = 1_000_000_000
HERS = 1 << 32


def judged(directory: Path, server: str, zones: dict[str, str], kills: str = "") -> list[str]:
    """The findings for commands 1 to 3 of one client, with times in ms in place of ns."""
    issues = ((1, 10), (2, 1900), (3, 1950))
    issued = "".join(f"{at} issue {HERS + number} tap 1 5\n" for number, at in issues)
    client = f"0 client 11\n1 open 1 4711\n2 granted 1 ACTOR\n{issued}"
    ends = "".join(f"6000 end {HERS + n} FINISHED DONE 5\n" for n in (1, 2, 3))
    logs = {"client.1": client + ends + "6001 done\n"}
    logs |= {"server.0": f"0 serve 4711\n{server}", "kills": kills, **zones}
    for name, text in logs.items():
        lines = [line.split(" ") for line in text.splitlines()]
        in_ns = [" ".join([f"{int(at)}000000", *rest]) for at, *rest in lines]
        (directory / f"{name}.log").write_text("".join(f"{line}\n" for line in in_ns))
    return history.check(history.read(directory))


def begins(number: int, at: int) -> str:
    command = HERS + number
    return f"{at} start {command} tap {at}000000\n{at} finish {command} tap 5\n"


ZONE = {"zone.1": "0 zone 12\n5 comes\n2000 leaves\n3000 comes\n9000 done\n"}
RIGHT = begins(1, 20) + begins(2, 2100) + begins(3, 4000)


def test_a_command_may_begin_within_the_bound_and_after_presence_counts_again(
    tmp_path: Path,
) -> None:
    assert judged(tmp_path, RIGHT, ZONE) == []


def test_a_mark_may_be_a_kernel_tick_too_early(tmp_path: Path) -> None:
    after_return = RIGHT.replace(begins(3, 4000), begins(3, 2995))
    assert judged(tmp_path, after_return, ZONE) == []
    early = RIGHT.replace(begins(3, 4000), begins(3, 2985))
    assert judged(tmp_path, early, ZONE) == [
        f"server.0.log: command {HERS + 3} began 0.985 s after the person had left"
    ]


def test_rejected_is_a_command_that_begins_while_nobody_is_present(tmp_path: Path) -> None:
    late = RIGHT.replace(begins(2, 2100), begins(2, 2600))
    assert judged(tmp_path, late, ZONE) == [
        f"server.0.log: command {HERS + 2} began 0.600 s after the person had left"
    ]


def test_rejected_is_a_command_that_was_sent_before_presence_was_lost(tmp_path: Path) -> None:
    resumed = RIGHT.replace(begins(2, 2100), begins(2, 3900))
    assert judged(tmp_path, resumed, ZONE) == [
        f"server.0.log: command {HERS + 2} began, and was sent before the person had left"
    ]


def test_presence_is_lost_with_a_report_that_grows_too_old_while_the_zone_stands_still(
    tmp_path: Path,
) -> None:
    zones = {"zone.1": "0 zone 12\n5 comes\n9000 done\n"}
    waited = RIGHT.replace(begins(2, 2100), begins(2, 5500))
    shorter = "1960 freeze 12 2900000000\n"
    assert judged(tmp_path, waited, zones, shorter) == []
    with_the_server = "1960 freeze 12 3700000000\n1960 freeze 4711 3700000000\n"
    assert judged(tmp_path, waited, zones, with_the_server) == [
        f"server.0.log: command {HERS + 2} began, and was sent before the zone stood still"
    ]


@pytest.mark.parametrize("kills", ["500 kill 12\n", "500 freeze 12 3000000000\n"])
def test_rejected_is_a_command_that_begins_long_after_the_zone_fell_silent(
    kills: str, tmp_path: Path
) -> None:
    zones = {"zone.1": "0 zone 12\n5 comes\n", "zone.2": "2999 zone 13\n3000 comes\n"}
    assert judged(tmp_path, RIGHT, zones, kills) == [
        f"server.0.log: command {HERS + 2} began 1.600 s after the zone had ended"
        if "kill" in kills
        else f"server.0.log: command {HERS + 2} began 1.600 s after the zone stood still"
    ]


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_nothing_starts_while_nobody_is_present_whoever_is_killed_or_stands_still(
    medium: str, build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = rampage.around_a_zone(medium, seed, kills=8, freezes=10)
    told = rampage.run(plan, build, tmp_path, env)
    print(f"\n{plan}\n{told.summary()}")
    calls = [call for client in told.clients for call in client.calls.values()]
    losses = sum(call.detail() == "PRESENCE_LOST" for call in calls)
    assert losses > 0, "nobody commanded while nobody was present"
    left = sum(not present for zone in told.zones for _, present in zone.changes)
    assert left > 1, "the person hardly ever left"
