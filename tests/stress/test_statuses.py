"""The judge of statuses accepts a right history, rejects each kind of wrong one by name, and finds
clients that only pretend to take over."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import history
import pytest
import rampage
import statuses
from rampage import Plan

SECOND = 1_000_000_000
GUARD = 1 << 32
WORKER = 2 << 32

TAKES = f"""
0 client 11
1 open 1 4711
2 granted 1 ACTOR
20 asks 1 take
30 did 1 take
32 issue {GUARD + 1} tap 1 5
40 end {GUARD + 1} FINISHED DONE 5
50 asks 1 give
60 did 1 give
90 done
"""
WORKS = f"""
0 client 12
1 open 1 4711
2 granted 1 ACTOR
4 issue {WORKER + 1} file 1 6
5 issue {WORKER + 2} tap 1 7
6 asks 1 give
31 end {WORKER + 1} COMMAND_FAILED PREEMPTED -
33 end {WORKER + 2} COMMAND_FAILED PREEMPTED -
70 issue {WORKER + 3} tap 1 8
80 end {WORKER + 3} FINISHED DONE 8
90 done
"""
SERVER = f"""
0 serve 4711
6 start {WORKER + 1} file 6
26 finish {WORKER + 1} file -
35 start {GUARD + 1} tap 35
36 finish {GUARD + 1} tap 5
72 start {WORKER + 3} tap 72
73 finish {WORKER + 3} tap 8
"""


def judged(
    directory: Path, takes: str = TAKES, works: str = WORKS, server: str = SERVER, kills: str = ""
) -> list[str]:
    for name, text in ("client.1", takes), ("client.2", works), ("server.0", server):
        (directory / f"{name}.log").write_text(text.lstrip())
    (directory / "kills.log").write_text(kills)
    return history.check(history.read(directory))


def test_a_take_over_that_held_the_others_off_is_accepted_and_counted(tmp_path: Path) -> None:
    assert judged(tmp_path) == []
    assert history.read(tmp_path).summary().endswith(", 1 take-overs")


def begins(command: int, at: int, operation: str = "tap", result: int = 7) -> str:
    return f"{at} start {command} {operation} {at}\n{at} finish {command} {operation} {result}\n"


def with_start(command: int, at: int) -> str:
    """The server of above, which also starts that command."""
    lines = (SERVER + begins(command, at)).lstrip().splitlines(keepends=True)
    return "".join(sorted(lines, key=lambda line: int(line.split()[0])))


def test_rejected_is_a_command_beside_a_taker(tmp_path: Path) -> None:
    works = WORKS.replace(f"5 issue {WORKER + 2}", f"31 issue {WORKER + 2}").replace(
        "33 end", "89 end"
    )
    works = works.replace("6 asks 1 give\n", "")
    works = works.replace(
        f"{WORKER + 2} COMMAND_FAILED PREEMPTED -", f"{WORKER + 2} FINISHED DONE 7"
    )
    for wrong, at in ((True, 34), (False, 37)):
        found = judged(tmp_path, works=works, server=with_start(WORKER + 2, at))
        beside = f"server.0.log: command {WORKER + 2} started while client.1.log had taken over"
        assert found == ([beside] if wrong else []), "nothing shows when a taker lost its status"


def test_rejected_is_a_command_of_before_a_take_over_also_when_it_is_over(tmp_path: Path) -> None:
    works = WORKS.replace(
        f"33 end {WORKER + 2} COMMAND_FAILED PREEMPTED -", f"89 end {WORKER + 2} FINISHED DONE 7"
    )
    server = with_start(WORKER + 2, 71)
    assert judged(tmp_path, works=works, server=server) == [
        f"server.0.log: command {WORKER + 2} started after a take-over by client.1.log had ended it"
    ]
    stood_still = works.replace("6 asks 1 give\n", "")  # its program, perhaps before its call
    assert judged(tmp_path, works=stood_still, server=server) == []


def test_rejected_is_a_motion_that_goes_on_to_its_end_under_a_taker(tmp_path: Path) -> None:
    works = WORKS.replace(
        f"{WORKER + 1} COMMAND_FAILED PREEMPTED -", f"{WORKER + 1} FINISHED DONE 6"
    )
    server = SERVER.replace(f"26 finish {WORKER + 1} file -", f"31 finish {WORKER + 1} file 6")
    assert judged(tmp_path, works=works, server=server) == [
        f"server.0.log: command {WORKER + 1} is FINISHED, and was running when client.1.log took"
        " over"
    ]


def test_a_command_that_began_after_a_take_over_may_have_an_older_mark(tmp_path: Path) -> None:
    marked_before = SERVER.replace(f"{WORKER + 3} tap 72", f"{WORKER + 3} tap 19").replace(
        f"{WORKER + 1} file 6", f"{WORKER + 1} file 5"
    )
    assert judged(tmp_path, server=marked_before) == []


def test_rejected_is_preempted_without_a_take_over(tmp_path: Path) -> None:
    takes = TAKES.replace("20 asks 1 take\n30 did 1 take\n", "")
    assert judged(tmp_path, takes) == [
        f"command {WORKER + number} is PREEMPTED, and nobody had taken over" for number in (1, 2)
    ]


def test_rejected_is_a_reading_beside_a_master(tmp_path: Path) -> None:
    takes = TAKES.replace("20 asks 1 take\n30 did 1 take\n", "30 granted 1 MASTER\n").replace(
        "50 asks 1 give\n60 did 1 give\n", "60 released 1\n"
    )
    works = WORKS.replace(
        f"33 end {WORKER + 2} COMMAND_FAILED PREEMPTED -", f"89 end {WORKER + 2} FINISHED DONE 7"
    ).replace("PREEMPTED", "STOPPED")
    works = works.replace(f"issue {WORKER + 2} tap", f"issue {WORKER + 2} look")
    reads = with_start(WORKER + 2, 34).replace(f"{WORKER + 2} tap", f"{WORKER + 2} look")
    assert judged(tmp_path, takes, works, reads) == [
        f"server.0.log: command {WORKER + 2} started while client.1.log was master"
    ]
    before = with_start(WORKER + 2, 29).replace(f"{WORKER + 2} tap", f"{WORKER + 2} look")
    assert judged(tmp_path, takes, works, before) == []


def test_rejected_is_a_command_beside_a_status_with_another_password(tmp_path: Path) -> None:
    takes = TAKES.replace("20 asks 1 take\n30 did 1 take\n", "30 granted 1 ACTOR own\n").replace(
        "50 asks 1 give\n60 did 1 give\n", "60 released 1\n"
    )
    works = WORKS.replace("PREEMPTED", "STOPPED").replace(
        f"33 end {WORKER + 2} COMMAND_FAILED STOPPED -", f"89 end {WORKER + 2} FINISHED DONE 7"
    )
    assert judged(tmp_path, takes, works, with_start(WORKER + 2, 34)) == [
        f"server.0.log: command {WORKER + 2} started while client.1.log had a status with another"
        " password"
    ]
    assert judged(tmp_path, takes, works, with_start(WORKER + 2, 29)) == []
    shared = takes.replace("ACTOR own", "ACTOR")
    assert judged(tmp_path, shared, works, with_start(WORKER + 2, 34)) == []


def test_rejected_is_a_command_of_a_client_that_fell_silent_before(tmp_path: Path) -> None:
    takes = "0 client 11\n90 done\n"
    at = 3 * SECOND
    works = (
        f"0 client 12\n1 open 1 4711\n2 granted 1 ACTOR\n4 issue {WORKER + 1} tap 1 7\n"
        f"{at + 9} end {WORKER + 1} FINISHED DONE 7\n{at + 9} done\n"
    )
    server = f"0 serve 4711\n{begins(WORKER + 1, at)}"
    frozen = f"10 freeze 12 {2 * SECOND}\n"
    assert judged(tmp_path, takes, works, server, frozen) == [
        f"server.0.log: command {WORKER + 1} started 3.000 s after client.2.log had fallen silent"
    ]
    for kills in ("", f"10 freeze 12 {SECOND // 2}\n"):
        assert judged(tmp_path, takes, works, server, kills) == [], "nobody was silent for so long"
    after = works.replace("4 issue", f"{2 * SECOND + 1} issue")
    assert judged(tmp_path, takes, after, server, frozen) == []
    too = f"{frozen}{SECOND} freeze 4711 {3 * SECOND - 1}\n"
    assert judged(tmp_path, takes, works, server, too) == [], "the server stood still too"
    (tmp_path / "machine.log").write_text(f"10 late {5 * SECOND // 2}\n")
    assert judged(tmp_path, takes, works, server, frozen) == [], "the server could not notice it"


SENDS = WORKS.replace(
    "33 end", f"34 send {WORKER + 9} 1\n34 issue {WORKER + 4} look 1 4\n33 end"
).replace("90 done", f"89 end {WORKER + 4} COMMAND_FAILED REJECTED -\n90 done")


def test_rejected_is_a_sample_beside_a_taker(tmp_path: Path) -> None:
    beside = SERVER.replace("35 start", f"34 take {WORKER + 9} 33\n35 start")
    assert judged(tmp_path, works=SENDS, server=beside) == [
        f"server.0.log: sample {WORKER + 9} started while client.1.log had taken over"
    ]
    after = SERVER.replace("72 start", f"62 take {WORKER + 9} 61\n72 start")
    assert judged(tmp_path, works=SENDS, server=after) == []
    assert ", 1 samples, 1 take-overs" in history.read(tmp_path).summary()


def test_rejected_is_a_sample_of_before_a_take_over(tmp_path: Path) -> None:
    sends = SENDS.replace("34 send", "7 send").replace("34 issue", "8 issue")
    server = SERVER.replace("72 start", f"62 take {WORKER + 9} 61\n72 start")
    assert judged(tmp_path, works=sends, server=server) == [
        f"server.0.log: sample {WORKER + 9} started after a take-over by client.1.log had ended it"
    ]


def test_rejected_are_samples_that_nobody_sent_or_that_are_taken_twice(tmp_path: Path) -> None:
    twice = SERVER.replace("72 start", 2 * f"62 take {WORKER + 9} 61\n" + "72 start")
    assert judged(tmp_path, works=SENDS, server=twice) == [f"sample {WORKER + 9} was taken 2 times"]
    assert judged(tmp_path, server=twice) == [f"sample {WORKER + 9} was taken and never sent"]


@pytest.mark.parametrize(("what", "named"), [("stop", "a stop"), ("break", "a break")])
def test_rejected_is_a_command_under_a_status_that_was_ended(
    what: str, named: str, tmp_path: Path
) -> None:
    takes = TAKES.replace("asks 1 take", f"asks 1 {what}").replace("did 1 take", f"did 1 {what}")
    takes = takes.replace(f"32 issue {GUARD + 1} tap 1 5\n40 end {GUARD + 1} FINISHED DONE 5\n", "")
    server = SERVER.replace(f"35 start {GUARD + 1} tap 35\n36 finish {GUARD + 1} tap 5\n", "")
    works = WORKS.replace("PREEMPTED", "STOPPED")
    assert judged(tmp_path, takes, works, server) == [
        f"server.0.log: command {WORKER + 3} started after {named} by client.1.log had ended it"
    ]
    again = works.replace(f"70 issue {WORKER + 3}", f"65 granted 1 ACTOR\n70 issue {WORKER + 3}")
    assert judged(tmp_path, takes, again, server) == []


def test_a_stop_leaves_the_status_of_who_stopped_and_a_break_leaves_none(tmp_path: Path) -> None:
    stops = TAKES.replace(" take\n", " stop\n")
    works = "0 client 12\n90 done\n"
    server = f"0 serve 4711\n{begins(GUARD + 1, 35, result=5)}"
    assert judged(tmp_path, stops, works, server) == []
    assert judged(tmp_path, stops.replace(" stop\n", " break\n"), works, server) == [
        f"server.0.log: command {GUARD + 1} started after a break by client.1.log had ended it"
    ]


@pytest.mark.parametrize("without", ["", "2 granted 1 ACTOR\n3 released 1\n"])
def test_rejected_is_a_command_without_a_status(without: str, tmp_path: Path) -> None:
    works = WORKS.replace("2 granted 1 ACTOR\n", without)
    assert judged(tmp_path, works=works) == [
        f"server.0.log: command {WORKER + number} was issued without a status, and started"
        for number in (1, 3)
    ]


def test_rejected_is_a_motion_that_outlives_its_client(tmp_path: Path) -> None:
    takes = TAKES[: TAKES.index(f"40 end {GUARD + 1}")]
    server = SERVER.replace(f"36 finish {GUARD + 1} tap 5\n", "").replace(
        f"72 start {WORKER + 3} tap 72\n73 finish {WORKER + 3} tap 8\n",
        f"{3 * SECOND} finish {GUARD + 1} tap -\n",
    )
    works = WORKS.replace(f"{WORKER + 3} FINISHED DONE 8", f"{WORKER + 3} COMMAND_FAILED DENIED -")
    kills = f"{SECOND} kill 11\n"
    assert judged(tmp_path, takes, works, server, kills) == [
        f"server.0.log: command {GUARD + 1} ran on 2.000 s after its client was killed; promised"
        " are 1.5 s"
    ]
    soon = server.replace(f"{3 * SECOND} finish", f"{2 * SECOND} finish")
    assert judged(tmp_path, takes, works, soon, kills) == []
    assert ", 1 killed in motion" in history.read(tmp_path).summary()


@pytest.mark.parametrize(
    ("pretends", "found"),
    [
        ("take", "client.2.log had taken over"),
        ("master", "client.2.log was master"),
        ("password", "client.2.log had a status with another password"),
        ("break", "started after a break by client.2.log"),
    ],
)
@pytest.mark.parametrize("kind", ["clients", "python_clients"])
def test_the_judge_finds_a_client_that_only_pretends(
    kind: str,
    pretends: str,
    found: str,
    build: Path,
    tmp_path: Path,
    env: dict[str, str],
    seed: int,
) -> None:
    """The planted fault: seen from outside, the server ignores what the client asks."""
    plan = Plan("shm", seed, clients=0, pretends=pretends)

    def finds() -> bool:
        return any(found in finding for finding in history.check(history.read(tmp_path)))

    with rampage.rampage(dataclasses.replace(plan, **{kind: 1}), build, tmp_path, env):
        rampage.until(finds, f"the judge finds '{found}'")


@pytest.mark.parametrize("medium", ["shm", "lcm"])
def test_the_motion_of_a_taker_that_is_killed_ends(
    medium: str, build: Path, tmp_path: Path, env: dict[str, str], seed: int
) -> None:
    plan = Plan(medium, seed, clients=1, python_clients=1, change="take")
    with rampage.rampage(plan, build, tmp_path, env) as lab:
        lab.kill_in_motion()
    told = history.read(tmp_path)
    print(f"\n{plan}\n{told.summary()}")
    assert history.check(told) == []
    assert statuses.figures(told).dead_movers > 0
