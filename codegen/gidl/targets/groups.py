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
_OPEN, _NEXT, _CLOSE = "\ue000", "\ue001", "\ue002"
_MARKS = str.maketrans("", "", _OPEN + _NEXT + _CLOSE)


def group(parts: Iterable[str], opening: str = "(", closing: str = ")") -> str:
    """Text of `parts` between brackets, separated by commas. Flat: "(a, b)"."""
    inside = _NEXT.join(parts)
    return f"{opening}{_OPEN}{inside}{_CLOSE}{closing}" if inside else f"{opening}{closing}"


def without_marks(text: str) -> str:
    """`text` of a user, so that nothing in it is taken for a group."""
    return text.translate(_MARKS)


def flat(text: str) -> str:
    """`text` with all of its groups on one line."""
    return text.replace(_NEXT, ", ").translate(_MARKS)


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
    parts = [f"{part}," for part in broken.parts]
    if not closes_alone:
        parts[-1] = parts[-1].removesuffix(",") + broken.tail
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


def _first_group(line: str) -> _Broken:
    start = line.index(_OPEN)
    parts, depth, begin = [], 0, start + 1
    for at in range(start, len(line)):
        letter = line[at]
        depth += (letter == _OPEN) - (letter == _CLOSE)
        if (letter == _NEXT and depth == 1) or depth == 0:
            parts.append(line[begin:at])
            begin = at + 1
        if depth == 0:
            break
    return _Broken(line[:start], parts, line[begin:])
