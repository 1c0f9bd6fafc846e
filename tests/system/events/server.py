"""Serves ALARM: the Python half of the pairs in test_events.py."""

from __future__ import annotations

import gecos
from button import Alarm_silenced, AlarmServant, Button_lifted, Button_pressed


class Sender(AlarmServant):
    def press(self, who: str, force: float, times: int) -> None:
        for _ in range(times):
            self.publish_pressed(Button_pressed(who, force))

    def lift(self, times: int) -> None:
        for _ in range(times):
            self.publish_lifted(Button_lifted())

    def silence(self, zone: int) -> None:
        self.publish_silenced(Alarm_silenced(zone))


if __name__ == "__main__":
    gecos.serve({"ALARM": Sender()}, simulated=True)
