"""Breaks lines that are too long at their brackets: our output is laid out without a formatter."""

from __future__ import annotations

from gidl.targets.groups import laid_out_groups

WIDTH = 100
_OPEN = {"(": ")", "[": "]", "{": "}"}


def laid_out(text: str, language: str) -> str:
    """`text` with as many empty lines as the language's readers expect, and no long line."""
    python = language == "python"
    text = laid_out_groups(text, closes_alone=True) if python else wrapped_text(text, language)
    lines = text.split("\n")
    return "\n".join(_spaced(lines, python)).strip("\n") + "\n"


def _spaced(lines: list[str], python: bool) -> list[str]:
    """Two empty lines around what stands at the left edge of Python, else one at most."""
    result: list[str] = []
    empty, block = 0, False  # block: inside a class or function at the left edge
    decorated = False  # behind a decorator of it
    for line in lines:
        if not line.strip():
            empty += 1
            continue
        indented = line[0] in " )]}"
        opens = line.startswith(("class ", "def ", "@"))
        wanted = min(empty, 1)
        if python and not indented and result and not decorated:
            if opens or block:
                wanted = 2
            block = opens
        elif python and not indented:
            block = opens
        decorated = line.startswith("@") if not indented else decorated
        result += [""] * wanted + [line.rstrip()]
        empty = 0
    return result


def wrapped_text(text: str, language: str) -> str:
    """`text` with its long lines of code broken; comments and texts are as they were written."""
    brackets = "([{" if language == "python" else "("
    step = "    "
    comma = language == "python"
    lines: list[str] = []
    for line in text.split("\n"):
        if len(line) > WIDTH and not line.lstrip().startswith(("//", "#", '"""')):
            lines += _wrapped(line, brackets, step, comma)
        else:
            lines.append(line)
    return "\n".join(lines)


def _wrapped(line: str, brackets: str, step: str, comma: bool) -> list[str]:
    if len(line) <= WIDTH:
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    group = _first_group(line, brackets)
    if group is None:
        return [line]
    start, end = group
    head, inside, tail = line[: start + 1], line[start + 1 : end], line[end:]
    parts = _split(inside)
    if len(parts) > 1 and comma:
        pieces = [f"{part}," for part in parts]
    else:
        pieces = [f"{part}," for part in parts[:-1]] + parts[-1:]
    lines = [head]
    for piece in pieces:
        lines += _wrapped(f"{indent}{step}{piece}", brackets, step, comma)
    if comma:
        return [*lines, *_wrapped(f"{indent}{tail}", brackets, step, comma)]
    lines[-1] += tail  # C++ closes on the last line
    return lines


def _first_group(line: str, brackets: str) -> tuple[int, int] | None:
    """The first outermost pair of brackets that has something inside."""
    depth, start, quote = 0, -1, ""
    i = 0
    stack: list[str] = []
    while i < len(line):
        letter = line[i]
        if quote:
            if letter == "\\":
                i += 1
            elif letter == quote:
                quote = ""
        elif letter in "\"'":
            quote = letter
        elif letter in _OPEN:
            if not stack and letter in brackets and start < 0:
                start, depth = i, len(stack)
            stack.append(_OPEN[letter])
        elif stack and letter == stack[-1]:
            stack.pop()
            if start >= 0 and len(stack) == depth:
                if i > start + 1:
                    return start, i
                start = -1
        i += 1
    return None


def _split(inside: str) -> list[str]:
    """Parts between top-level commas. A comprehension is one part."""
    parts, stack, quote, begin = [], 0, "", 0
    i = 0
    while i < len(inside):
        letter = inside[i]
        if quote:
            if letter == "\\":
                i += 1
            elif letter == quote:
                quote = ""
        elif letter in "\"'":
            quote = letter
        elif letter in "([{<" and not (letter == "<" and inside[i : i + 2] in ("<=", "< ", "<<")):
            stack += 1
        elif letter in ")]}" or (letter == ">" and stack and inside[i - 1] not in "-= >"):
            stack -= 1
        elif letter == "," and stack == 0:
            parts.append(inside[begin:i].strip())
            begin = i + 1
        i += 1
    parts.append(inside[begin:].strip())
    if any(part.startswith(("lambda", "for ")) or " for " in part for part in parts[1:]):
        return [inside.strip()] if " for " in inside else parts
    return [part for part in parts if part]
