"""Base class of the parser: looks ahead, expects tokens, reports errors, and recovers from them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches

from gidl.diagnostics.findings import Findings, Note
from gidl.diagnostics.source import Source, Span
from gidl.syntax.keywords import NEW_IN_4, UNUSED_BY_LOWER, USED_BY_LOWER
from gidl.syntax.lexer import Token
from gidl.syntax.tree import Name, ScopedName

MAX_NESTING = 200


class Skip(Exception):
    """Raised after a finding if a grammar rule cannot continue. The rule that parses the enclosing
    body catches this exception and continues after the error."""


class GiveUp(Exception):
    """Raised after a finding if the rest of the file cannot be parsed."""


class TokenReader:
    def __init__(self, source: Source, tokens: list[Token], findings: Findings) -> None:
        self._source = source
        self._tokens = tokens
        self._findings = findings
        self._at = 0
        self._depth = 0
        self._refused_names: set[tuple[str, str]] = set()  # refused name, code of the finding

    @property
    def _now(self) -> Token:
        return self._tokens[self._at]

    @property
    def _ahead(self) -> Token:
        return self._token_at(1)

    def _token_at(self, distance: int) -> Token:
        """Returns the token that is `distance` tokens after the next token."""
        return self._tokens[min(self._at + distance, len(self._tokens) - 1)]

    @property
    def _previous(self) -> Token:
        return self._tokens[self._at - 1] if self._at else Token("op", "", 0, 0)

    def _span(self, token: Token) -> Span:
        return Span(self._source, token.start, token.end)

    def _since(self, start: Token) -> Span:
        return Span(self._source, start.start, max(start.end, self._previous.end))

    def _advance(self) -> Token:
        token = self._now
        if token.kind != "eof":
            self._at += 1
        return token

    def _is(self, text: str) -> bool:
        """Returns whether the next token is this keyword or punctuation (and not an escaped
        identifier)."""
        token = self._now
        return token.text == text and token.kind in ("id", "op")

    def _accept(self, text: str) -> bool:
        if self._is(text):
            self._at += 1
            return True
        return False

    def _expect(self, text: str, where: str) -> Token:
        if self._is(text):
            return self._advance()
        self._syntax_error(f"'{text}'", where)
        raise Skip

    def _starts_line(self) -> bool:
        """Returns whether the next token is on a later line than the token before it."""
        return self._source.line_of(self._now.start) > self._source.line_of(self._previous.start)

    def _expect_semicolon(self, where: str) -> None:
        """Reads a `;`. If the `;` is missing, reports the error, and parsing continues as if the
        `;` were there."""
        if self._accept(";"):
            return
        if self._now.kind == "macro":
            self._skip_statement()
            return
        end = self._previous.end
        at = Span(self._source, end, end + 1)
        now = self._now
        on_same_line = self._source.line_of(end) == self._source.line_of(now.start)
        self._findings.error("G0100", at, f"';' is missing after {where}")
        goes_on = now.kind in ("id", "escaped", "eof") or now.text in ("}", "@")
        if on_same_line and not goes_on:
            self._skip_statement()

    def _syntax_error(self, expected: str, where: str = "", *help_lines: str) -> None:
        token = self._now
        if token.kind == "macro":
            return  # the definition of the macro is already reported
        found = "the end of the file" if token.kind == "eof" else f"'{_short(token.text)}'"
        if token.kind == "escaped":
            found = f"'_{token.text}'"
        context = f" {where}" if where else ""
        self._findings.error(
            "G0100", self._span(token), f"expected {expected}{context}, found {found}", *help_lines
        )

    def _syntax_error_at(self, token: Token, message: str, *help_lines: str) -> None:
        self._findings.error("G0100", self._span(token), message, *help_lines)

    def _refuse(self, code: str, at: Span, what: str, instead: str) -> None:
        self._findings.error(code, at, f"{what} not part of .gidl", instead)

    def _refuse_once(self, name: str, code: str, at: Span, what: str, instead: str) -> None:
        """Reports an unsupported declaration called `name`. The forward declaration and the full
        declaration of a name give only one finding."""
        if (name, code) not in self._refused_names:
            self._refused_names.add((name, code))
            self._refuse(code, at, what, instead)

    @contextmanager
    def _nested(self) -> Iterator[None]:
        if self._depth >= MAX_NESTING:
            self._findings.error(
                "G0013",
                self._span(self._now),
                f"this is nested deeper than {MAX_NESTING} levels; the rest of this file is not "
                "read",
            )
            raise GiveUp
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1

    # -- names ---------------------------------------------------------------------------------

    def _identifier(self, what: str) -> Name:
        """Parses a declared name. A keyword is reported and then taken as the name."""
        token = self._now
        if token.kind == "escaped":
            self._advance()
            return Name(token.text, self._span(token), escaped=True)
        if token.kind != "id":
            self._syntax_error(what)
            raise Skip
        keyword = USED_BY_LOWER.get(token.text.lower())
        if keyword in NEW_IN_4 and keyword != token.text:
            self._findings.warning(
                "G0707",
                self._span(token),
                f"'{token.text}' differs from '{keyword}', a keyword since IDL 4.0, only in case",
                f"write '_{token.text}' for other IDL compilers: the name remains '{token.text}'",
            )
        elif keyword is not None:
            alike = "" if keyword == token.text else " (names are compared without regard to case)"
            self._findings.error(
                "G0104",
                self._span(token),
                f"'{token.text}' is the keyword '{keyword}'{alike}"
                if alike
                else f"'{token.text}' is a keyword",
                f"write '_{token.text}': the underscore escapes the keyword and is not part of "
                "the name",
            )
        elif token.text.lower() in UNUSED_BY_LOWER:
            self._findings.warning(
                "G0702",
                self._span(token),
                f"'{token.text}' is a keyword of a part of IDL that .gidl does not use",
                f"write '_{token.text}' for other IDL compilers: the name remains '{token.text}'",
            )
        self._advance()
        return Name(token.text, self._span(token))

    def _scoped_name(self, what: str, *, in_one_piece: bool = False) -> ScopedName:
        start = self._now
        absolute = self._accept("::")
        parts = [self._name_part(what)]
        while self._is("::") and not (in_one_piece and self._now.start > self._previous.end):
            self._advance()
            parts.append(self._name_part("a name after '::'"))
        return ScopedName(tuple(parts), absolute, self._since(start))

    def _name_part(self, what: str) -> str:
        token = self._now
        if token.kind == "escaped":
            return self._advance().text
        if token.text == "Object":
            self._findings.error(
                "G0212",
                self._span(token),
                "'Object' is the type of an object reference, not an interface",
                "use 'Object' only as the type of a value: it cannot be a base, and '::' cannot "
                "follow it",
            )
            raise Skip
        if token.kind != "id" or token.text in USED_BY_LOWER.values():
            self._syntax_error(what, "", keyword_hint(token.text))
            raise Skip
        return self._advance().text

    # -- recovery ------------------------------------------------------------------------------

    def _skip_statement(self) -> None:
        """Skips tokens up to and including the next `;`, or up to the `}` that closes the enclosing
        body."""
        depth = 0
        while self._now.kind != "eof":
            text = self._now.text if self._now.kind == "op" else ""
            if text in ("{", "(", "["):
                depth += 1
            elif text in (")", "]"):
                depth = max(0, depth - 1)
            elif text == "}":
                if depth == 0:
                    return
                depth -= 1
                if depth == 0:
                    self._advance()
                    self._accept(";")
                    return
            elif (text == ";" and depth == 0) or (
                text == ";" and self._starts_declaration(self._ahead)
            ):
                self._advance()
                return
            self._advance()

    def _starts_declaration(self, token: Token) -> bool:
        return token.kind == "id" and token.text in ("module", "interface", "exception")

    def _close_body(self, opened: Token, what: str) -> None:
        if self._accept("}"):
            return
        note = Note("opened here", self._source.location(opened.start))
        token = self._now
        if token.kind == "macro":
            raise Skip
        end = self._previous.end if token.kind == "eof" else token.start
        at = Span(self._source, max(0, end - 1), max(1, end))
        self._findings.error("G0100", at, f"'}}' is missing at the end of {what}", notes=(note,))
        raise Skip


def keyword_hint(word: str) -> str:
    close = get_close_matches(word, list(USED_BY_LOWER.values()), n=1, cutoff=0.7)
    return f"did you mean '{close[0]}'?" if close and close[0] != word else ""


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:37] + "..."
