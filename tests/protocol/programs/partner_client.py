"""Does what each line of its input says, and prints what came of it: partner_client.cpp in Python.

open NAME [PATIENCE]    deadline SECONDS    acquire    release    follow    close
issue TAG OPERATION [ARGUMENT]    cancel TAG    look TAG    name TAG
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable

import gecos
import numpy as np
from speaking.partner import (
    Gear,
    Load,
    Mark,
    Partner,
    Partner_exchange_result,
    Slip,
    Step,
    Stuck,
    Things,
    Whole,
)

_printing = threading.Lock()


def say(text: str) -> None:
    with _printing:
        sys.stdout.write(" ".join(text.split("\n")) + "\n")
        sys.stdout.flush()


def constants() -> Things:
    """What the speaker's test writes by itself, too."""
    numbers = Whole(True, 0xA5, "g", -7, -30000, 60000, -(2**31), 2**32 - 1, -(2**63), 2**64 - 1)
    numbers.rough, numbers.fine, numbers.words = 0.5, -1e300, "grüß Gott"
    return Things(
        numbers=numbers,
        pace=Gear.RUN,
        grid=np.array([[1, -2, 3], [4, 5, -6]], dtype=np.int16),
        words=["", "two"],
        maybe=2.25,
        marks=[Mark(1.0, 2.0, "here"), Mark(3.0, 4.0, "there")],
        counts={"b": 2, "a": -1},
        carried=Load(Gear.RUN, "sack"),
        beside=Slip(9, "beside", 4),
    )


class Client:
    def __init__(self, lab: gecos.Lab) -> None:
        self._lab = lab
        self._partner: Partner | None = None
        self._limit: float | None = None
        self._lease: gecos.Lease | None = None
        self._streams: list[tuple[gecos.Stream[float], threading.Thread]] = []
        self._things = constants()
        self._commands: dict[str, gecos.Command] = {}

    def obey(self, verb: str, words: list[str]) -> None:
        getattr(self, f"_{verb}")(*words)

    def _open(self, name: str, patience: str = "2") -> None:
        try:
            self._partner = self._lab.create(Partner, name, patience=float(patience))
            say(f"opened {name}")
        except gecos.CreateError as error:
            say(f"not opened: {error}")

    def _close(self) -> None:
        self._commands.clear()
        for stream, reader in self._streams:
            stream.close()
            reader.join()
        self._streams.clear()
        self._partner = self._lease = self._limit = None
        say("closed")

    def _deadline(self, seconds: str) -> None:
        self._limit = float(seconds)

    def _acquire(self) -> None:
        try:
            self._lease = gecos.actor(self._open_one())
            say(f"acquired {self._lease.epoch}")
        except (gecos.LeaseRefused, gecos.ConnectionFailed) as error:
            say(f"not acquired: {error}")

    def _release(self) -> None:
        assert self._lease is not None
        self._lease.release()
        say("released")

    def _issue(self, tag: str, operation: str, argument: str = "") -> None:
        command, show = self._called(operation, argument)
        self._commands[tag] = command
        command.add_done_callback(lambda ended: self._tell_end(tag, ended, show))

    def _open_one(self) -> Partner:
        assert self._partner is not None
        if self._limit is None:
            return self._partner
        return gecos.with_deadline(self._partner, self._limit)

    def _called(
        self, operation: str, argument: str
    ) -> tuple[gecos.Command, Callable[[object], str]]:
        partner = self._open_one()
        if operation == "exchange":
            return partner.exchange(self._things, "ping"), self._keep
        if operation == "mirror":
            load = bytes(i * 7 % 256 for i in range(int(argument)))
            right = bytes(reversed(load))
            return partner.mirror(load), lambda got: "right" if got == right else "wrong"
        if operation == "level":
            return partner.level(), str
        if operation in ("stop", "ping"):
            return getattr(gecos, operation)(partner), lambda _: "-"
        if operation == "describe":
            return gecos.describe(partner), lambda about: str(getattr(about, "name", about))
        if operation == "outcome":
            asked = gecos.outcome(partner, argument)
            return asked, lambda got: str(getattr(getattr(got, "detail", got), "name", got))
        return getattr(partner, operation)(int(argument)), str

    def _keep(self, got: object) -> str:
        assert isinstance(got, Partner_exchange_result)
        self._things = got.result
        return f"{got.word} {got.count}"

    def _tell_end(self, tag: str, ended: gecos.Command, show: Callable[[object], str]) -> None:
        try:
            shown = show(ended.result())
        except Stuck as stuck:
            shown = f"Stuck {stuck.at} {stuck.why}"
        except (gecos.CommandFailed, gecos.ConnectionFailed) as failed:
            shown = failed.text
        say(f"{tag} ended {ended.state.name} {ended.progress().detail.name} {shown}")

    def _cancel(self, tag: str) -> None:
        self._commands[tag].cancel()

    def _look(self, tag: str) -> None:
        at = self._commands[tag].progress()
        step = self._commands[tag].feedback()
        told = f" {step.at} {step.where}" if isinstance(step, Step) else ""
        say(f"{tag} stands {at.detail.name} {at.position} {at.fraction:g}{told}")

    def _name(self, tag: str) -> None:
        say(f"{tag} is {self._commands[tag].id}")

    def _follow(self) -> None:
        try:
            stream = self._open_one().level.stream()
        except (gecos.CommandFailed, gecos.ConnectionFailed) as error:
            say(f"not followed: {error}")
            return
        say("follows")
        reader = threading.Thread(target=self._read, args=(stream,))
        reader.start()
        self._streams.append((stream, reader))

    def _read(self, stream: gecos.Stream[float]) -> None:
        try:
            for sample in stream:
                say(f"sample {sample.sequence} {sample.lost} {sample.value:g}")
            say("stream closed")
        except gecos.StreamLost as error:
            say(f"stream lost: {error}")


def main() -> None:
    with gecos.Lab() as lab:
        client = Client(lab)
        say("ready")
        for line in sys.stdin:
            verb, *words = line.split()
            client.obey(verb, words)
        client.obey("close", [])
    say("done")


if __name__ == "__main__":
    main()
