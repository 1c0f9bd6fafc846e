"""Builds lines of C++: blocks, loops, lambdas, conjunctions."""

from __future__ import annotations

from gidl.targets.groups import flat


def of(x: str, what: str) -> str:
    return f"{x[1:]}->{what}" if x.startswith("*") else f"{x}.{what}"


def quoted(text: str) -> str:
    """Returns a string literal for `text`. @pre no character of `text` needs an escape"""
    return f'"{text}"'


def rows(words: list[str]) -> list[str]:
    """Returns `words` in lines of at most 90 characters."""
    lines: list[str] = []
    for word in words:
        if lines and len(lines[-1]) + len(word) < 90:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def indented(lines: list[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def block(head: str, lines: list[str]) -> list[str]:
    """Returns a block: `head`, and the statements `lines` in braces. A single short statement is
    put on the line of `head`, without braces."""
    if len(lines) == 1 and len(head) + len(lines[0]) < 80:
        return [f"{head} {lines[0]}"]
    return [f"{head} {{", *indented(lines), "}"]


def loop(item: str, over: str, lines: list[str], kind: str = "const auto&") -> list[str]:
    return block(f"for ({kind} {item} : {over})", lines) if lines else []


def with_lambda(head: str, name: str, body: list[str]) -> list[str]:
    """Returns a call: `head` has the function and the first arguments. The last argument is a
    lambda with the parameter `name` that returns the expression `body`."""
    lines = returning(body)
    if len(lines) == 1 and len(flat(head + lines[0])) < 70:
        return [f"{head}[&](auto& {name}) {{ {lines[0]} }})"]
    if len(flat(head)) > 64:
        return [
            head.rstrip(),
            f"    [&](auto& {name}) {{",
            *indented(indented(indented(lines))),
            "    })",
        ]
    return [f"{head}[&](auto& {name}) {{", *indented(lines), "})"]


def or_at_end(reader: str, term: list[str]) -> list[str]:
    """Returns an expression that is true if the reader is at the end of the message, because an
    older writer sent the value. Otherwise the expression has the value of `term`."""
    lines = [f"({reader}.at_end() ||", *(f" {line}" for line in term)]
    if len(term) > 1 and term[0].endswith("&&"):
        lines[1] = f" ({term[0]}"
        lines[-1] += ")"
    lines[-1] += ")"
    return lines


def joined_terms(terms: list[list[str]]) -> list[str]:
    """Returns the terms joined by &&, one term on each line."""
    lines: list[str] = []
    for i, term in enumerate(terms):
        lines += term
        if i < len(terms) - 1:
            lines[-1] += " &&"
    return lines


def conjunction(terms: list[list[str]]) -> list[str]:
    """Returns the statement `return a && b;`, with one term on each line."""
    if not terms:
        return ["return true;"]
    return returning(joined_terms(terms))


def joined_puts(lines: list[str], writer: str) -> list[str]:
    """Returns `lines` with consecutive statements such as `to.put(x);` and `to.put(y);` joined to
    `to.put(x, y);`."""
    head, joined, values = f"{writer}.put(", list[str](), list[str]()
    for line in [*lines, ""]:
        if line.startswith(head):
            values.append(line.removeprefix(head).removesuffix(");"))
            continue
        if values:
            joined += _call_over_lines(head, values)
            values = []
        joined.append(line)
    return joined[:-1]


def _call_over_lines(head: str, arguments: list[str]) -> list[str]:
    lines = [head + arguments[0]]
    for argument in arguments[1:]:
        if len(lines[-1]) + len(argument) > 90:
            lines[-1] += ","
            lines.append(" " * len(head) + argument)
        else:
            lines[-1] += f", {argument}"
    lines[-1] += ");"
    return lines


def returning(expression: list[str]) -> list[str]:
    lines = [f"return {expression[0]}", *(f"       {line}" for line in expression[1:])]
    lines[-1] += ";"
    return lines
