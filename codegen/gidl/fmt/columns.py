"""Aligns the members of a struct, and consecutive short declarations of one kind, in columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gidl.fmt.pieces import Piece
from gidl.fmt.tree import Body, Item

if TYPE_CHECKING:
    from gidl.fmt.printer import Laid

_WIDEST_PADDING = 12  # columns; lines that would need more stay unaligned
_PRIMITIVES = frozenset(
    ("unsigned", "long", "short", "double", "float", "boolean", "octet", "char", "int8", "uint8",
     "int16", "uint16", "int32", "uint32", "int64", "uint64")
)  # fmt: skip


def align(keyword: str, run: list[Laid], indent: int) -> None:
    """Aligns consecutive one-line items by padding their lines."""
    if keyword in ("struct", "exception"):
        _members(run, indent)
    elif keyword in ("module", "interface", "file"):
        _heads(run)


def _members(run: list[Laid], indent: int) -> None:
    """Aligns the types and names of members in columns. Members with annotations and members
    without annotations are aligned separately."""
    plain: list[tuple[Laid, list[str]]] = []
    annotated: list[tuple[Laid, list[str]]] = []
    for laid in run:
        cells = _cells(laid.item)
        if cells is None:
            _pad(annotated, indent)
            annotated = []
        elif cells[0]:
            annotated.append((laid, cells))
        else:
            _pad(annotated, indent)
            annotated = []
            plain.append((laid, cells[1:]))
    _pad(annotated, indent)
    _pad(plain, indent)


def _pad(rows: list[tuple[Laid, list[str]]], indent: int) -> None:
    if len(rows) < 2:
        return
    for column in range(len(rows[0][1]) - 1):
        widths = [len(cells[column]) for _, cells in rows]
        if max(widths) - min(widths) > _WIDEST_PADDING:
            return
        for _, cells in rows:
            cells[column] = cells[column].ljust(max(widths))
    for laid, cells in rows:
        laid.lines = [" " * indent + " ".join(cells)]


def _cells(item: Item) -> list[str] | None:
    """Returns the annotations, the type and the names of a member, as three texts. Returns None if
    the member has a comment or a body, or if one of these parts cannot be found."""
    from gidl.fmt.printer import leading

    if item.bodies or any(p.is_comment for p in item.pieces):
        return None
    head = leading(item)
    pieces = item.pieces
    names = _type_end(pieces, head)
    if not head < names < len(pieces):
        return None
    return [_text(pieces[:head]), _text(pieces[head:names]), _text(pieces[names:])]


def _type_end(pieces: list[Piece], at: int) -> int:
    """Returns the index of the piece after the type that begins at index `at`."""
    if pieces[at].text in _PRIMITIVES:
        while at < len(pieces) and pieces[at].text in _PRIMITIVES:
            at += 1
        return at
    if pieces[at].text == "::":
        at += 1
    at += 1
    while at + 1 < len(pieces) and pieces[at].text == "::":
        at += 2
    if at < len(pieces) and pieces[at].role == "angle":
        depth = 0
        while at < len(pieces):
            if pieces[at].role == "angle":
                depth += 1 if pieces[at].text == "<" else -1
            elif pieces[at].role == "angles":
                depth -= 2
            at += 1
            if depth == 0:
                break
    return at


def _text(pieces: list[Piece]) -> str:
    text = ""
    for piece in pieces:
        text += f" {piece.text}" if text and piece.spaced else piece.text
    return text


def _heads(run: list[Laid]) -> None:
    """Aligns the opening braces of consecutive one-line enums, exceptions or structs in one
    column."""
    group: list[Laid] = []
    for laid in [*run, None]:
        body = _short_body(laid.item) if laid is not None else None
        if group and (body is None or body.keyword != _keyword(group[0])):
            _pad_heads(group)
            group = []
        if laid is not None and body is not None:
            group.append(laid)


def _short_body(item: Item) -> Body | None:
    """Returns the body of `item` if this is an enum, an exception or a struct, and has no
    annotation and no second body. Returns None for any other item, and for an empty body."""
    bodies = item.bodies
    first = item.parts[0]
    is_plain = isinstance(first, Piece) and bool(bodies) and first.text == bodies[0].keyword
    is_table = is_plain and bodies[0].keyword in ("enum", "exception", "struct")
    return bodies[0] if is_table and len(bodies) == 1 and bodies[0].elements else None


def _keyword(laid: Laid) -> str:
    body = _short_body(laid.item)
    return body.keyword if body is not None else ""


def _pad_heads(group: list[Laid]) -> None:
    heads = [laid.lines[0].index(" {") for laid in group]
    if len(group) < 2 or max(heads) - min(heads) > _WIDEST_PADDING:
        return
    for laid, width in zip(group, heads, strict=True):
        line = laid.lines[0]
        laid.lines = [line[:width] + " " * (max(heads) - width) + line[width:]]
