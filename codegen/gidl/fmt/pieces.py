"""Splits text into pieces (tokens, comments, preprocessor lines) and decides their spacing."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gidl.syntax.keywords import USED_BY_LOWER
from gidl.syntax.lexer import TOKEN, directive_line

_KEYWORDS = frozenset(USED_BY_LOWER.values())
_TEMPLATES = frozenset(("sequence", "map", "string", "wstring", "bitfield"))
_NOT_CALLED = frozenset(("case", "raises", "getraises", "setraises", "switch"))


class UnreadableError(ValueError):
    """The text cannot be formatted: its structure is not valid IDL."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line = line


@dataclass(slots=True)
class Piece:
    """A part of the text that is never split: a token, a comment or a preprocessor line."""

    kind: str  # token kind of the lexer ("id", "op", ...), "comment" or "directive"
    text: str
    line: int
    column: int  # counted from 0
    end_line: int
    first_on_line: bool  # only white space precedes the piece on its line
    blank_before: bool
    role: str = ""  # kind of a bracket: "annotation", "params", "group", "angle", "angles"
    spaced: bool = True  # print a space before the piece, unless it begins a line

    @property
    def is_comment(self) -> bool:
        return self.kind == "comment"

    @property
    def is_line_comment(self) -> bool:
        return self.kind == "comment" and self.text.startswith("//")


def scan(text: str) -> list[Piece]:
    """Returns all pieces of `text`, in order."""
    text = text.replace("\r\n", "\n")
    pieces: list[Piece] = []
    at, line, line_start, newlines = 0, 1, 0, 2
    while at < len(text):
        match = TOKEN.match(text, at)
        kind = match.lastgroup if match else None
        if match is None or kind in ("wide", "open_comment"):
            raise UnreadableError(line, "has characters that are not valid IDL")
        body = match.group()
        if kind == "space":
            newlines += body.count("\n")
        else:
            if kind == "directive":
                # The formatter refuses text before a '#'. The parser accepts such a line, but only
                # inside an '#if' whose condition is false.
                if newlines == 0:
                    raise UnreadableError(line, "has text before a '#' on the same line")
                body = text[at : directive_line(text, at)[1]]
            shown = re.sub(r"[ \t\r\f\v]+(?=\n|$)", "", body)
            if kind == "directive":
                shown = re.sub(r"^#[ \t]*(\w+)[ \t]*(?=[^ \t\w]|\b)", r"#\1 ", shown).rstrip(" ")
            pieces.append(
                Piece(
                    kind or "",
                    shown,
                    line,
                    at - line_start,
                    line + body.count("\n"),
                    newlines > 0,
                    newlines > 1 and bool(pieces),
                )
            )
            newlines = 0
        at += len(body)
        if "\n" in body:
            line += body.count("\n")
            line_start = at - len(body) + body.rindex("\n") + 1
    _Spacing(pieces).run()
    return pieces


def _adjoins(piece: Piece, following: Piece) -> bool:
    """Returns whether nothing, not even white space, stands between two pieces."""
    ends = (piece.end_line, piece.column + len(piece.text))
    return ends == (following.line, following.column)


class _Spacing:
    """Decides for each token whether a space precedes it (`spaced`), and for each bracket what it
    encloses (`role`)."""

    def __init__(self, pieces: list[Piece]) -> None:
        self._pieces = [p for p in pieces if p.kind not in ("comment", "directive")]
        self._open: list[str] = []
        self._annotation = False  # the name of an annotation is being read
        self._annotated = False  # the previous piece ends the name of an annotation
        self._in_label = False
        self._unary = False  # the previous piece is a sign

    def run(self) -> None:
        before: Piece | None = None
        for index, piece in enumerate(self._pieces):
            following = self._pieces[index + 1] if index + 1 < len(self._pieces) else None
            self._bracket(before, piece)
            piece.spaced = before is not None and self._spaced(before, piece)
            self._unary = self._is_sign(before, piece)
            self._follow(before, piece, following)
            before = piece

    def _bracket(self, before: Piece | None, piece: Piece) -> None:
        if piece.kind != "op":
            return
        text = piece.text
        if text == "(":
            piece.role = "group"
            if self._annotation:
                piece.role = "annotation"
            elif before is not None and before.kind in ("id", "escaped"):
                piece.role = "group" if before.text in _NOT_CALLED else "params"
            self._open.append(piece.role)
        elif text == "<" and before is not None and before.text in _TEMPLATES:
            piece.role = "angle"
            self._open.append("angle")
        elif text == ">" and self._open[-1:] == ["angle"]:
            piece.role = "angle"
            self._open.pop()
        elif text == ">>" and self._open[-2:] == ["angle", "angle"]:
            piece.role = "angles"
            del self._open[-2:]
        elif text == ")" and self._open:
            piece.role = self._open.pop()

    def _is_sign(self, before: Piece | None, piece: Piece) -> bool:
        if piece.kind != "op" or piece.text not in ("+", "-", "~"):
            return False
        if before is None or before.kind != "op":
            return before is None or (before.kind == "id" and before.text == "case")
        return before.text == "(" or (before.text not in (")", "]") and not before.role)

    def _spaced(self, before: Piece, piece: Piece) -> bool:
        text, last = piece.text, before.text
        is_op, was_op = piece.kind == "op", before.kind == "op"
        if is_op and (text in (",", ";", ")", "]", "[") or piece.role in ("angle", "angles")):
            return False
        if was_op and (last in ("(", "[", "@", "::") or self._unary):
            return False
        if was_op and before.role == "angle" and last == "<":
            return False
        if is_op and text == "::":
            is_name = before.kind == "escaped" or (before.kind == "id" and last not in _KEYWORDS)
            return self._annotated or not (is_name or self._annotation)
        if "annotation" in self._open and ((is_op and text == "=") or (was_op and last == "=")):
            return False
        if is_op and text == "(":
            return piece.role == "group"
        return not (is_op and text == ":" and (self._in_label or last == "default"))

    def _follow(self, before: Piece | None, piece: Piece, following: Piece | None) -> None:
        text = piece.text
        self._annotated = False
        if piece.kind == "op" and text == "@":
            self._annotation = True
        elif self._annotation:
            is_name = piece.kind in ("id", "escaped") or text == "::"
            goes_on = following is not None and (
                (following.kind == "op" and following.text == "(")
                or (following.text == "::" and _adjoins(piece, following))
                or (piece.kind == "op" and text == "::")
            )
            self._annotation = is_name and goes_on
            self._annotated = is_name and not goes_on
        if piece.kind == "id" and text == "case" and (before is None or before.text != "@"):
            self._in_label = True
        elif piece.kind == "op" and text in (":", ";", "{", "}"):
            self._in_label = False
