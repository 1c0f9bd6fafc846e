"""Processes preprocessor lines: `#include`, include guards, `#pragma once`, conditions and
constants.

Each file is read only once per run, even without an include guard. Macros are constants, for
example `#define RATE 250`. Macros with parameters are reported as unsupported.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Source, Span
from gidl.syntax.conditions import MAX_EXPANSION, Macros, RefusedError, is_true
from gidl.syntax.lexer import Lexed, Token, lex
from gidl.syntax.tree import Include

_DIRECTIVE = re.compile(r"#[ \t]*(\w*)[ \t]*(.*)", re.DOTALL)
_INCLUDE = re.compile(r'(?:"([^"\n]+)"|<([^>\n]+)>)\s*$')
_DEFINE = re.compile(r"([A-Za-z_]\w*)(\(?)(.*)", re.DOTALL)
_GUARD = re.compile(r"#[ \t]*(?:ifndef[ \t]+|if[ \t]*![ \t]*defined[ \t]*\(?[ \t]*)([A-Za-z_]\w*)")


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
    # The tokens of `//@` comments after code, with macros expanded. Comments in text that an `#if`
    # skips are left out. The keys are those of `Lexed.trailing`.
    trailing: dict[int, list[Token]] = field(default_factory=dict)


def preprocess(
    lexed: Lexed,
    findings: Findings,
    macros: Macros,
    on_include: Callable[[Include], None],
) -> Preprocessed:
    """Executes the preprocessor lines, and calls `on_include` for each `#include`. This function
    and `on_include` both read and change `macros`."""
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
                self._result.trailing[token.start] = _without_arguments(
                    [
                        expanded
                        for written in self._lexed.trailing[token.start]
                        for expanded in self._expanded(written)
                    ]
                )
        self._result.tokens = _without_arguments(out)
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
        # Line markers such as `# 1 "x"` are skipped.
        elif word not in ("line", "ident") and not word.isdigit():
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
        if len(body) == 1 and body[0].kind == "string":  # `#include NAME`, where NAME is a macro
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
            self._macros[name] = (Token("macro", name, 0, 0),)
            self._findings.error(
                "G0211",
                self._span(token),
                f"macro '{name}' has parameters; .gidl has only macros without parameters",
                "replace each use of the macro by its expansion, or use a constant",
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
        """Returns the tokens of the macro that `use` names, with macros inside it expanded. All
        tokens get the location of `use`."""
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
            if len(result) + len(work) > MAX_EXPANSION:
                self._findings.error(
                    "G0005",
                    self._span(use),
                    f"macro '{use.text}' expands to more than {MAX_EXPANSION} tokens",
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
            return is_true(text, self._macros)
        except RefusedError:
            return False
        except (ValueError, ZeroDivisionError, RecursionError):
            self._findings.error(
                "G0005",
                self._span(token),
                f"'{text}' is not a valid condition",
                "a condition may contain numbers, constants, defined(X), comparisons, !, && and ||",
            )
            return False


def _without_arguments(tokens: list[Token]) -> list[Token]:
    """Returns `tokens` without the arguments of macros with parameters. As in C++, the name of such
    a macro without arguments is an ordinary identifier."""
    result: list[Token] = []
    depth: int | None = None  # how many brackets are open in the arguments
    for index, token in enumerate(tokens):
        if depth is not None and token.kind != "eof":
            depth += {"(": 1, ")": -1}.get(token.text, 0) if token.kind == "op" else 0
            depth = depth or None
        elif token.kind != "macro":
            result.append(token)
        elif tokens[index + 1 : index + 2] and tokens[index + 1].text == "(":
            result.append(token)
            depth = 0
        else:
            result.append(token._replace(kind="id"))
    return result
