"""Commands a Workbench without pause, whatever dies: stress_client.cpp in Python."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import gecos
from record import Balance, Record, answer, answer_salt, rest_before_another_try, settings
from server import serve
from stress.workbench import Workbench

MOST_OPEN = 16
MOTION_S = 5.0
"""A motion that only its cancellation, or the death of its client, ends before the bound of that
death."""

GOES_ON = frozenset(
    {
        gecos.Detail.DONE,
        gecos.Detail.CANCELED,
        gecos.Detail.QUEUE_FULL,
        gecos.Detail.PREEMPTED,
    }
)
"""Ends of commands after which session and status may go on."""

CHANGES = ["take"] * 5 + ["master"] * 2 + ["password"] * 2 + ["break"]

told_to_end = False


class Client:
    def __init__(self, setting: dict[str, str]) -> None:
        self._medium = setting["medium"]
        self._record = Record(setting["record"])
        self._random = random.Random(int(setting["seed"]))
        self._longest_rest_s = float(setting["rest_ms"]) * 1e-3
        self._number = int(setting["number"]) << 32
        self._session = 0
        self._lease: gecos.Lease | None = None
        self._push: gecos.Writer[int] | None = None
        self._pretends = setting.get("pretends", "")
        self._only_change = setting.get("change", "")
        self._open: deque[tuple[int, gecos.Command[Any], Callable[[object], int]]] = deque()
        self._record.note(f"client {os.getpid()}")

    def run(self, lab: gecos.Lab) -> None:
        bench = None
        while not told_to_end:
            bench = bench or self._connect(lab)
            if bench is None:
                rest_before_another_try()
            elif not self._turn(bench):
                self._finish_all()  # each end is recorded when it comes, not after reconnecting
                bench = None
        self._finish_all()
        self._lease = self._push = None
        self._record.note("done")

    def _connect(self, lab: gecos.Lab) -> Workbench | None:
        try:
            bench = lab.create(Workbench, "BENCH", medium=self._medium, patience=0.5)
            pid = gecos.describe(bench).result().pid
        except (gecos.CreateError, gecos.CommandFailed, gecos.ConnectionFailed):
            return None
        self._session += 1
        self._record.note(f"open {self._session} {pid}")
        try:
            self._push = bench.push.writer()
        except (gecos.CommandFailed, gecos.ConnectionFailed):
            return None
        return bench if self._acquire(bench) else None

    def _acquire(self, bench: Workbench) -> bool:
        try:
            self._lease = gecos.actor(bench, "stress")
        except (gecos.LeaseRefused, gecos.ConnectionFailed):
            return False
        self._record.note(f"granted {self._session} ACTOR")
        return True

    def _release(self) -> None:
        assert self._lease is not None
        self._lease.release()
        self._record.note(f"released {self._session}")

    def _ask(self, what: str, ask: Callable[[], gecos.Command[None]]) -> bool:
        """Returns whether the server has done it. A client that pretends does not ask."""
        self._record.note(f"asks {self._session} {what}")
        try:
            if what != self._pretends:
                ask().result()
        except (gecos.CommandFailed, gecos.ConnectionFailed):
            return False
        self._record.note(f"did {self._session} {what}")
        return True

    def _take_over(self, bench: Workbench) -> None:
        """Moves alone for a while. Who is killed meanwhile leaves a motion that runs."""
        if not self._ask("take", lambda: gecos.take_over(bench)):
            return
        motion = self._issue(bench, "file", MOTION_S)
        motion.wait(self._random.random() * 0.2)
        motion.cancel()
        motion.wait()
        self._issue(bench, "tap")
        self._finish_all()
        self._ask("give", lambda: gecos.give_back(bench))

    def _be_master(self, bench: Workbench) -> bool:
        """Stops the others, is master if none of them was faster, and then an actor again."""
        if not self._ask("stop", lambda: gecos.stop(bench)):
            return False
        try:
            lease = None if self._pretends == "master" else gecos.master(bench)
        except (gecos.LeaseRefused, gecos.ConnectionFailed):
            return True
        self._record.note(f"granted {self._session} MASTER")
        self._command_for_a_while(bench)
        if lease is not None:
            lease.release()
        self._release()
        self._issue(bench, "tap")  # is refused
        return self._acquire(bench)

    def _use_another_password(self, bench: Workbench) -> bool:
        """Stops the others, has a status with a password of its own if none of them was faster, and
        is then an actor as the others again."""
        if not self._ask("stop", lambda: gecos.stop(bench)):
            return False
        if self._pretends != "password":
            self._release()
            try:
                self._lease = gecos.actor(bench, f"client {os.getpid()}")
            except (gecos.LeaseRefused, gecos.ConnectionFailed):
                return self._acquire(bench)
        self._record.note(f"granted {self._session} ACTOR own")
        self._command_for_a_while(bench)
        self._release()
        return self._acquire(bench)

    def _command_for_a_while(self, bench: Workbench) -> None:
        for _ in range(4):
            self._issue(bench)
        self._issue(bench, "file", self._random.random() * 0.05)
        self._issue(bench, "tap")
        self._finish_all()

    def _change_status(self, bench: Workbench) -> bool:
        """False: the status is lost."""
        which = self._only_change or self._random.choice(CHANGES)
        if which == "take":
            self._take_over(bench)
            return True
        if which == "master":
            return self._be_master(bench)
        if which == "password":
            return self._use_another_password(bench)
        why = "a test of the judge"
        return not self._ask("break", lambda: gecos.break_status(bench, why))

    def _turn(self, bench: Workbench) -> bool:
        """False: the session, or the status, is lost."""
        while len(self._open) < MOST_OPEN:
            self._issue(bench)
        if self._random.random() < 0.2:
            self._send()
        if self._random.random() < 0.05:
            self._random.choice(self._open)[1].cancel()
        changes = self._random.random() < (0.2 if self._only_change else 0.02)
        if changes and not self._change_status(bench):
            return False
        if self._random.random() < 0.1:
            time.sleep(self._random.random() * self._longest_rest_s)
        return not self._open or self._finish()

    def _send(self) -> None:
        assert self._push is not None
        self._number += 1
        self._record.note(f"send {self._number} {self._session}")
        with contextlib.suppress(gecos.CommandFailed, gecos.ConnectionFailed):
            self._push.send(self._number)

    def _issue(
        self, bench: Workbench, which: str | None = None, seconds: float = 0.0
    ) -> gecos.Command[Any]:
        self._number += 1
        number, salt = self._number, self._random.getrandbits(63) - (1 << 62)
        if which is None:
            which = self._random.choice(["tap", "file", "gauge", "look", "weigh"])
            seconds = self._random.random() * 5e-3
        load = self._random.randbytes(self._random.randrange(200))
        wanted = answer(number, load) if which == "weigh" else answer_salt(number, salt)
        self._record.note(f"issue {number} {which} {self._session} {wanted}")
        command: gecos.Command[Any]
        if which == "weigh":
            command = bench.weigh(number, load)
        elif which == "file":
            command = bench.file(number, salt, seconds)
        else:
            command = getattr(bench, which)(number, salt)

        def shown(result: object) -> int:
            return answer(number, result) if isinstance(result, bytes) else int(str(result))

        self._open.append((number, command, shown))
        return command

    def _finish_all(self) -> None:
        while self._open:
            self._finish()

    def _finish(self) -> bool:
        number, command, shown = self._open.popleft()
        result = "-"
        with contextlib.suppress(gecos.CommandFailed, gecos.ConnectionFailed):
            result = str(shown(command.result()))
        detail = command.progress().detail
        self._record.note(f"end {number} {command.state.name} {detail.name} {result}")
        return detail in GOES_ON


def end(_number: int, _frame: object) -> None:
    global told_to_end
    told_to_end = True


def main() -> None:
    signal.signal(signal.SIGTERM, end)
    setting = settings()
    client = Client(setting)
    serves = Record(setting["serve"]) if "serve" in setting else None
    balance = Balance()
    with contextlib.ExitStack() as stack:
        if serves is not None:
            here = stack.enter_context(gecos.Lab())
            serve(stack.enter_context(gecos.Server(here)), setting["medium"], serves)
        print("ready", flush=True)
        client.run(stack.enter_context(gecos.Lab()))
    balance.close()


if __name__ == "__main__":
    main()
