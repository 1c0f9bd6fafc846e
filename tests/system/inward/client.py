"""Feeds DANCER and prints what became of the samples: the Python half of the pairs in
test_inward.py."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import gecos
from feeder import Dancer, Remark, Step
from words import in_words


def until(holds: Callable[[], bool]) -> None:
    """Asks until `holds`, within half a minute: over lcm a sample may be on its way."""
    end = time.monotonic() + 30
    while not holds() and time.monotonic() < end:
        pass


def main(medium: str) -> None:
    dancer = gecos.Lab().create(Dancer, "DANCER", medium=medium)
    speed, alter = dancer.speed.writer(), dancer.alter.writer()
    try:
        speed.send(1.0)
    except gecos.CommandFailed as refused:
        print("without a lease:", refused.detail.name)
    with gecos.actor(dancer):
        for value in (0.5, 1.0, 1.5):
            speed.send(value)
        came: list[float] = []

        def all_came() -> bool:
            came.extend(dancer.speeds().result())
            return len(came) == 3

        until(all_came)
        print("speeds:", *(f"{value:g}" for value in came))
        try:
            speed.send(2.5)
        except ValueError as refused:
            print("out of range:", refused)

        follow = dancer.follow()
        until(lambda: follow.feedback() is not None)
        alter.feeds(follow)
        for count in range(1, 5):
            alter.send(Step(x=0.025, count=count))
            until(lambda count=count: follow.feedback().count == count)
        alter.send(Step(x=0.0, count=-1))
        print(f"moved: {follow.result():.3f}")
        alter.send(Step(x=0.1, count=8))

        def refused_one() -> bool:
            dancer.steps().result()
            return alter.report().result().command_not_running == 1

        until(refused_one)
        print("alter:", in_words(alter.report().result()))
        speed.send(0.75)

    def fenced() -> bool:
        dancer.speeds().result()
        return speed.report().result().no_status == 1

    until(fenced)
    print("speed:", in_words(speed.report().result()))
    remark = dancer.remark.writer()
    remark.send(Remark(text="good bye"))
    heard: list[str] = []

    def hears() -> bool:
        heard.extend(dancer.remarks().result())
        return bool(heard)

    until(hears)
    print("remark:", heard[0])


if __name__ == "__main__":
    main(sys.argv[1])
