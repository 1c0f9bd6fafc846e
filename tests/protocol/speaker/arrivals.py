"""Which calls of a session have arrived, and the replies that are kept for it."""

from __future__ import annotations

from .packets import Packet

AHEAD = 1024
KEPT = 256
KEPT_BYTES = 16 << 20


class Arrivals:
    """All counters up to `whole` have arrived, and some of the next 1,024."""

    def __init__(self) -> None:
        self.whole = 0
        self._ahead: set[int] = set()

    def has(self, counter: int) -> bool:
        return counter <= self.whole or counter in self._ahead

    def beyond(self, counter: int) -> bool:
        return counter > self.whole + AHEAD

    def take(self, counter: int) -> None:
        assert not self.has(counter) and not self.beyond(counter)
        self._ahead.add(counter)
        self._close_up()

    def abandon_up_to(self, upto: int) -> None:
        """The client has no call up to it any more: it counts as arrived."""
        if upto > self.whole:
            self.whole = upto
            self._ahead = {counter for counter in self._ahead if counter > upto}
            self._close_up()

    def _close_up(self) -> None:
        while self.whole + 1 in self._ahead:
            self.whole += 1
            self._ahead.remove(self.whole)


class Replies:
    """Replies that the client has not acknowledged; when there are too many, the newest."""

    def __init__(self) -> None:
        self.acknowledged = 0
        self._kept: dict[int, Packet] = {}  # in the order of their coming

    def keep(self, reply: Packet) -> None:
        if reply.counter <= self.acknowledged:
            return
        self._kept[reply.counter] = reply
        while len(self._kept) > 1 and (len(self._kept) > KEPT or self._bytes() > KEPT_BYTES):
            del self._kept[next(iter(self._kept))]

    def _bytes(self) -> int:
        return sum(len(reply.body) for reply in self._kept.values())

    def acknowledge(self, upto: int) -> None:
        self.acknowledged = max(self.acknowledged, upto)
        self._kept = {c: reply for c, reply in self._kept.items() if c > self.acknowledged}

    def forget(self) -> None:
        self._kept.clear()

    def get(self, counter: int) -> Packet | None:
        return self._kept.get(counter)
