"""Bad lines between the speaker's server and our clients."""

from __future__ import annotations

import random
from collections.abc import Callable

from speaker.listener import Line


class Lossy(Line):
    """Loses a fifth, doubles a fifth, and lets later datagrams overtake a third; by its seed."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._late: dict[bool, list[bytes]] = {True: [], False: []}
        self.lost = 0

    def inward(self, payload: bytes) -> list[bytes]:
        return self._pass(True, payload)

    def outward(self, payload: bytes) -> list[bytes]:
        return self._pass(False, payload)

    def _pass(self, inward: bool, payload: bytes) -> list[bytes]:
        late = self._late[inward]
        if self._random.random() < 0.2:
            self.lost += 1
            return []
        if self._random.random() < 0.3 and len(late) < 8:
            late.append(payload)
            return []
        out = [payload, *late]
        late.clear()
        return out * 2 if self._random.random() < 0.2 else out


class Through(Line):
    """What goes out becomes what `change` makes of it."""

    def __init__(self, change: Callable[[bytes], list[bytes]]) -> None:
        self._change = change

    def outward(self, payload: bytes) -> list[bytes]:
        return self._change(payload)


class Mute(Line):
    """The server hears, and is not heard."""

    def outward(self, payload: bytes) -> list[bytes]:
        return []
