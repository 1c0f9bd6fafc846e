"""Splits text into tokens. The lexer never fails: each error becomes a finding, and reading
continues.

Comments are collected separately: the parser finds the documentation of a declaration by the
positions of tokens. `//@name(...)` comments become annotation tokens. The tokens of a comment that
is alone on its line join the token stream. The tokens of a comment that follows code on its line
are kept in `Lexed.trailing`.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import NamedTuple

from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Source, Span
from gidl.syntax.annotation_places import PLACES


class Token(NamedTuple):
    # The kind of the token: "id", "escaped" (an identifier after an underscore, as in `_module`),
    # "op", "directive" or "eof"; for literals "int", "float", "fixed", "string", "char",
    # "wide_string" or "wide_char". The preprocessor adds the kind "macro": the use of a macro with
    # parameters, which is already reported.
    kind: str
    text: str  # identifiers without the escaping underscore, literals with quotes
    start: int
    end: int


class Comment(NamedTuple):
    text: str  # includes the comment marks
    start: int
    end: int
    own_line: bool  # True: only white space precedes the comment on its line


@dataclass(slots=True)
class Lexed:
    source: Source
    tokens: list[Token]  # the last token is of kind "eof"
    comments: list[Comment] = field(default_factory=list)
    # Tokens of `//@` comments after code. The key is the offset of the token before the comment.
    trailing: dict[int, list[Token]] = field(default_factory=dict)


TOKEN = re.compile(
    r"""
      (?P<space>(?:[ \t\r\n\f\v\ufeff]+|\\[ \t\r\f\v]*\n)+)  # continued lines, too
    | (?P<comment>//[^\n]*|/\*.*?\*/)
    | (?P<open_comment>/\*)
    | (?P<wide_string>L"(?:[^"\\\n]|\\[^\n])*")
    | (?P<wide_char>L'(?:[^'\\\n]|\\[^\n])[^'\n]{0,7}')
    | (?P<escaped>_[A-Za-z][A-Za-z0-9_]*)
    | (?P<id>[A-Za-z][A-Za-z0-9_]*)
    | (?P<fixed>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)[dD](?![A-Za-z0-9_]))
    | (?P<float>(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)
    | (?P<int>0[xX][0-9A-Fa-f]+|[0-9]+)
    | (?P<string>"(?:[^"\\\n]|\\[^\n])*")
    | (?P<char>'(?:[^'\\\n]|\\[^\n])[^'\n]{0,7}')
    | (?P<op>::|<<|>>|[{}()\[\]<>;:,=@+\-*/%&|^~])
    | (?P<directive>\#)
    """,
    re.VERBOSE | re.DOTALL,
)
_DIRECTIVE_PART = re.compile(
    r"""
      (?P<splice>\\[ \t\r\f\v]*\n)  # GCC and Clang allow white space after the backslash, too
    | (?P<comment>/\*.*?\*/)
    | (?P<end>//|/\*|\n)  # an unclosed comment is reported by the lexer
    | (?P<space>[ \t\r\f\v]+)
    | (?P<text>\#[ \t]*include[ \t]*<[^>\n]*>|"(?:[^"\\\n]|\\(?:\r\n|.))*"
        |'(?:[^'\\\n]|\\(?:\r\n|.))*'
        |[^\\\n"'/ \t\r\f\v]+|\\[^\n]|.)
    """,
    re.VERBOSE | re.DOTALL,
)
_FOREIGN_COMMENT = re.compile(r"//@[ \t]*([A-Za-z_]\w*)(?:[ \t]*-|[ \t]+(?!//)[^\s@(])")
_ALPHABET = "names are ASCII letters, digits and '_'; other characters only in comments and strings"
_IDENTIFIER_TAIL = re.compile(r"[A-Za-z0-9_]+")


def lex(source: Source, findings: Findings) -> Lexed:
    return _Lexer(source, findings).run()


class _Lexer:
    def __init__(self, source: Source, findings: Findings) -> None:
        self._source = source
        self._findings = findings
        self._lexed = Lexed(source, [])

    def run(self) -> Lexed:
        text = self._source.text
        end = len(text)
        at = 0
        tokens = self._lexed.tokens
        match_at = TOKEN.match
        while at < end:
            match = match_at(text, at)
            if match is None:
                at = self._unknown(at)
                continue
            kind = match.lastgroup
            stop = match.end()
            if kind == "space":
                pass
            elif kind == "comment":
                self._comment(match.group(), at, stop)
            elif kind == "escaped":
                tokens.append(Token("escaped", text[at + 1 : stop], at, stop))
            elif kind == "directive":
                stop = self._directive(at)
            elif kind == "open_comment":
                self._error("G0006", at, at + 2, "this comment is never closed", "write '*/'")
                stop = end
            else:
                body = text[at:stop]
                if kind in ("int", "float"):
                    stop = self._number(at, stop)
                tokens.append(Token(kind or "", body, at, stop))
            at = stop
        tokens.append(Token("eof", "", end, end))
        if self._source.foreign:
            self._judge_foreign_bytes()
        return self._lexed

    def _judge_foreign_bytes(self) -> None:
        """Reports bytes that are not UTF-8. Such bytes in comments give one warning for the whole
        file. Outside comments, each line with such bytes gives an error."""
        text = self._source.text
        starts = [comment.start for comment in self._lexed.comments]
        warned = False
        line_end = 0  # end of the last line with a reported byte
        for at in self._source.foreign:
            index = bisect_right(starts, at) - 1
            if index >= 0 and at < self._lexed.comments[index].end:
                if not warned:
                    self._findings.warning(
                        "G0706",
                        Span(self._source, at, at + 1),
                        "this comment is not UTF-8; it is read as Latin-1",
                        "reported once per file; to convert the file: iconv -f latin1 -t utf-8",
                    )
                warned = True
            elif at >= line_end:
                line_end = text.find("\n", at) if "\n" in text[at:] else len(text)
                self._error(
                    "G0002",
                    at,
                    at + 1,
                    f"byte {ord(text[at]):#04x} is not UTF-8",
                    "text outside comments must be UTF-8",
                )

    def _error(self, code: str, start: int, end: int, message: str, *help_lines: str) -> None:
        self._findings.error(code, Span(self._source, start, end), message, *help_lines)

    def _unknown(self, at: int) -> int:
        """Reports an unknown character, and returns the offset at which lexing continues. Reads an
        unclosed literal or a word with foreign letters as a token, so that the parser finds no
        second error."""
        text = self._source.text
        char = text[at]
        if char in "\"'":
            return self._unclosed(at)
        if char == "_" or (not char.isascii() and char.isprintable()):
            return self._foreign_word(at)
        shown = char if char.isprintable() else f"U+{ord(char):04X}"
        self._error("G0008", at, at + 1, f"'{shown}' is not a character of .gidl", _ALPHABET)
        return at + 1

    def _unclosed(self, at: int) -> int:
        """Reports an unclosed literal. The literal is assumed to end at the end of its line, before
        any closing `;,})`."""
        text = self._source.text
        line_end = text.find("\n", at)
        end = len(text) if line_end < 0 else line_end
        name = "string" if text[at] == '"' else "character"
        self._error("G0007", at, end, f"this {name} literal is not closed on its line")
        while end > at + 1 and text[end - 1] in " \t\r;,})":
            end -= 1
        body = text[at + 1 : end].replace("\\", "") if name == "string" else "?"
        quote = text[at]
        kind = "string" if name == "string" else "char"
        self._lexed.tokens.append(Token(kind, f"{quote}{body}{quote}", at, end))
        return end

    def _foreign_word(self, at: int) -> int:
        """Reports a word with letters outside ASCII once, and reads the word as an identifier."""
        text = self._source.text
        tokens = self._lexed.tokens
        start = at
        if tokens and tokens[-1].kind == "id" and tokens[-1].end == at:
            start = tokens.pop().start
        end = at
        while end < len(text) and (
            text[end] == "_" or text[end].isalnum() or not text[end].isascii()
        ):
            if not text[end].isprintable():
                break
            end += 1
        word = text[start:end]
        help_line = _ALPHABET
        if word[0] == "_":
            help_line = "a name starts with a letter, or with one '_', which escapes keywords"
        self._error("G0008", start, end, f"'{word}' is not a valid name", help_line)
        tokens.append(Token("id", word, start, end))
        return end

    def _number(self, start: int, end: int) -> int:
        """Returns the end of a number. Reports letters directly after the digits, and the digits 8
        and 9 in an octal number."""
        text = self._source.text
        tail = _IDENTIFIER_TAIL.match(text, end)
        if tail is not None:
            shown = text[start : tail.end()]
            self._error(
                "G0009",
                start,
                tail.end(),
                f"'{shown}' is no number",
                'quantities with a unit are strings: "5ms", "250Hz"',
            )
            return tail.end()
        digits = text[start:end]
        if len(digits) > 1 and digits[0] == "0" and digits.isdigit() and set(digits) & {"8", "9"}:
            self._error(
                "G0009",
                start,
                end,
                f"'{digits}' starts with 0, so it is octal: the digits 8 and 9 are not allowed",
                f"write {digits.lstrip('0')}",
            )
        elif len(digits) > 300:
            self._error("G0009", start, end, "this number is too long")
        return end

    def _directive(self, at: int) -> int:
        text = self._source.text
        line_start = text.rfind("\n", 0, at) + 1
        if text[line_start:at].strip(" \t\ufeff"):
            self._error("G0008", at, at + 1, "'#' is allowed only at the beginning of a line")
            return at + 1
        line, stop = directive_line(text, at)
        self._lexed.tokens.append(Token("directive", line, at, stop))
        return stop

    def _comment(self, comment: str, start: int, end: int) -> None:
        text = self._source.text
        line_start = text.rfind("\n", 0, start) + 1
        own_line = not text[line_start:start].strip()
        if comment.startswith("//@"):
            self._annotation_comment(start, end, own_line)
            return
        if comment.startswith("//") and comment.rstrip("\r").endswith("\\"):
            self._spliced_comment(end)
        self._lexed.comments.append(Comment(comment, start, end, own_line))

    def _spliced_comment(self, end: int) -> None:
        """Reports a `//` comment that ends at `end` and has a backslash at the end of its line,
        because a C++ preprocessor reads the next line as part of the comment."""
        text = self._source.text
        following = text[end + 1 :].partition("\n")[0].strip()
        if not following or following.startswith("//"):
            return  # the comment means the same with and without the backslash
        at = text.rindex("\\", 0, end)
        self._findings.warning(
            "G0710",
            Span(self._source, at, at + 1),
            "this '\\' makes the next line a part of the comment for other IDL compilers, but not "
            "for gidl",
            "remove the '\\', or begin the next line with '//'",
        )

    def _foreign_comment(self, name: str, start: int, end: int) -> None:
        """Reports a comment that begins like an annotation but is none: for example a comment for
        another tool (`//@top-level false`), or an annotation without parentheses (`//@unit
        "m"`)."""
        span = Span(self._source, start, end)
        written = self._source.text[start:end].rstrip()
        if name in PLACES:
            self._findings.error(
                "G0502",
                span,
                f"'{written}' is no complete annotation: write its arguments in parentheses",
                f"//@{name}(...)",
            )
            return
        self._findings.warning(
            "G0705", span, f"'{written}' is a comment for another tool; it is ignored"
        )

    def _annotation_comment(self, start: int, end: int, own_line: bool) -> None:
        """Lexes the text of a `//@` comment as code, from the `@` up to the next `//`."""
        at = start + 2
        text = self._source.text
        foreign = _FOREIGN_COMMENT.match(text, start, end)
        if foreign is not None:
            self._foreign_comment(foreign.group(1), start, end)
            return
        found: list[Token] = []
        while at < end:
            match = TOKEN.match(text, at, end)
            if match is None:
                at = min(self._unknown(at), end)
                continue
            kind, stop = match.lastgroup or "", match.end()
            if kind == "comment":
                self._comment(match.group(), at, stop)
            elif kind not in ("space", "escaped", "open_comment", "directive"):
                found.append(Token(kind, match.group(), at, stop))
            elif kind == "escaped":
                found.append(Token(kind, match.group()[1:], at, stop))
            at = stop
        tokens = self._lexed.tokens
        if own_line or not tokens:
            tokens.extend(found)
        else:
            self._lexed.trailing.setdefault(tokens[-1].start, []).extend(found)


def directive_line(text: str, at: int) -> tuple[str, int]:
    """Reads the preprocessor line whose `#` is at the offset `at`. Returns the text of the line and
    the offset where the line ends. In the text, each comment is replaced by one space, and
    continued lines are joined. Comments after the last word are not part of the line, because they
    may document the next declaration."""
    said = ""
    stop = at
    words = 0  # length of `said` without spaces after its last word
    for part in _DIRECTIVE_PART.finditer(text, at):
        kind = part.lastgroup
        if kind == "end":
            break
        if kind in ("space", "comment"):
            said += part.group() if kind == "space" else " "
        elif kind == "text":
            said += part.group().replace("\\\r\n", "").replace("\\\n", "")
            words = len(said)
            stop = part.end()
    return said[:words], stop
