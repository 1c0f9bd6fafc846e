"""Parses the texts of types in a served model, for example `sequence<double, 6>` and `map<string,
robcl::Frame>`."""

from __future__ import annotations

import re
from typing import NoReturn

from gecos.record import Record
from gecos.wire.codes import MAX_COUNT, MAX_TEXT

CODES = {
    "boolean": "?", "octet": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h",
    "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q", "float": "f",
    "double": "d",
}  # fmt: skip
"""The number code of each primitive type; `gecos.wire.Fields` has the same codes."""

_MAX_DEPTH = 16  # levels of types inside each other
_TOKEN = re.compile(
    r'\s*(?:(?P<unit>@unit\("[^"]*"\))|(?P<word>[A-Za-z]\w*(?:::[A-Za-z]\w*)*)'
    r"|(?P<number>[0-9]{1,10})|(?P<sign>[<>,\[\]])|(?P<end>\Z))",
    re.ASCII,
)
_KEYWORDS = frozenset(("string", "sequence", "map"))


class Type(Record):
    """A type as it is used. `kind` says which of the other members have a meaning."""

    kind: str  # "primitive", "string", "sequence", "map", "array" or "named"
    name: str = ""  # name of a primitive or a declaration
    inner: tuple[Type, ...] = ()  # the element, or key and value
    bound: int | None = None  # largest size of a string, sequence or map
    sizes: tuple[int, ...] = ()  # dimensions of an array

    def __str__(self) -> str:
        """Returns the type as in .gidl, without the units of elements."""
        inner = [str(each) for each in self.inner]
        if self.kind == "array":
            return inner[0] + "".join(f"[{size}]" for size in self.sizes)
        bound = [] if self.bound is None else [str(self.bound)]
        if self.kind in ("string", "sequence", "map"):
            terms = ", ".join(inner + bound)
            return f"{self.kind}<{terms}>" if terms else self.kind
        return self.name

    def named(self) -> set[str]:
        """Returns the names of all declared types that the text of this type mentions."""
        own = {self.name} if self.kind == "named" else set()
        return own.union(*(each.named() for each in self.inner))


def parse_type(text: str) -> Type:
    """Returns the type that `text` names. Raises ValueError if `text` is not a type."""
    return _Parser(text).whole()


class _Parser:
    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._kind = self._token = ""
        self._advance()

    def whole(self) -> Type:
        found = self._type(_MAX_DEPTH)
        if self._kind != "end":
            self._refuse("unexpected text after the type")
        return found

    def _advance(self) -> None:
        match = _TOKEN.match(self._text, self._at)
        if match is None:
            self._refuse("unexpected character")
        self._at = match.end()
        self._kind = match.lastgroup or ""
        self._token = match[self._kind]

    def _type(self, levels: int) -> Type:
        if levels == 0:
            self._refuse(f"nested deeper than {_MAX_DEPTH} levels")
        found = self._bare(levels)
        sizes = []
        while self._token == "[":
            self._advance()
            sizes.append(self._number(1, MAX_COUNT))
            self._expect("]")
        if len(sizes) > _MAX_DEPTH:
            self._refuse(f"more than {_MAX_DEPTH} dimensions")
        return Type("array", inner=(found,), sizes=tuple(sizes)) if sizes else found

    def _bare(self, levels: int) -> Type:
        if self._kind != "word":
            self._refuse("a type is expected")
        word = self._token
        self._advance()
        if word in CODES:
            return Type("primitive", word)
        if word not in _KEYWORDS:
            return Type("named", word)
        if word == "string":
            if self._token != "<":
                return Type("string")
            self._advance()
            bound = self._number(0, MAX_TEXT)
            self._expect(">")
            return Type("string", bound=bound)
        self._expect("<")
        if self._kind == "unit":
            self._advance()
        inner = [self._type(levels - 1)]
        if word == "map":
            self._expect(",")
            inner.append(self._type(levels - 1))
        most = None
        if self._token == ",":
            self._advance()
            most = self._number(0, MAX_COUNT)
        self._expect(">")
        return Type(word, inner=tuple(inner), bound=most)

    def _number(self, low: int, high: int) -> int:
        if self._kind != "number" or not low <= int(self._token) <= high:
            self._refuse(f"a number from {low} to {high} is expected")
        number = int(self._token)
        self._advance()
        return number

    def _expect(self, sign: str) -> None:
        if self._token != sign:
            self._refuse(f"'{sign}' is expected")
        self._advance()

    def _refuse(self, why: str) -> NoReturn:
        shown = self._text if len(self._text) <= 60 else f"{self._text[:60]}…"
        raise ValueError(f"{shown!r} is not a type: {why}")
