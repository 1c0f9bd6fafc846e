"""Parses constant expressions and literals."""

from __future__ import annotations

from gidl.diagnostics.source import Span
from gidl.syntax.lexer import Token
from gidl.syntax.token_reader import Skip, TokenReader
from gidl.syntax.tree import Binary, Expression, Literal, NameUse, RefusedValue, Unary

_LEVELS = (("|",), ("^",), ("&",), ("<<", ">>"), ("+", "-"), ("*", "/", "%"))
_LITERALS = ("int", "float", "fixed", "string", "char", "wide_string", "wide_char")

_ESCAPES = {
    "n": "\n", "t": "\t", "v": "\v", "b": "\b", "r": "\r", "f": "\f", "a": "\a",
    "\\": "\\", "?": "?", "'": "'", '"': '"',
}  # fmt: skip


class ExpressionParser(TokenReader):
    """Each method parses one grammar rule; the next token must be the first token of that rule."""

    _in_angles = False  # True inside `<...>`: `>>` closes two brackets and is not a shift
    _in_annotation = False  # True inside the parentheses of an annotation
    _wide = False  # True (--wide): wide strings and characters are read as strings
    _wide_refused = False  # True: a `wchar` or `wstring` is already reported

    # -- const_expr ----------------------------------------------------------------------------

    def _expression(self) -> Expression:
        with self._nested():
            return self._binary(0)

    def _binary(self, level: int) -> Expression:
        """Parses the grammar rules from or_expr to mult_expr. All their operators are
        left-associative."""
        if level == len(_LEVELS):
            return self._unary()
        start = self._now
        left = self._binary(level + 1)
        while self._now.kind == "op" and self._now.text in _LEVELS[level]:
            if self._in_angles and self._now.text == ">>":
                break
            operator = self._advance().text
            right = self._binary(level + 1)
            left = Binary(operator, left, right, self._since(start))
        return left

    def _unary(self) -> Expression:
        start = self._now
        operators: list[Token] = []
        while self._now.kind == "op" and self._now.text in ("-", "+", "~"):
            operators.append(self._advance())
        result = self._primary()
        if len(operators) > 5:
            self._findings.error(
                "G0013", self._span(start), "there are more than 5 signs before this value"
            )
            raise Skip
        for operator in reversed(operators):
            result = Unary(operator.text, result, self._since(operator))
        return result

    def _primary(self) -> Expression:
        token = self._now
        if token.kind in _LITERALS:
            return self._literal()
        if self._is("TRUE") or self._is("FALSE"):
            self._advance()
            return Literal(token.text == "TRUE", "bool", self._span(token))
        if self._is("("):
            self._advance()
            outer, self._in_angles = self._in_angles, False
            inner = self._expression()
            self._in_angles = outer
            self._expect(")", "at the end of the expression")
            return inner
        if token.kind in ("id", "escaped") or self._is("::"):
            if token.text.lower() in ("true", "false"):
                return self._lower_case_boolean()
            name = self._scoped_name("a value")
            return NameUse(name, name.span)
        if token.kind == "macro":
            self._advance()
            return RefusedValue(self._span(token))
        self._syntax_error("a value")
        raise Skip

    def _lower_case_boolean(self) -> Literal:
        token = self._advance()
        span, keyword = self._span(token), token.text.upper()
        message = f"'{token.text}' differs from the keyword '{keyword}' only in case"
        if self._in_annotation:
            self._findings.warning("G0709", span, message, f"write {keyword}")
        else:
            self._findings.error("G0104", span, message, f"write {keyword}")
        return Literal(keyword == "TRUE", "bool", span)

    def _literal(self) -> Literal:
        token = self._advance()
        span = self._span(token)
        match token.kind:
            case "int":
                return Literal(_integer(token.text), "int", span)
            case "float":
                return Literal(float(token.text), "float", span)
            case "fixed":
                self._refuse("G0203", span, "a fixed-point number is", "write a double, without d")
                return Literal(float(token.text[:-1]), "float", span)
            case "char":
                return self._character(token)
            case "wide_char":
                return self._wide_character(token)
        text = self._part(token)
        while self._now.kind in ("string", "wide_string"):  # adjacent literals are one string
            text += self._part(self._advance())
        return Literal(text, "string", self._since(token))

    def _part(self, token: Token) -> str:
        if token.kind == "wide_string":
            self._refuse_wide(token)
        return self._unescape(token)

    def _refuse_wide(self, token: Token) -> None:
        """Reports a wide literal, unless a wide type in the same file is already reported."""
        if self._wide or self._wide_refused:
            return
        self._refuse(
            "G0206",
            self._span(token),
            "wide text is",
            "leave out the L: strings are UTF-8; with --wide=utf8, wide text is read as UTF-8",
        )

    def _wide_character(self, token: Token) -> Literal:
        """Parses a wide character as a string of one character."""
        self._refuse_wide(token)
        text = self._unescape(token)
        if len(text) != 1:
            self._findings.error("G0010", self._span(token), f"{token.text} is not one character")
            text = "?"
        return Literal(text, "string", self._span(token))

    def _character(self, token: Token) -> Literal:
        text = self._unescape(token)
        if len(text) != 1 or ord(text) > 255:
            self._findings.error(
                "G0010", self._span(token), f"{token.text} is not one character of Latin-1"
            )
            text = "?"
        return Literal(text, "char", self._span(token))

    def _unescape(self, token: Token) -> str:
        """Returns the text of a literal, with octal, \\x and \\u escapes replaced as in the IDL
        standard. A NUL is allowed as a character, but not in a string."""
        opening = token.text.index(token.text[-1]) + 1
        body = token.text[opening:-1]
        if "\\" not in body:
            return body
        out: list[str] = []
        at = 0
        while at < len(body):
            if body[at] != "\\":
                out.append(body[at])
                at += 1
                continue
            text, width = _escape(body[at + 1 :])
            if text is None or (text == "\0" and token.kind != "char"):
                start = token.start + opening + at
                span = Span(self._source, start, start + 1 + width)
                what = "a string cannot contain a NUL" if text else "unknown escape"
                self._findings.error("G0010", span, f"{what}: '{body[at : at + 1 + width]}'")
                text = "?"
            out.append(text)
            at += 1 + width
        return "".join(out)


def _integer(text: str) -> int:
    if text[:2] in ("0x", "0X"):
        return int(text, 16)
    if len(text) > 1 and text[0] == "0" and not set(text) & {"8", "9"}:
        return int(text, 8)
    return int(text[:300])


def _escape(rest: str) -> tuple[str | None, int]:
    """Returns the character of an escape (or None if the escape is invalid), and the length of the
    escape. `rest` is the text after the backslash."""
    if not rest:
        return None, 0
    if rest[0] in _ESCAPES:
        return _ESCAPES[rest[0]], 1
    digits, base, first = _escape_digits(rest)
    if not digits:
        return None, 1
    code = int(digits, base)
    if 0xD800 <= code <= 0xDFFF:
        return None, first + len(digits)
    return chr(code), first + len(digits)


def _escape_digits(rest: str) -> tuple[str, int, int]:
    """Returns the digits of the numeric escape at the beginning of `rest`, their base, and the
    index of the first digit."""
    limit, base, first = {"x": (2, 16, 1), "u": (4, 16, 1)}.get(rest[0], (3, 8, 0))
    allowed = "0123456789abcdefABCDEF" if base == 16 else "01234567"
    digits = ""
    for char in rest[first : first + limit]:
        if char not in allowed:
            break
        digits += char
    return digits, base, first
