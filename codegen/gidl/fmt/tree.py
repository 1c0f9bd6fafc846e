"""Groups pieces into bodies (in braces, or in the parentheses of parameters) and their items."""

from __future__ import annotations

from dataclasses import dataclass, field

from gidl.fmt.pieces import Piece, UnreadableError

_LISTS = ("enum", "bitmask")  # keywords of bodies whose items end with a comma


@dataclass(slots=True)
class Item:
    """A declaration, a member, an enumerator or a parameter, with the token that ends it."""

    parts: list[Piece | Body] = field(default_factory=list)
    trailing: list[Piece] = field(default_factory=list)  # comments on the line where the item ends
    continued: list[Piece] = field(default_factory=list)  # `//` lines that continue `trailing`

    @property
    def first(self) -> Piece:
        part = self.parts[0]
        return part if isinstance(part, Piece) else part.opening

    @property
    def pieces(self) -> list[Piece]:
        return [p for p in self.parts if isinstance(p, Piece)]

    @property
    def bodies(self) -> list[Body]:
        return [p for p in self.parts if isinstance(p, Body)]


@dataclass(slots=True)
class Body:
    """A block `{ ... }`, or the parameter list of an operation."""

    opening: Piece
    keyword: str  # "struct", "interface", ...; "(" for parameters
    elements: list[Item | Piece] = field(default_factory=list)  # a Piece is a comment or directive
    closing: Piece | None = None
    after_opening: list[Piece] = field(default_factory=list)  # comments on the line of `{`
    broken: bool = False  # True: print the body on several lines

    @property
    def items(self) -> list[Item]:
        return [e for e in self.elements if isinstance(e, Item)]


def structure(pieces: list[Piece]) -> Body:
    """Returns the whole file as one body without braces."""
    opening = Piece("op", "", 1, 0, 1, True, False)
    root = Body(opening, "file", broken=True)
    reader = _Reader(pieces)
    reader.fill(root)
    if reader.now is not None:
        raise UnreadableError(
            reader.now.line, f"has a '{reader.now.text}' without its opening bracket"
        )
    return root


class _Reader:
    def __init__(self, pieces: list[Piece]) -> None:
        self._pieces = pieces
        self._at = 0

    @property
    def now(self) -> Piece | None:
        return self._pieces[self._at] if self._at < len(self._pieces) else None

    def fill(self, body: Body) -> None:
        """Reads elements into `body`, up to the token that closes it."""
        while (piece := self.now) is not None and piece.text not in ("}", ")"):
            if piece.kind == "directive" or piece.is_comment:
                self._at += 1
                body.elements.append(piece)
                if piece.kind == "directive":
                    self._same_line(body, piece)
            else:
                self._item(body)

    def _same_line(self, body: Body, piece: Piece) -> None:
        """Adds a preprocessor line and the comments at its end to `body` as one element, so that
        the comments stay on this line."""
        comments = self._comments_behind(piece)
        if comments:
            body.elements[-1] = Item([piece], comments)

    def _item(self, body: Body) -> None:
        item = Item()
        keyword = ""
        separator = "," if body.keyword in ("(", *_LISTS) else ";"
        depth = 0
        while (piece := self.now) is not None:
            if piece.kind == "op":
                if piece.text in ("}", ")") and depth == 0:
                    break
                if piece.text == "{" or (piece.role == "params" and piece.text == "("):
                    item.parts.append(self._body(piece, keyword or "{"))
                    keyword = ""
                    continue
                depth += (piece.text in ("(", "[")) - (piece.text in (")", "]"))
            if piece.kind == "id" and not keyword and not self._is_annotation(item):
                keyword = self._keyword(piece)
            item.parts.append(piece)
            self._at += 1
            if piece.kind == "op" and piece.text == separator and depth == 0:
                break
        self._trailing(item)
        body.elements.append(item)
        body.elements.extend(self._left_over(item))

    def _left_over(self, item: Item) -> list[Item | Piece]:
        """Moves the comments at the end of `item` out of its parts. An item has comments at its end
        only if no separator (`;` or `,`) ends the item, for example the last enumerator of an enum.
        Comments on the line of the item become its trailing comments. Returns the other
        comments."""
        last = len(item.parts)
        while last > 1 and isinstance(part := item.parts[last - 1], Piece) and part.is_comment:
            last -= 1
        comments = [p for p in item.parts[last:] if isinstance(p, Piece)]
        del item.parts[last:]
        while comments and not comments[0].first_on_line:
            item.trailing.append(comments.pop(0))
        if item.trailing:
            while comments and _continues(comments[0], item.trailing[0]):
                item.continued.append(comments.pop(0))
        return list(comments)

    def _is_annotation(self, item: Item) -> bool:
        pieces = item.pieces
        if not pieces or pieces[-1].text != "@":
            return False
        now = self.now
        return now is None or now.text != "annotation"

    @staticmethod
    def _keyword(piece: Piece) -> str:
        known = ("module", "interface", "struct", "exception", "union", "enum", "bitmask",
                 "bitset", "annotation")  # fmt: skip
        return piece.text if piece.text in known else ""

    def _body(self, opening: Piece, keyword: str) -> Body:
        self._at += 1
        is_call = opening.text == "("
        body = Body(opening, "(" if is_call else keyword)
        body.after_opening = self._comments_behind(opening)
        self.fill(body)
        closing = self.now
        wanted = ")" if is_call else "}"
        if closing is None or closing.text != wanted:
            raise UnreadableError(opening.line, f"opens '{opening.text}' and does not close it")
        self._at += 1
        body.closing = closing
        body.broken = self._breaks(body)
        return body

    def _breaks(self, body: Body) -> bool:
        assert body.closing is not None
        if any(c.is_line_comment or c.line != c.end_line for c in body.after_opening):
            return True
        for element in body.elements:
            if isinstance(element, Piece):
                return True
            inside = [*element.pieces, *element.trailing]
            if any(p.is_line_comment or p.kind == "directive" for p in inside):
                return True
            if any(p.is_comment and p.line != p.end_line for p in inside):
                return True
            if element.continued or any(b.broken for b in element.bodies):
                return True
        if not body.elements:
            return bool(body.after_opening) and body.opening.line != body.closing.line
        if body.keyword == "(":
            return body.items[0].first.first_on_line
        return body.opening.line != body.closing.line

    def _comments_behind(self, piece: Piece) -> list[Piece]:
        """Takes the comments that follow `piece` on its line, even if code follows the comments."""
        found: list[Piece] = []
        while (comment := self.now) is not None and comment.is_comment:
            if comment.first_on_line or comment.line != (found[-1] if found else piece).end_line:
                break
            found.append(comment)
            self._at += 1
        return found

    def _trailing(self, item: Item) -> None:
        last = item.parts[-1]
        closing = last.closing if isinstance(last, Body) else last
        assert closing is not None
        item.trailing = self._comments_behind(closing)
        if not item.trailing:
            return
        while (comment := self.now) is not None and _continues(comment, item.trailing[0]):
            item.continued.append(comment)
            self._at += 1


def _continues(comment: Piece, above: Piece) -> bool:
    """Returns whether a comment that stands alone on its line continues the trailing comment of the
    line above."""
    return (
        comment.is_line_comment
        and comment.first_on_line
        and not comment.blank_before
        and comment.column == above.column
        and not comment.text.startswith("//@")
    )
