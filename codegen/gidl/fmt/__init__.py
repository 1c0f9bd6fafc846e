"""Prints a .gidl file in one canonical layout.

The formatter decides all white space, except for three choices of the author: blank lines (at most
one in a row), whether a short body is on one line, and line breaks after annotations and `(`. It
keeps every token and every comment, in order; `layout` verifies this before it returns a text.
"""

from __future__ import annotations

from gidl.fmt.pieces import Piece, UnreadableError, scan
from gidl.fmt.printer import printed
from gidl.fmt.tree import structure

__all__ = ["UnreadableError", "layout"]


def layout(text: str) -> str:
    """Returns `text` in the canonical layout. Applying `layout` to the result changes nothing. @pre
    `text` parses. Raises UnreadableError with the line if braces do not match, for example because
    an `#if` contains half of a body."""
    pieces = scan(text)
    result = printed(structure(pieces))
    _prove(pieces, scan(result))
    return result


def _prove(before: list[Piece], after: list[Piece]) -> None:
    """Raises UnreadableError if formatting has changed more than white space. `before` are the
    pieces of the given text, and `after` are those of the formatted text; they must be equal."""
    old, new = _essence(before), _essence(after)
    if old != new:
        at = next((i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), -1)
        line = before[min(at, len(before) - 1)].line if before else 1
        raise UnreadableError(line, "cannot be formatted without changing its meaning")


def _essence(pieces: list[Piece]) -> list[str]:
    found: list[str] = []
    for piece in pieces:
        if piece.is_comment:
            found.append("\n".join(line.strip() for line in piece.text.split("\n")))
        elif piece.text == ">>":
            found += [">", ">"]
        else:
            found.append(piece.text)
    return found
