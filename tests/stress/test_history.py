"""The checker accepts a right history, and rejects each kind of wrong one by name."""

from __future__ import annotations

from pathlib import Path

import history
import pytest

SECOND = 1_000_000_000
ONE = (1 << 32) + 1
TWO = (1 << 32) + 2

CLIENT = f"""
1 open 1 4711
1 granted 1 ACTOR
2 issue {ONE} tap 1 77
3 issue {TWO} file 1 88
4 see {ONE} RUNNING QUEUED
9 end {ONE} FINISHED DONE 77
10 end {TWO} COMMAND_FAILED SERVER_CRASHED -
11 see {ONE} FINISHED DONE
12 done
"""
SERVER = f"""
0 serve 4711
5 start {ONE} tap 5
6 finish {ONE} tap 77
7 start {TWO} file 7
"""
KILLS = """
8 kill 4711
"""


def judged(
    directory: Path, client: str = CLIENT, server: str = SERVER, *more: str, kills: str = KILLS
) -> list[str]:
    (directory / "client.1.log").write_text(client.lstrip())
    for number, text in enumerate((server, *more)):
        (directory / f"server.{number}.log").write_text(text.lstrip())
    (directory / "kills.log").write_text(kills.lstrip())
    return history.check(history.read(directory))


def test_a_right_history_is_accepted_and_summed_up(tmp_path: Path) -> None:
    assert judged(tmp_path) == []
    summary = history.read(tmp_path).summary()
    assert summary == "1 kills, 0 cuts, 2 commands (1 DONE, 1 SERVER_CRASHED)"


def test_what_a_killed_client_had_open_may_lack_an_end(tmp_path: Path) -> None:
    cut_off = CLIENT.replace(f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED -\n", "")
    assert judged(tmp_path, cut_off.replace("12 done\n", "12 do")) == []
    assert judged(tmp_path, cut_off) == [f"command {TWO} of client.1.log has no end"]


def test_time_in_which_the_machine_stood_still_counts_towards_no_bound(tmp_path: Path) -> None:
    late = CLIENT.replace(f"10 end {TWO}", f"{5 * SECOND // 2} end {TWO}")
    (tmp_path / "machine.log").write_text(
        f"5 late 6\n{SECOND} late {SECOND * 3 // 2}\n{SECOND * 9 // 4} late {3 * SECOND}\n"
    )
    assert judged(tmp_path, late) == [
        f"command {TWO} of client.1.log ended as SERVER_CRASHED 2.500 s after its server was"
        " killed; promised are 1.5 s; the machine stood still for 0.750 s of them"
    ]
    just = CLIENT.replace(f"10 end {TWO}", f"{19 * SECOND // 10} end {TWO}")
    assert judged(tmp_path, just) == []
    assert "machine up to 0.75 s late" in history.read(tmp_path).summary()


WRONG_CLIENTS = {
    "a state that changed after the end": (
        f"11 see {ONE} FINISHED DONE",
        f"11 see {ONE} COMMAND_FAILED FAULT",
        f"command {ONE} of client.1.log ended as COMMAND_FAILED/FAULT, FINISHED/DONE",
    ),
    "one that runs again": (
        f"11 see {ONE} FINISHED DONE",
        f"11 see {ONE} RUNNING EXECUTING",
        f"command {ONE} of client.1.log runs again after its end",
    ),
    "one that was waited for and runs": (
        f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED -",
        f"10 end {TWO} RUNNING SENT -",
        f"command {TWO} of client.1.log was waited for and still runs",
    ),
    "an end after the bound": (
        f"10 end {TWO}",
        f"{2 * SECOND} end {TWO}",
        f"command {TWO} of client.1.log ended as SERVER_CRASHED 2.000 s after its server was"
        " killed; promised are 1.5 s",
    ),
    "a result of another call": (
        f"9 end {ONE} FINISHED DONE 77",
        f"9 end {ONE} FINISHED DONE 88",
        f"command {ONE} was given 88 in place of 77",
    ),
    "a success that nobody carried out": (
        f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED -",
        f"10 end {TWO} FINISHED DONE 88",
        f"command {TWO} is FINISHED, its handler did not finish",
    ),
    "a failure with a result": (
        f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED -",
        f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED 88",
        f"command {TWO} is COMMAND_FAILED/SERVER_CRASHED and has a result",
    ),
    "a false proof that it did not start": (
        f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED -",
        f"10 end {TWO} CONNECTION_FAILED NOT_STARTED -",
        f"command {TWO} is CONNECTION_FAILED/NOT_STARTED, and was started",
    ),
    "a refusal of what was carried out": (
        f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED -",
        f"10 end {TWO} COMMAND_FAILED QUEUE_FULL -",
        f"command {TWO} is COMMAND_FAILED/QUEUE_FULL, and was started",
    ),
}


@pytest.mark.parametrize("kind", WRONG_CLIENTS)
def test_rejected_of_clients_is(kind: str, tmp_path: Path) -> None:
    right, wrong, finding = WRONG_CLIENTS[kind]
    assert right in CLIENT
    assert judged(tmp_path, CLIENT.replace(right, wrong)) == [finding]


WRONG_SERVERS = {
    "a command that ran twice": (
        f"7 start {TWO} file 7",
        f"7 start {TWO} file 7\n8 finish {TWO} file -\n9 start {TWO} file 9",
        f"command {TWO}: 2 times 'start'",
    ),
    "a command of nobody": (
        f"7 start {TWO} file 7",
        f"7 start {TWO + 1} file 7",
        f"server.0.log: command {TWO + 1} was never issued",
    ),
    "another operation than was called": (
        f"7 start {TWO} file 7",
        f"7 start {TWO} tap 7",
        f"server.0.log: command {TWO} was file, not tap",
    ),
    "an end without a beginning": (
        f"7 start {TWO} file 7",
        f"7 finish {TWO} file 88",
        f"server.0.log: command {TWO} finished and had not started",
    ),
    "other arguments than were sent": (
        f"7 start {TWO} file 7",
        f"7 start {TWO} file 7\n8 finish {TWO} file 99",
        f"command {TWO} reached its handler with other arguments",
    ),
    "a command beside another": (
        f"6 finish {ONE} tap 77\n7 start {TWO} file 7",
        f"6 start {TWO} file 6\n7 finish {ONE} tap 77",
        f"server.0.log: command {TWO} started while {ONE} ran",
    ),
    "a command before the one that was issued before it": (
        f"5 start {ONE} tap 5\n6 finish {ONE} tap 77\n7 start {TWO} file 7",
        f"4 start {TWO} file 4\n5 finish {TWO} file -\n6 start {ONE} tap 6\n7 finish {ONE} tap 77",
        f"server.0.log: command {ONE} started after {TWO}",
    ),
}


@pytest.mark.parametrize("kind", WRONG_SERVERS)
def test_rejected_of_servers_is(kind: str, tmp_path: Path) -> None:
    right, wrong, finding = WRONG_SERVERS[kind]
    assert right in SERVER
    assert judged(tmp_path, CLIENT, SERVER.replace(right, wrong)) == [finding]


def test_rejected_is_an_end_long_after_the_line_was_cut(tmp_path: Path) -> None:
    late = CLIENT.replace(f"10 end {TWO}", f"{2 * SECOND} end {TWO}")
    cut = f"8 cut {3 * SECOND}\n"
    assert judged(tmp_path, late, kills=cut) == [
        f"command {TWO} of client.1.log ended as SERVER_CRASHED 2.000 s after its line was cut;"
        " promised are 1.5 s"
    ]
    short = f"8 cut {SECOND}\n"
    assert judged(tmp_path, late, kills=short) == [], "it was mended, the command went on"


def test_rejected_is_a_reading_that_did_not_keep_its_place(tmp_path: Path) -> None:
    client = CLIENT.replace(f"issue {TWO} file", f"issue {TWO} gauge")
    server = (
        f"3 start {TWO} gauge 3\n4 finish {TWO} gauge 88\n"
        f"5 start {ONE} tap 5\n6 finish {ONE} tap 77\n"
    )
    assert judged(tmp_path, client, server) == [f"server.0.log: command {ONE} started after {TWO}"]


def test_rejected_is_a_command_that_ran_on_two_servers(tmp_path: Path) -> None:
    second = f"8 start {TWO} file 8\n"
    assert judged(tmp_path, CLIENT, SERVER, second) == [f"command {TWO}: 2 times 'start'"]


LOOKED = CLIENT.replace(f"issue {TWO} file", f"issue {TWO} look")
LOOKS = SERVER.replace("file", "look")


def test_an_idempotent_command_may_run_in_each_life_of_its_server(tmp_path: Path) -> None:
    client = LOOKED.replace("COMMAND_FAILED SERVER_CRASHED -", "FINISHED DONE 88")
    second = f"8 serve 4712\n9 start {TWO} look 9\n9 finish {TWO} look 88\n"
    assert judged(tmp_path, client, LOOKS, second) == []
    assert history.read(tmp_path).sent_again() == 1
    twice = second + f"9 start {TWO} look 9\n9 finish {TWO} look 88\n"
    assert judged(tmp_path, client, LOOKS, twice) == [
        f"command {TWO}: 2 times 'start' in server.1.log",
        f"command {TWO}: 2 times 'finish' in server.1.log",
    ]


def test_rejected_is_a_false_proof_that_an_idempotent_command_never_ran(tmp_path: Path) -> None:
    client = LOOKED.replace("COMMAND_FAILED SERVER_CRASHED", "CONNECTION_FAILED NOT_STARTED")
    second = "8 serve 4712\n"
    assert judged(tmp_path, client, LOOKS, second) == [
        f"command {TWO} is CONNECTION_FAILED/NOT_STARTED, and was started"
    ]


def test_rejected_is_an_idempotent_command_that_nobody_answers_for_too_long(tmp_path: Path) -> None:
    client = LOOKED.replace(f"10 end {TWO}", f"{2 * SECOND} end {TWO}").replace(
        "12 done", f"{3 * SECOND} done"
    )
    assert judged(tmp_path, client, LOOKS) == [
        f"command {TWO} of client.1.log ended as SERVER_CRASHED 2.000 s after its last server was"
        " killed; promised are 1.5 s"
    ]
    second_kill = KILLS + f"{SECOND} kill 4712\n"
    second = "9 serve 4712\n"
    assert judged(tmp_path, client, LOOKS, second, kills=second_kill) == [], "it had gone there"


def test_an_idempotent_command_may_wait_for_another_server_that_stood_still(tmp_path: Path) -> None:
    client = LOOKED.replace(f"10 end {TWO}", f"{3 * SECOND} end {TWO}").replace(
        "12 done", f"{4 * SECOND} done"
    )
    second = "8 serve 4712\n"
    for begin, end in ((2 * SECOND, 4 * SECOND), (9, 2 * SECOND)):
        freeze = f"{begin} freeze 4712 {end}\n"
        assert judged(tmp_path, client, LOOKS, second, kills=KILLS + freeze) == []
    longer = f"{SECOND} freeze 4712 {4 * SECOND}\n"
    assert judged(tmp_path, client, LOOKS, second, kills=KILLS + longer) == [
        f"command {TWO} of client.1.log ended as SERVER_CRASHED 2.000 s after its last server"
        " stood still; promised are 1.5 s"
    ]


def test_a_line_that_nobody_writes_is_no_history(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"client\.1\.log: no line of a client: sleep"):
        judged(tmp_path, CLIENT.replace("1 open 1 4711", "1 sleep 1"))


TOLD = CLIENT.replace(f"10 end {TWO} COMMAND_FAILED SERVER_CRASHED", f"10 end {TWO} {{end}}")
UNKNOWN = TOLD.format(end="COMMAND_FAILED OUTCOME_UNKNOWN")


def started_late(marked: int, *more: str) -> str:
    return SERVER.replace(f"7 start {TWO} file 7", f"{SECOND} start {TWO} file {marked}") + "".join(
        f"{line}\n" for line in more
    )


def test_rejected_is_a_mark_after_a_reported_end(tmp_path: Path) -> None:
    for end in "COMMAND_FAILED OUTCOME_UNKNOWN", "COMMAND_FAILED STOPPED":
        client = TOLD.format(end=end)
        freeze = f"9 freeze 4711 {SECOND - 1}\n"
        assert judged(tmp_path, client, started_late(SECOND // 2 + 10), kills=freeze) == [
            f"server.0.log: command {TWO} ({end.replace(' ', '/')}) was marked 0.500000 s after its"
            " end was told"
        ]


def test_a_freeze_between_mark_and_handler_is_counted_apart(tmp_path: Path) -> None:
    freeze = f"9 freeze 4711 {SECOND - 1}\n"
    assert judged(tmp_path, UNKNOWN, started_late(8), kills=freeze) == []
    assert "1 frozen between mark and handler" in history.read(tmp_path).summary()
    elsewhere = freeze.replace("4711", "4712")
    assert judged(tmp_path, UNKNOWN, started_late(8), kills=elsewhere) == [
        f"server.0.log: command {TWO} (COMMAND_FAILED/OUTCOME_UNKNOWN) began 1.000000 s after its"
        " end was told, and no freeze fell between its mark and its handler"
    ]


def test_a_thread_that_got_no_processor_between_mark_and_handler_is_no_alarm(
    tmp_path: Path,
) -> None:
    """It was, for 1.2 ms, when a line that had been cut was mended as the client gave up."""
    interrupted = SECOND - history.LONGEST_INTERRUPTION_NS
    client = (
        UNKNOWN.replace(f"10 end {TWO}", f"{SECOND - 1} end {TWO}")
        .replace("11 see", f"{SECOND - 1} see")
        .replace("12 done", f"{SECOND} done")
    )
    assert judged(tmp_path, client, started_late(interrupted), kills="") == []
    (finding,) = judged(tmp_path, client, started_late(interrupted - 10), kills="")
    assert "no freeze fell between its mark and its handler" in finding
    # The watcher of the machine was late by the same 10 ns.
    (tmp_path / "machine.log").write_text(f"{interrupted} late {interrupted + 10}\n")
    assert judged(tmp_path, client, started_late(interrupted - 10), kills="") == []


def test_what_the_server_itself_ended_between_mark_and_handler_began_by_then(
    tmp_path: Path,
) -> None:
    stopped = TOLD.format(end="COMMAND_FAILED STOPPED")
    assert judged(tmp_path, stopped, started_late(8), kills="") == []


def test_rejected_are_two_commands_in_vain_after_one_freeze_of_what_runs_one_at_a_time(
    tmp_path: Path,
) -> None:
    three = TWO + 1
    client = UNKNOWN.replace(
        "12 done",
        f"3 issue {three} tap 1 99\n11 end {three} COMMAND_FAILED OUTCOME_UNKNOWN -\n12 done",
    )
    ended = f"{SECOND} finish {TWO} file -"
    freeze = f"9 freeze 4711 {SECOND - 1}\n"
    second = started_late(8, ended, f"{SECOND} start {three} tap 9")
    assert judged(tmp_path, client, second, kills=freeze) == [
        f"process 4711: commands [{TWO}, {three}] began in vain after one freeze"
    ]
    tap, weigh = f"{three} tap", f"{three} weigh"
    client, beside = client.replace(tap, weigh), second.replace(tap, weigh)
    assert judged(tmp_path, client, beside, kills=freeze) == []


def test_a_freeze_is_summed_up(tmp_path: Path) -> None:
    judged(tmp_path, kills=f"{SECOND} freeze 4711 {3 * SECOND}\n")
    assert history.read(tmp_path).summary().startswith("0 kills, 0 cuts, 1 freezes of up to 2.0 s,")
