"""Preprocessor lines: `#include`, guards, `#pragma once`, conditions and constants.

Each file is read only once per run, even without an include guard. Macros are constants (`#define
RATE 250`); macros with parameters are reported as unsupported.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from gidl.diagnostics import Findings
from gidl.lexer import Lexed, Token, lex
from gidl.source import Source, Span
from gidl.syntax import Include

Macros = dict[str, tuple[Token, ...]]

_DIRECTIVE = re.compile(r"#[ \t]*(\w*)[ \t]*(.*)", re.DOTALL)
_INCLUDE = re.compile(r'(?:"([^"\n]+)"|<([^>\n]+)>)\s*$')
_DEFINE = re.compile(r"([A-Za-z_]\w*)(\(?)(.*)", re.DOTALL)
_CONDITION = re.compile(
    r"\s*(defined\b|[A-Za-z_]\w*|(?:0[xX][0-9A-Fa-f]+|\d+)[uUlL]*|&&|\|\||<<|>>|[=!<>]="
    r"|[()!<>+*/%~&|^-])"
)
_GUARD = re.compile(r"#[ \t]*(?:ifndef[ \t]+|if[ \t]*![ \t]*defined[ \t]*\(?[ \t]*)([A-Za-z_]\w*)")
_MAX_NUMBER = 1 << 64
_MAX_EXPANSION = 10_000  # maximum number of tokens for one use of a macro


@dataclass(slots=True)
class _Condition:
    span: Span
    active: bool
    taken: bool  # True: a branch of the condition was active
    in_else: bool = False


@dataclass(slots=True)
class Preprocessed:
    tokens: list[Token]
    includes: list[Include] = field(default_factory=list)
    skipped: list[tuple[int, int]] = field(default_factory=list)  # offsets of inactive text
    first_directive: int | None = None
    # Tokens of active `//@` comments after code, as in `Lexed`, but with their macros expanded.
    trailing: dict[int, list[Token]] = field(default_factory=dict)


def preprocess(
    lexed: Lexed,
    findings: Findings,
    macros: Macros,
    on_include: Callable[[Include], None],
) -> Preprocessed:
    """Executes the preprocessor lines. Both this function and `on_include` read and change
    `macros`."""
    return _Preprocessor(lexed, findings, macros, on_include).run()


class _Preprocessor:
    def __init__(
        self,
        lexed: Lexed,
        findings: Findings,
        macros: Macros,
        on_include: Callable[[Include], None],
    ) -> None:
        self._lexed = lexed
        self._findings = findings
        self._macros = macros
        self._on_include = on_include
        self._conditions: list[_Condition] = []
        self._result = Preprocessed([])
        first = lexed.tokens[0]
        guard = _GUARD.match(first.text) if first.kind == "directive" else None
        self._guard = guard.group(1) if guard else None
        self._protected = False  # True: a guard or #pragma once prevents a second reading

    def run(self) -> Preprocessed:
        out = self._result.tokens
        skipped_from: int | None = None
        for token in self._lexed.tokens:
            if token.kind == "directive":
                if self._result.first_directive is None:
                    self._result.first_directive = token.start
                was_active = self._active
                self._directive(token)
                if was_active and not self._active:
                    skipped_from = token.start
                elif self._active and skipped_from is not None:
                    self._result.skipped.append((skipped_from, token.end))
                    skipped_from = None
            elif token.kind == "eof":
                self._finish()
                if skipped_from is not None:
                    self._result.skipped.append((skipped_from, token.end))
                out.append(token)
            elif self._active:
                out.extend(self._expanded(token))
            if self._active and token.start in self._lexed.trailing:
                self._result.trailing[token.start] = [
                    expanded
                    for written in self._lexed.trailing[token.start]
                    for expanded in self._expanded(written)
                ]
        return self._result

    def _expanded(self, token: Token) -> list[Token]:
        if token.kind == "id" and token.text in self._macros:
            return self._expand(token)
        return [token]

    @property
    def _active(self) -> bool:
        return all(c.active for c in self._conditions)

    def _span(self, token: Token) -> Span:
        return Span(self._lexed.source, token.start, token.end)

    def _finish(self) -> None:
        for condition in self._conditions:
            self._findings.error(
                "G0012", condition.span, "this condition is never closed", "write '#endif'"
            )

    def _directive(self, token: Token) -> None:
        match = _DIRECTIVE.match(token.text)
        assert match is not None
        word, rest = match.group(1), match.group(2).strip()
        if word in ("if", "ifdef", "ifndef", "elif", "else", "endif"):
            self._conditional(word, rest, token)
        elif not self._active or not word:
            return
        elif word == "include":
            self._include(rest, token)
        elif word == "define":
            self._define(rest, token)
            self._protected |= self._guard is not None and self._guard in self._macros
        elif word == "undef":
            self._undefine(rest, token)
        elif word == "pragma":
            self._pragma(rest, token)
        elif word == "error":
            self._findings.error("G0005", self._span(token), f"#error {rest}")
        elif word == "warning":
            self._findings.warning("G0704", self._span(token), f"#warning {rest}")
        elif word not in ("line", "ident") and not word.isdigit():  # skips line markers: `# 1 "x"`
            self._findings.error(
                "G0005",
                self._span(token),
                f"unknown preprocessor line '#{word}'",
                "known lines are #include, #pragma once, #define, #undef, #if, #ifdef, #ifndef, "
                "#elif, #else, #endif, #error, #warning",
            )

    def _pragma(self, rest: str, token: Token) -> None:
        if rest.split()[:1] == ["once"]:
            self._protected = True
        else:
            self._findings.warning_once(
                "G0701",
                self._span(token),
                f"'#pragma {rest}' has no meaning here and is ignored",
                "reported once per run; write repository identifiers with typeid and typeprefix",
            )

    def _include(self, rest: str, token: Token) -> None:
        body = self._macros.get(rest, ())
        if len(body) == 1 and body[0].kind == "string":  # `#include NAME`, NAME a macro
            rest = body[0].text
        match = _INCLUDE.match(rest)
        if match is None:
            self._findings.error(
                "G0005",
                self._span(token),
                "'#include' needs a file name in quotes",
                '#include "robcl/geometry.gidl"',
            )
            return
        path = match.group(1) or match.group(2)
        include = Include(path, match.group(1) is None, self._span(token), self._protected)
        self._result.includes.append(include)
        self._on_include(include)

    def _define(self, rest: str, token: Token) -> None:
        match = _DEFINE.match(rest)
        if match is None:
            self._findings.error("G0005", self._span(token), "'#define' needs a name")
            return
        name, parenthesis, body = match.groups()
        if parenthesis:
            self._macros[name] = (Token("int", "1", 0, 0),)
            self._findings.error(
                "G0211",
                self._span(token),
                f"macro '{name}' has parameters: these are not part of .gidl",
                "write out its expansion, or use a constant",
            )
            return
        quiet = Findings()
        lexed = lex(Source("", "", body), quiet)
        if quiet.found:
            self._findings.error("G0005", self._span(token), f"'{body}' cannot be read")
        self._macros[name] = tuple(t for t in lexed.tokens if t.kind not in ("eof", "directive"))

    def _undefine(self, rest: str, token: Token) -> None:
        match = _DEFINE.match(rest)
        if match is None:
            self._findings.error("G0005", self._span(token), "'#undef' needs a name")
        else:
            self._macros.pop(match.group(1), None)

    def _expand(self, use: Token) -> list[Token]:
        """Tokens of the macro that `use` names; macros inside it are expanded. All tokens get the
        location of `use`."""
        result: list[Token] = []
        work: list[tuple[Token, frozenset[str]]] = [(use, frozenset())]
        while work:
            token, open_names = work.pop()
            body = self._macros.get(token.text) if token.kind == "id" else None
            if body is None or token.text in open_names:
                result.append(Token(token.kind, token.text, use.start, use.end))
            else:
                inner = open_names | {token.text}
                work.extend((t, inner) for t in reversed(body))
            if len(result) + len(work) > _MAX_EXPANSION:
                self._findings.error(
                    "G0005",
                    self._span(use),
                    f"macro '{use.text}' expands to more than {_MAX_EXPANSION} tokens",
                )
                return [Token("int", "1", use.start, use.end)]
        return result

    def _conditional(self, word: str, rest: str, token: Token) -> None:
        if word in ("if", "ifdef", "ifndef"):
            if not self._active:
                active = False
            elif word == "if":
                active = self._evaluate(rest, token)
            else:
                name = _DEFINE.match(rest)
                if name is None:
                    self._findings.error("G0005", self._span(token), f"'#{word}' needs a name")
                active = (name is not None and name.group(1) in self._macros) == (word == "ifdef")
            self._conditions.append(_Condition(self._span(token), active, active))
            return
        if not self._conditions:
            self._findings.error("G0012", self._span(token), f"'#{word}' has no matching '#if'")
            return
        condition = self._conditions[-1]
        if word == "endif":
            self._conditions.pop()
            return
        if condition.in_else:
            self._findings.error("G0012", self._span(token), f"'#{word}' after '#else'")
        condition.in_else = word == "else"
        outer_active = all(c.active for c in self._conditions[:-1])
        if condition.taken or not outer_active:
            condition.active = False
        else:
            condition.active = word == "else" or self._evaluate(rest, token)
            condition.taken = condition.active

    def _evaluate(self, text: str, token: Token) -> bool:
        try:
            return bool(_ConditionReader(text, self._macros).value())
        except (ValueError, ZeroDivisionError, RecursionError):
            self._findings.error(
                "G0005",
                self._span(token),
                f"'{text}' is not a valid condition",
                "a condition may contain numbers, constants, defined(X), comparisons, !, && and ||",
            )
            return False


def _words(text: str) -> list[str]:
    """The tokens of a condition. Raises ValueError if it has others than those of conditions."""
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
    """The text of a macro's body, with one space where it has any."""
    text, end = "", 0
    for token in body:
        text += (" " if token.start > end else "") + token.text
        end = token.end
    return text


def _expanded(text: str, macros: Macros) -> list[str]:
    """The tokens of a condition with its macros expanded, but not the operands of `defined`."""
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
            inner = open_names | {word}
            work.extend((w, inner) for w in reversed(_words(_body_text(macros[word]))))
        else:
            result.append(word)
        if len(result) + len(work) > _MAX_EXPANSION:
            raise ValueError("the macros of the condition expand to too many tokens")
    return result


class _ConditionReader:
    """Computes `#if` conditions, in 64 bits. Raises ValueError if the text is no condition."""

    _LEVELS = (
        ("||",), ("&&",), ("|",), ("^",), ("&",), ("==", "!="), ("<", ">", "<=", ">="),
        ("<<", ">>"), ("+", "-"), ("*", "/", "%"),
    )  # fmt: skip

    def __init__(self, text: str, macros: Macros) -> None:
        self._words = _expanded(text, macros)
        self._macros = macros
        self._at = 0
        self._depth = 0
        self._unneeded = 0  # above 0: in an operand of && or || that does not matter

    def value(self) -> int:
        result = self._binary(0)
        if self._at != len(self._words):
            raise ValueError("text after the condition")
        return result

    def _next(self) -> str:
        if self._at >= len(self._words):
            raise ValueError("condition ends early")
        self._at += 1
        return self._words[self._at - 1]

    def _peek(self) -> str:
        return self._words[self._at] if self._at < len(self._words) else ""

    def _binary(self, level: int) -> int:
        if level == len(self._LEVELS):
            return self._primary()
        left = self._binary(level + 1)
        while self._peek() in self._LEVELS[level]:
            operator = self._next()
            decided = (operator == "&&" and not left) or (operator == "||" and bool(left))
            self._unneeded += decided
            right = self._binary(level + 1)
            self._unneeded -= decided
            left = 0 if self._unneeded else _apply(operator, left, right)
        return left

    def _primary(self) -> int:
        self._depth += 1
        if self._depth > 50:
            raise ValueError("nested too deep")
        word = self._next()
        if word in ("!", "-", "+", "~"):
            inner = self._primary()
            result = {"!": int(not inner), "-": -inner, "+": inner, "~": ~inner}[word]
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
            result = int(name in self._macros)
        elif word[0].isdigit():
            result = _number(word)
        elif word[0].isalpha() or word[0] == "_":
            result = int(word == "true")  # any other name that is no macro is 0
        else:
            raise ValueError(word)
        self._depth -= 1
        return result


def _number(word: str) -> int:
    digits = word.rstrip("uUlL")
    if digits[:2] in ("0x", "0X"):
        return int(digits, 16)
    return int(digits, 8 if digits[0] == "0" else 10)


def _apply(operator: str, left: int, right: int) -> int:
    result = _applied(operator, left, right)
    if abs(result) > _MAX_NUMBER:
        raise ValueError("the result does not fit 64 bits")
    return result


def _applied(operator: str, left: int, right: int) -> int:
    match operator:
        case "|":
            return left | right
        case "^":
            return left ^ right
        case "&":
            return left & right
        case "<<" | ">>":
            if not 0 <= right < 64:
                raise ValueError("shift too far")
            return left << right if operator == "<<" else left >> right
        case "||":
            return int(bool(left or right))
        case "&&":
            return int(bool(left and right))
        case "==":
            return int(left == right)
        case "!=":
            return int(left != right)
        case "<":
            return int(left < right)
        case ">":
            return int(left > right)
        case "<=":
            return int(left <= right)
        case ">=":
            return int(left >= right)
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
    """Rounds towards zero, as C++ does."""
    size = abs(left) // abs(right)
    return size if (left < 0) == (right < 0) else -size
