"""Breaks lines of generated code. Views mark where lines may be broken, so that no code has to be
parsed.

A *group* is a text of parts in brackets, for example the arguments of a call or the elements of a
list. A part may contain further groups. `laid_out_groups` keeps a line that fits. It breaks a
longer line at its first group, so that each part is on a line of its own. It then breaks the new
lines in the same way, until all lines fit.

    text = f"{name} = call{group(['first', 'call' + group(['second'])])}"
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

WIDTH = 100
_STEP = "    "
# Characters that mark a group and its parts. They are private-use code points.
# `without_marks` removes them from texts that come from users' files.
_OPEN, _NEXT, _CLOSE, _SPACE = "\ue000", "\ue001", "\ue002", "\ue003"
_MARKS = str.maketrans("", "", _OPEN + _NEXT + _CLOSE + _SPACE)


def group(parts: Iterable[str], opening: str = "(", closing: str = ")") -> str:
    """Returns a group of `parts` in brackets, separated by commas. On one line, the group is a text
    such as "(a, b)"."""
    inside = _NEXT.join(parts)
    return f"{opening}{_OPEN}{inside}{_CLOSE}{closing}" if inside else f"{opening}{closing}"


def call(function: str, *arguments: str) -> str:
    return function + group(arguments)


def clauses(parts: Iterable[str], opening: str = "(", closing: str = ")") -> str:
    """Returns a group of `parts` in brackets, separated by spaces, for example "[x for x in y]"."""
    return f"{opening}{_OPEN}{_SPACE.join(parts)}{_CLOSE}{closing}"


def without_marks(text: str) -> str:
    """Returns `text`, which comes from a user, without the characters that mark groups."""
    return text.translate(_MARKS)


def flat(text: str) -> str:
    """Returns `text` with all of its groups on one line."""
    return text.replace(_NEXT, ", ").replace(_SPACE, " ").translate(_MARKS)


def laid_out_groups(text: str, closes_alone: bool) -> str:
    """Returns `text` with the groups of long lines broken. With `closes_alone` (for Python), the
    last part is followed by a comma, and the closing bracket is on a line of its own. Otherwise
    (for C++) the closing bracket directly follows the last part."""
    lines: list[str] = []
    for line in text.split("\n"):
        lines += _laid_out(line, closes_alone) if _OPEN in line else [line]
    return "\n".join(lines)


def _laid_out(line: str, closes_alone: bool) -> list[str]:
    if len(flat(line)) <= WIDTH or _OPEN not in line:
        return [flat(line)]
    indent = line[: len(line) - len(line.lstrip())]
    broken = _first_group(line)
    parts = [f"{part}{broken.comma}" for part in broken.parts]
    if not closes_alone:
        parts[-1] = broken.parts[-1] + broken.tail
    lines = [broken.head]
    for part in parts:
        lines += _laid_out(f"{indent}{_STEP}{part}", closes_alone)
    if closes_alone:
        lines += _laid_out(f"{indent}{broken.tail}", closes_alone)
    return lines


@dataclass(frozen=True, slots=True)
class _Broken:
    head: str  # text of the line up to the opening bracket, inclusive
    parts: list[str]
    tail: str  # rest of the line, from the closing bracket; may contain more groups
    comma: str  # separator after each part; "" between clauses


def _first_group(line: str) -> _Broken:
    start = line.index(_OPEN)
    parts, depth, begin, comma = [], 0, start + 1, ","
    for at in range(start, len(line)):
        letter = line[at]
        depth += (letter == _OPEN) - (letter == _CLOSE)
        if letter == _SPACE and depth == 1:
            comma = ""
        if (letter in (_NEXT, _SPACE) and depth == 1) or depth == 0:
            parts.append(line[begin:at])
            begin = at + 1
        if depth == 0:
            break
    return _Broken(line[:start], parts, line[begin:], comma)
