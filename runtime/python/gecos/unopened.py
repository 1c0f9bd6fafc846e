"""The attributes of a proxy whose samples a program reads or sends after opening a stream."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING


class Unopened:
    """Answers every use that needs the opened stream with an exception that says how to open it."""

    __slots__ = ()

    @abstractmethod
    def _to_open(self) -> str:
        """Returns what the attribute is, and how a program opens its stream."""

    if not TYPE_CHECKING:  # a type checker would allow every attribute, and every loop

        def __getattr__(self, name):
            if name.startswith("_"):
                return object.__getattribute__(self, name)  # raises AttributeError
            raise AttributeError(f"{self._to_open()}; the attribute itself has no {name!r}")

        def __iter__(self):
            raise TypeError(self._to_open())

        def __aiter__(self):
            raise TypeError(self._to_open())
