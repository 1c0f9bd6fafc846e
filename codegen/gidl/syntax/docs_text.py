"""Documentation comments: finds the declaration of each comment, and the text of the comment
without its marks."""

from __future__ import annotations

import re
from bisect import bisect_left

from gidl.diagnostics.source import Source
from gidl.syntax.lexer import Comment, Lexed

_BEFORE = re.compile(r"/\*\*(?!/)|///(?!/)|/\*!|//!")
_AFTER = re.compile(r"(//[/!]?<?|/\*[*!]?<?)")


class DocReader:
    """Finds the documentation comments before and after a declaration. The offsets of the
    declaration's tokens tell where to look for the comments."""

    def __init__(self, lexed: Lexed, skipped: list[tuple[int, int]]) -> None:
        self._source = lexed.source
        self._comments = [
            c for c in lexed.comments if not any(a <= c.start < b for a, b in skipped)
        ]
        self._starts = [c.start for c in self._comments]
        self._used: set[int] = set()

    def before(self, previous_end: int, start: int) -> str:
        """Returns the text of the last block of documentation comments between the end of the
        previous token and the offset `start`."""
        found = []
        for index in range(bisect_left(self._starts, previous_end), len(self._comments)):
            comment = self._comments[index]
            if comment.start >= start:
                break
            if index in self._used or not _BEFORE.match(comment.text) or "<" in comment.text[3:4]:
                continue
            found.append(comment)
        if not found:
            return ""
        block = [found[-1]]
        for comment in reversed(found[:-1]):
            is_line = comment.text.startswith("//") and block[0].text.startswith("//")
            if not is_line or not _adjacent(self._source, comment, block[0]):
                break
            block.insert(0, comment)
        return _joined([_clean(c.text) for c in block])

    def after(self, end: int) -> str:
        """Returns the text of the comment that follows offset `end` on the same line. The text
        includes the `//` lines below that continue the comment."""
        index = bisect_left(self._starts, end)
        if index >= len(self._comments) or index in self._used:
            return ""
        first = self._comments[index]
        between = self._source.text[end : first.start]
        if first.own_line or between.strip(" \t"):
            return ""
        self._used.add(index)
        lines = [_clean(first.text)]
        last = first
        column = self._source.location(first.start).column
        for follower in range(index + 1, len(self._comments)):
            comment = self._comments[follower]
            same_column = self._source.location(comment.start).column == column
            is_line = comment.text.startswith("//") and comment.own_line
            if not (is_line and same_column and _adjacent(self._source, last, comment)):
                break
            self._used.add(follower)
            lines.append(_clean(comment.text))
            last = comment
        return _joined(lines)

    def head(self, end: int) -> str:
        """Returns the text of the documentation comment at the very beginning of the file."""
        if not self._comments or self._comments[0].start >= end:
            return ""
        return self.before(0, end)


def joined(before: str, after: str) -> str:
    return f"{before}\n{after}" if before and after else before or after


def _adjacent(source: Source, first: Comment, second: Comment) -> bool:
    return source.text[first.end : second.start].count("\n") == 1


def _joined(blocks: list[str]) -> str:
    return "\n".join(blocks).strip("\n")


def _clean(comment: str) -> str:
    """Returns the text of a comment without comment marks and leading stars."""
    if comment.startswith("//"):
        text = _AFTER.sub("", comment, count=1)
        return text.removeprefix(" ").rstrip()
    body = _AFTER.sub("", comment, count=1).removesuffix("*/")
    lines = [line.strip() for line in body.replace("\r", "").split("\n")]
    rest = [line for line in lines[1:] if line]
    if rest and all(line.startswith("*") for line in rest):
        lines[1:] = [line.removeprefix("*").removeprefix(" ") for line in lines[1:]]
    return "\n".join(lines).strip("\n").rstrip()
