"""Computes the conditions of `#if` and `#elif`: expands macros, then computes the value as C++
does.

Numbers have 64 bits. A number is unsigned if it ends in `u`, or if it does not fit 63 bits. An
operator with an unsigned operand computes without sign, modulo 2^64.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from gidl.syntax.lexer import Token

Macros = dict[str, tuple[Token, ...]]

MAX_EXPANSION = 10_000  # maximum number of tokens for one use of a macro, or for a condition
_CONDITION = re.compile(
    r"\s*(defined\b|[A-Za-z_]\w*|(?:0[xX][0-9A-Fa-f]+|\d+)[uUlL]*|&&|\|\||<<|>>|[=!<>]="
    r"|[()!<>+*/%~&|^-])"
)


class RefusedError(ValueError):
    """Raised when the condition uses a macro with parameters. The finding about this macro already
    exists."""


def is_true(text: str, macros: Macros) -> bool:
    """Returns whether a condition is true. Raises ValueError or ZeroDivisionError if `text` is not
    a valid condition."""
    return bool(_ConditionReader(text, macros).value().number)


def _words(text: str) -> list[str]:
    """Returns the tokens of a condition. Raises ValueError if the text contains a token that no
    condition may have."""
    words: list[str] = []
    at = 0
    stripped = text.rstrip()
    while at < len(stripped):
        match = _CONDITION.match(stripped, at)
        if match is None:
            raise ValueError(text)
        words.append(match.group(1))
        at = match.end()
    return words


def _body_text(body: tuple[Token, ...]) -> str:
    """Returns the text of a macro's body, with one space wherever the body has white space."""
    text, end = "", 0
    for token in body:
        text += (" " if token.start > end else "") + token.text
        end = token.end
    return text


def _expanded(text: str, macros: Macros) -> list[str]:
    """Returns the tokens of a condition with its macros expanded, except in the operands of
    `defined`."""
    result: list[str] = []
    open_names: frozenset[str] = frozenset()
    work = [(word, open_names) for word in reversed(_words(text))]
    while work:
        word, open_names = work.pop()
        if word == "defined":
            result.append(word)
            for _ in range(3 if work and work[-1][0] == "(" else 1):
                if work:
                    result.append(work.pop()[0])
        elif word in macros and word not in open_names:
            if macros[word][:1] and macros[word][0].kind == "macro":
                raise RefusedError
            inner = open_names | {word}
            work.extend((w, inner) for w in reversed(_words(_body_text(macros[word]))))
        else:
            result.append(word)
        if len(result) + len(work) > MAX_EXPANSION:
            raise ValueError("the macros of the condition expand to too many tokens")
    return result


class _Value(NamedTuple):
    number: int
    unsigned: bool = False


_ZERO = _Value(0)


class _ConditionReader:
    """Computes a condition. Raises ValueError if the text is not a valid condition."""

    _LEVELS = (
        ("||",), ("&&",), ("|",), ("^",), ("&",), ("==", "!="), ("<", ">", "<=", ">="),
        ("<<", ">>"), ("+", "-"), ("*", "/", "%"),
    )  # fmt: skip

    def __init__(self, text: str, macros: Macros) -> None:
        self._words = _expanded(text, macros)
        self._macros = macros
        self._at = 0
        self._depth = 0
        # Greater than 0 while the reader is in an operand that cannot change the value of the
        # condition, for example in `1 / 0` of the condition `0 && 1 / 0`. Such an operand is
        # parsed, but not computed.
        self._unneeded = 0

    def value(self) -> _Value:
        result = self._binary(0)
        if self._at != len(self._words):
            raise ValueError("there is text after the end of the condition")
        return result

    def _next(self) -> str:
        if self._at >= len(self._words):
            raise ValueError("the condition is incomplete")
        self._at += 1
        return self._words[self._at - 1]

    def _peek(self) -> str:
        return self._words[self._at] if self._at < len(self._words) else ""

    def _binary(self, level: int) -> _Value:
        if level == len(self._LEVELS):
            return self._primary()
        left = self._binary(level + 1)
        while self._peek() in self._LEVELS[level]:
            operator = self._next()
            decided = operator == ("||" if left.number else "&&")
            self._unneeded += decided
            right = self._binary(level + 1)
            self._unneeded -= decided
            left = _ZERO if self._unneeded else _apply(operator, left, right)
        return left

    def _primary(self) -> _Value:
        self._depth += 1
        if self._depth > 50:
            raise ValueError("nested too deep")
        word = self._next()
        if word in ("!", "-", "+", "~"):
            inner = self._primary()
            result = _ZERO if self._unneeded else _unary(word, inner)
        elif word == "(":
            result = self._binary(0)
            if self._next() != ")":
                raise ValueError("')' is missing")
        elif word == "defined":
            name = self._next()
            if name == "(":
                name = self._next()
                if self._next() != ")":
                    raise ValueError("')' is missing")
            result = _Value(int(name in self._macros))
        elif word[0].isdigit():
            result = _number(word)
        elif word[0].isalpha() or word[0] == "_":
            # As in C++, `true` is 1, and every other name that is not a macro is 0.
            result = _Value(int(word == "true"))
        else:
            raise ValueError(word)
        self._depth -= 1
        return result


def _number(word: str) -> _Value:
    digits = word.rstrip("uUlL")
    if digits[:2] in ("0x", "0X"):
        number = int(digits, 16)
    else:
        number = int(digits, 8 if digits[0] == "0" else 10)
    if number >= 1 << 64:
        raise ValueError("the number does not fit 64 bits")
    return _Value(number, "u" in word.lower() or number >= 1 << 63)


def _fitting(number: int, unsigned: bool) -> _Value:
    if unsigned:
        return _Value(number % (1 << 64), True)
    if not -(1 << 63) <= number < 1 << 63:
        raise ValueError("the result does not fit 64 bits")
    return _Value(number)


def _unary(operator: str, operand: _Value) -> _Value:
    number, unsigned = operand
    match operator:
        case "!":
            return _Value(int(not number))
        case "-":
            return _fitting(-number, unsigned)
        case "~":
            return _fitting(~number, unsigned)
        case _:
            return operand


def _apply(operator: str, left: _Value, right: _Value) -> _Value:
    match operator:
        case "||":
            return _Value(int(bool(left.number or right.number)))
        case "&&":
            return _Value(int(bool(left.number and right.number)))
        case "<<" | ">>":
            return _shifted(operator, left, right.number)
    unsigned = left.unsigned or right.unsigned
    one, other = (v.number % (1 << 64) if unsigned else v.number for v in (left, right))
    match operator:
        case "==":
            return _Value(int(one == other))
        case "!=":
            return _Value(int(one != other))
        case "<":
            return _Value(int(one < other))
        case ">":
            return _Value(int(one > other))
        case "<=":
            return _Value(int(one <= other))
        case ">=":
            return _Value(int(one >= other))
    return _fitting(_computed(operator, one, other), unsigned)


def _shifted(operator: str, left: _Value, by: int) -> _Value:
    """Returns the shifted value, in the type of the left operand. Bits that are shifted out are
    lost."""
    if not 0 <= by < 64:
        raise ValueError("shift too far")
    if operator == ">>":
        return _Value(left.number >> by, left.unsigned)
    number = (left.number << by) % (1 << 64)
    if not left.unsigned and number >= 1 << 63:
        number -= 1 << 64
    return _Value(number, left.unsigned)


def _computed(operator: str, left: int, right: int) -> int:
    match operator:
        case "|":
            return left | right
        case "^":
            return left ^ right
        case "&":
            return left & right
        case "+":
            return left + right
        case "-":
            return left - right
        case "*":
            return left * right
        case "/":
            return _quotient(left, right)
        case _:
            return left - _quotient(left, right) * right


def _quotient(left: int, right: int) -> int:
    """Divides and rounds towards zero, as C++ does."""
    size = abs(left) // abs(right)
    return size if (left < 0) == (right < 0) else -size
