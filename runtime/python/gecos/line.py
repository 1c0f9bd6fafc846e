"""The connection of a proxy, measured while the program runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from gecos.proxy import Object, demand_proxy


@dataclass(frozen=True, slots=True)
class LineState:
    """The state of the connection of a proxy."""

    medium: str
    bound: float  # s; longest round trip that the interface allows; 0: no limit, no measurement
    round_trip: float | None  # s, as measured last
    degraded: bool  # the round trip has exceeded the bound for a second
    # The number of changes so far. A change is a new value of `degraded`, or a failover that
    # succeeded or failed.
    changes: int
    # The medium that the proxy has left, if the last change was a failover to `medium`; else empty.
    moved_from: str = ""
    why: str = ""  # what the last change was, and why, for people; empty before the first change


def line_state(robot: Object) -> LineState:
    """Returns the state of the connection of `robot`. Does not wait."""
    demand_proxy(robot, "line_state")
    return LineState(*robot._gecos_session.line())


class LineWatch:
    """Reports from now on when the connection of `robot` becomes degraded, and when it recovers. A
    connection is degraded while its round trip exceeds the smallest `latency` that the `@qos` of
    the interface or of a member demands, with the class SOFT_REALTIME or HARD_REALTIME. A single
    slow answer is not reported: all answers within one second must be slow, or all fast. With
    `on_degraded="failover"`, also reports that the proxy has moved to another medium, or why the
    proxy stays on its medium.

    Iterating waits for each change, and ends when the session is lost or closed. Only one thread
    reads at a time.
    """

    def __init__(self, robot: Object) -> None:
        demand_proxy(robot, "LineWatch")
        self._session = robot._gecos_session
        self._name = robot._gecos_session.object_name
        self._changes = line_state(robot).changes

    def next(self, timeout: float | None = None) -> LineState:
        """Waits for the next change and returns the state after the change. After several changes
        since the last call, returns the state after the last change. Raises TimeoutError after
        `timeout` seconds without a change, and EOFError if the session is lost or closed."""
        found = self._session.next_line_change(self._changes, timeout)
        if isinstance(found, tuple):
            state = LineState(*found)
            self._changes = state.changes
            return state
        if found:
            raise TimeoutError(f"the connection of {self._name} did not change within {timeout} s")
        raise EOFError(f"the session with {self._name} is lost or closed")

    def __iter__(self) -> Iterator[LineState]:
        while True:
            try:
                state = self.next()
            except EOFError:
                return
            yield state
