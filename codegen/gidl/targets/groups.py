"""Lines that may be broken: a view says where, and nothing reads generated text to find out.

A *group* is a pair of brackets around parts: the arguments of a call, the elements of a list. It is
a piece of text like any other, and may stand inside a part of another group. `laid_out_groups`
prints a line flat where it fits, else breaks its first group and then, where need be, those inside.

    text = f"{name} = call{group(['first', 'call' + group(['second'])])}"
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

WIDTH = 100
_STEP = "    "
# Code points for private use. `without_marks` keeps them out of what users write.
_OPEN, _NEXT, _CLOSE, _SPACE = "\ue000", "\ue001", "\ue002", "\ue003"
_MARKS = str.maketrans("", "", _OPEN + _NEXT + _CLOSE + _SPACE)


def group(parts: Iterable[str], opening: str = "(", closing: str = ")") -> str:
    """Text of `parts` between brackets, separated by commas. Flat: "(a, b)"."""
    inside = _NEXT.join(parts)
    return f"{opening}{_OPEN}{inside}{_CLOSE}{closing}" if inside else f"{opening}{closing}"


def call(function: str, *arguments: str) -> str:
    return function + group(arguments)


def clauses(parts: Iterable[str], opening: str = "(", closing: str = ")") -> str:
    """The same for parts that spaces separate: "[x for x in y]"."""
    return f"{opening}{_OPEN}{_SPACE.join(parts)}{_CLOSE}{closing}"


def without_marks(text: str) -> str:
    """`text` of a user, so that nothing in it is taken for a group."""
    return text.translate(_MARKS)


def flat(text: str) -> str:
    """`text` with all of its groups on one line."""
    return text.replace(_NEXT, ", ").replace(_SPACE, " ").translate(_MARKS)


def laid_out_groups(text: str, closes_alone: bool) -> str:
    """`text` with the groups of long lines broken. `closes_alone` is the style of Python: a comma
    after the last part, and the closing bracket on a line of its own; C++ closes after the part."""
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
    head: str  # with the opening bracket
    parts: list[str]
    tail: str  # with the closing bracket; may hold more groups
    comma: str  # after each part; "" between clauses


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
