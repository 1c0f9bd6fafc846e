"""Prints bodies and items of a .gidl file as text."""

from __future__ import annotations

from dataclasses import dataclass, field

from gidl.fmt.columns import align
from gidl.fmt.pieces import Piece
from gidl.fmt.tree import Body, Item

WIDTH = 120
_STEP = 2  # columns of indentation per level
_CONTINUED = 4  # columns of extra indentation for continuation lines


@dataclass(slots=True)
class Laid:
    """The printed lines of an item, and the comments to append to its last line."""

    item: Item
    lines: list[str]
    comments: str = ""  # text of the comments after the last line
    section: int = 0  # items with the same section number are aligned in columns


def printed(root: Body) -> str:
    lines = _elements(root, 0)
    return "\n".join(lines) + "\n" if lines else ""


def _elements(body: Body, indent: int) -> list[str]:
    """Returns the lines of all elements of a body. Elements that form a table are aligned in
    columns."""
    laid: list[Laid | list[str]] = []
    section = 0
    for index, element in enumerate(body.elements):
        first = element if isinstance(element, Piece) else element.first
        if first.blank_before and (index > 0 or body.keyword in ("module", "file")):
            laid.append([""])
            section += 1
        if isinstance(element, Piece):
            laid.append(_alone(element, indent))
            continue
        if first.kind == "directive":
            laid.append(Laid(element, [first.text], _behind(element), section))
            continue
        lines = _item(element, indent, body.keyword)
        if len(lines) > 1:
            section += 1
        laid.append(Laid(element, lines, _behind(element), section))
        if len(lines) > 1:
            section += 1
    items = [part for part in laid if isinstance(part, Laid)]
    for run in _runs(items):
        align(body.keyword, run, indent)
    columns = {
        number: max(len(part.lines[-1]) for part in items if _speaks(part, number)) + 2
        for number in {part.section for part in items if part.comments}
    }
    lines = []
    for part in laid:
        if isinstance(part, list):
            lines += part
        else:
            lines += part.lines[:-1]
            lines += _with_comments(part, columns.get(part.section, 0))
    return lines


def _speaks(part: Laid, section: int) -> bool:
    return part.section == section and bool(part.comments)


def _runs(items: list[Laid]) -> list[list[Laid]]:
    """Returns the runs of consecutive one-line items without a blank line between them."""
    runs: dict[int, list[Laid]] = {}
    for part in items:
        if len(part.lines) == 1 and part.item.first.kind != "directive":
            runs.setdefault(part.section, []).append(part)
    return list(runs.values())


def _behind(item: Item) -> str:
    return " ".join(c.text for c in item.trailing)


def _with_comments(part: Laid, column: int) -> list[str]:
    last = part.lines[-1]
    if not part.comments:
        return [last]
    first, *more = part.comments.split("\n")
    lines = [f"{last.ljust(column)}{first}"]
    lines += _shifted(more, column - part.item.trailing[0].column, column)
    lines += [" " * column + c.text for c in part.item.continued]
    return lines


def _alone(piece: Piece, indent: int) -> list[str]:
    """Returns the output lines for a preprocessor directive, or for a comment without code on its
    line."""
    if piece.kind == "directive":
        return piece.text.split("\n")
    first, *more = piece.text.split("\n")
    return [" " * indent + first, *_shifted(more, indent - piece.column, indent)]


def _shifted(lines: list[str], shift: int, column: int) -> list[str]:
    """Returns the second and later lines of a comment, shifted by as many columns as its first
    line. If all these lines begin with a star, they are aligned below the star of `/*`."""
    stripped = [line.strip() for line in lines]
    if stripped and all(line.startswith("*") for line in stripped):
        return [" " * (column + 1) + line for line in stripped]
    moved = []
    for line, bare in zip(lines, stripped, strict=True):
        was = len(line.expandtabs(4)) - len(line.expandtabs(4).lstrip())
        moved.append(" " * max(0, was + shift) + bare if bare else "")
    return moved


# ---------------------------------------------------------------------------------------------
# Printing of one item


def _item(item: Item, indent: int, keyword: str) -> list[str]:
    """Returns the lines of an item. A line that is too long is broken into several lines."""
    breaks_kept = keyword != "("
    split = False
    while True:
        lines = _Writer(indent, breaks_kept, split).write(item)
        if max(map(len, lines)) <= WIDTH:
            return lines
        whole = [b for b in item.bodies if not b.broken and b.elements]
        braces = [b for b in whole if b.keyword != "("]
        if braces:
            braces[0].broken = True
        elif not split and breaks_kept and 0 < leading(item) < len(item.parts):
            split = True
        elif whole:
            whole[0].broken = True
        else:
            return lines


def leading(item: Item) -> int:
    """Returns how many parts at the beginning of an item are comments or belong to annotations."""
    parts = item.parts
    at = 0
    while at < len(parts):
        part = parts[at]
        if isinstance(part, Body):
            return at
        if not part.is_comment:
            following = parts[at + 1] if at + 1 < len(parts) else None
            if part.text != "@" or not isinstance(following, Piece):
                return at
            if following.text == "annotation":
                return at
            at = _annotation_end(parts, at + 1) - 1
        at += 1
    return at


def _annotation_end(parts: list[Piece | Body], at: int) -> int:
    """Returns the index of the part after the annotation whose name begins at index `at`."""
    at += 1
    while (
        at + 1 < len(parts)
        and isinstance(part := parts[at], Piece)
        and part.text == "::"
        and not part.spaced
    ):
        at += 2
    opening = parts[at] if at < len(parts) else None
    if not (isinstance(opening, Piece) and opening.role == "annotation" and opening.text == "("):
        return at
    depth = 0
    while at < len(parts):
        part = parts[at]
        at += 1
        if isinstance(part, Piece) and part.kind == "op":
            depth += (part.text == "(") - (part.text == ")")
            if depth == 0:
                break
    return at


@dataclass(slots=True)
class _Writer:
    indent: int
    breaks_kept: bool  # whether to keep the author's line breaks after annotations
    split: bool  # whether to break the line between the annotations and the declaration
    lines: list[str] = field(default_factory=list)
    now: str = ""
    must_break: bool = False

    def write(self, item: Item) -> list[str]:
        head = leading(item)
        for index, part in enumerate(item.parts):
            piece = part if isinstance(part, Piece) else part.opening
            in_head = index <= head
            if self._breaks(piece, index, head, item):
                self._line(self.indent if in_head else self.indent + _CONTINUED)
            if isinstance(part, Body):
                self._body(part)
            else:
                self._piece(part)
        self.lines.append(self.now)
        return self.lines

    def _breaks(self, piece: Piece, index: int, head: int, item: Item) -> bool:
        if index == 0:
            self.now = " " * self.indent
            return False
        if self.must_break or piece.kind == "directive":
            return True
        if piece.is_comment and piece.first_on_line:
            return True
        if self.breaks_kept and index <= head and piece.first_on_line:
            return index == head or piece.text == "@" or piece.is_comment
        return self.split and index == head

    def _line(self, indent: int) -> None:
        if self.now.strip():
            self.lines.append(self.now.rstrip())
        self.now = " " * indent
        self.must_break = False

    def _piece(self, piece: Piece) -> None:
        if piece.kind == "directive":
            self.lines += piece.text.split("\n")
            self.now = ""
            self.must_break = True
            return
        if piece.is_comment:
            alone = not self.now.strip()
            first, *more = piece.text.split("\n")
            column = len(self.now) if alone else len(self.now) + 2 - (not piece.is_line_comment)
            self.now = self.now.ljust(column) + first
            if more:
                moved = _shifted(more, column - piece.column, column)
                self.lines += [self.now, *moved[:-1]]
                self.now = moved[-1]
            self.must_break = piece.is_line_comment or (alone and piece.first_on_line)
            return
        self._space(piece)
        self.now += piece.text

    def _space(self, piece: Piece) -> None:
        if self.now.strip() and _spaced(self.now, piece):
            self.now += " "

    def _body(self, body: Body) -> None:
        assert body.closing is not None
        self._space(body.opening)
        if not body.broken:
            self.now += inline(body)
            return
        self.now += body.opening.text
        first_line = len(self.lines)
        for comment in body.after_opening:
            self.must_break = False
            gap = "  " if comment.is_line_comment else " "
            first, *more = comment.text.split("\n")
            column = len(self.now) + len(gap)
            self.now += gap + first
            if more:
                moved = _shifted(more, column - comment.column, column)
                self.lines += [self.now, *moved[:-1]]
                self.now = moved[-1]
        self.lines.append(self.now)
        self.lines += _elements(body, self.indent + _STEP)
        assert first_line < len(self.lines)
        self.now = " " * self.indent + body.closing.text
        self.must_break = False


def inline(body: Body) -> str:
    """Returns the text of a body on one line, with its brackets."""
    assert body.closing is not None
    comments = [c.text for c in body.after_opening]
    words = comments + [inline_item(item) for item in body.items]
    inside = " ".join(words)
    if body.keyword == "(" or not inside:
        return f"{body.opening.text}{inside}{body.closing.text}"
    return f"{{ {inside} }}"


def inline_item(item: Item) -> str:
    text = ""
    for part in item.parts:
        piece = part if isinstance(part, Piece) else part.opening
        if text and (piece.is_comment or _spaced(text, piece)):
            text += " "
        text += part.text if isinstance(part, Piece) else inline(part)
    return " ".join([text, *(c.text for c in item.trailing)])


def _spaced(before: str, piece: Piece) -> bool:
    behind_comment = before.endswith("*/") and piece.text not in (",", ";", ")")
    return piece.spaced or behind_comment
