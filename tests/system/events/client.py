"""Subscribes to the events of ALARM and prints what it hears: the Python half of the pairs in
test_events.py."""

from __future__ import annotations

import sys

import gecos
from button import Alarm


def main(medium: str) -> None:
    alarm = gecos.Lab().create(Alarm, "ALARM", medium=medium)
    alarm.press("long ago", 1, 2).result()
    with alarm.pressed.stream() as pressed:
        print("before:", "an event" if pressed.latest() else "nothing")
        alarm.press("ann", 2.5, 2).result()
        for _ in range(2):
            event = pressed.next(30)
            print(f"{event.value.who} with {event.value.force:g} N, missed {event.lost}")
    with alarm.lifted.stream() as lifted:
        alarm.lift(40).result()
        told = 0
        while told < 40:
            told += 1 + lifted.next(30).lost
        print("lifted:", told)
    try:
        alarm.silenced.stream()
    except gecos.CommandFailed as refused:
        print("without a lease:", refused.detail.name)
    with gecos.actor(alarm), alarm.silenced.stream() as silenced:
        alarm.silence(7).result()
        print("silenced:", silenced.next(30).value.zone)


if __name__ == "__main__":
    main(sys.argv[1])
