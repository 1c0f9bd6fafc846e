"""Serves ALARM: the Python half of the pairs in test_events.py."""

from __future__ import annotations

import gecos
from bell import Alarm_silenced, AlarmServant, Bell_let_go, Bell_pressed


class Ringer(AlarmServant):
    def press(self, who: str, force: float, times: int) -> None:
        for _ in range(times):
            self.publish_pressed(Bell_pressed(who, force))

    def let(self, times: int) -> None:
        for _ in range(times):
            self.publish_let_go(Bell_let_go())

    def silence(self, zone: int) -> None:
        self.publish_silenced(Alarm_silenced(zone))


if __name__ == "__main__":
    gecos.serve({"ALARM": Ringer()}, simulated=True)
