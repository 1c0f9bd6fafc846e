"""Waits without time-out for a command that never ends by itself: stress_waiter.cpp in Python."""

from __future__ import annotations

import signal

import gecos
from record import Balance, Record, answer_salt, rest_before_another_try, settings
from stress.workbench import Workbench

told_to_end = False


def wait_once(lab: gecos.Lab, setting: dict[str, str], record: Record, turn: int) -> bool:
    """One session; False when there is no server."""
    try:
        bench = lab.create(Workbench, "BENCH", medium=setting["medium"], patience=0.5)
        pid = gecos.describe(bench).result().pid
        record.note(f"open {turn} {pid}")
        lease = gecos.actor(bench, "stress")
        record.note(f"granted {turn} ACTOR")
    except (gecos.CreateError, gecos.LeaseRefused, gecos.CommandFailed, gecos.ConnectionFailed):
        return False
    number = (int(setting["number"]) << 32) + turn
    record.note(f"issue {number} file {turn} {answer_salt(number, 0)}")
    command = bench.file(number, 0, 1e6)
    state = command.wait()
    record.note(f"end {number} {state.name} {command.progress().detail.name} -")
    del lease
    return True


def end(_number: int, _frame: object) -> None:
    global told_to_end
    told_to_end = True


def main() -> None:
    signal.signal(signal.SIGTERM, end)
    setting = settings()
    record = Record(setting["record"])
    balance = Balance()
    print("ready", flush=True)
    with gecos.Lab() as lab:
        turn = 0
        while not told_to_end:
            turn += 1
            if not wait_once(lab, setting, record, turn):
                rest_before_another_try()
    record.note("done")
    balance.close()


if __name__ == "__main__":
    main()
