"""Source texts, and locations in source texts."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field

from gidl.model import Location

MAX_BYTES = 4 * 1024 * 1024


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """One source file. `path` is the path that `#include` needs, and `shown` is the path that
    messages print."""

    path: str
    shown: str
    text: str
    foreign: tuple[int, ...] = ()  # offsets of bytes that are not UTF-8, read as Latin-1
    _starts: list[int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        starts = [0]
        at = self.text.find("\n")
        while at >= 0:
            starts.append(at + 1)
            at = self.text.find("\n", at + 1)
        object.__setattr__(self, "_starts", starts)

    def line_of(self, offset: int) -> int:
        return bisect_right(self._starts, offset)

    def location(self, offset: int) -> Location:
        line = self.line_of(offset)
        return Location(self.path, line, offset - self._starts[line - 1] + 1)

    def line(self, number: int) -> str:
        """Returns the text of a line without its newline. Lines are counted from 1."""
        if not 1 <= number <= len(self._starts):
            return ""
        start = self._starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start : len(self.text) if end < 0 else end].rstrip("\r")


@dataclass(frozen=True, slots=True)
class Span:
    """A range of offsets in a source; `end` is exclusive."""

    source: Source
    start: int
    end: int

    @property
    def location(self) -> Location:
        return self.source.location(self.start)

    def to(self, other: Span) -> Span:
        return Span(self.source, self.start, max(self.end, other.end))
