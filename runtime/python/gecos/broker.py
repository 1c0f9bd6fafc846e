"""Runs a broker in this process, at this host's well-known address, for tests and examples."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from gecos import _core, shutdown
from gecos.errors import ServeError
from gecos.lab import Lab


class Broker:
    """Serves as this host's broker until `close`. A server of another host that falls silent keeps
    its names for `name_hold` s. Raises ServeError if the host already has a broker."""

    def __init__(self, lab: Lab, *, name_hold: float = 10.0) -> None:
        try:
            self._core = _core.Broker(lab._core, name_hold)
        except RuntimeError as error:
            raise ServeError(str(error)) from None
        shutdown.at_exit(self, shutdown.Turn.BROKERS)

    def close(self) -> None:
        self._core.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
