"""Names, output files and documentation lines, which the targets of all languages share."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass

from gidl.model import (
    AnnotationDeclaration,
    Facts,
    Location,
    Model,
    Range,
    Value,
)
from gidl.targets.groups import without_marks


@dataclass(frozen=True, slots=True)
class OutputFile:
    """A file to write: the result of rendering `template` with `view`. `path` is relative to the
    output folder."""

    path: str
    language: str  # folder in `targets` that contains the template
    template: str
    view: object


DOC_WIDTH = 86  # characters of a line of documentation, without indentation


class UnsupportedError(Exception):
    """The interface uses a construct that no target supports yet."""

    def __init__(self, location: Location, text: str) -> None:
        super().__init__(f"{location.file}:{location.line}:{location.column}: {text}")
        self.location = location
        self.text = text


class LocalNames:
    """Chooses unique names for locals, parameters and helpers of a scope. A name that is already
    taken gets underscores at its end."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def fresh(self, wanted: str) -> str:
        while wanted in self._taken:
            wanted += "_"
        self._taken.add(wanted)
        return wanted


def wrapped(line: str, width: int) -> list[str]:
    """Returns a line of a comment, wrapped to `width` characters. A word that is longer than
    `width`, for example a URL, is not split."""
    return textwrap.wrap(line, width, break_long_words=False, break_on_hyphens=False) or [""]


def doc_lines(facts: Facts, note: str = "") -> tuple[str, ...]:
    """Returns the documentation: the author's comment, then `note` in brackets, then @since and
    @deprecated."""
    lines: list[str] = []
    for line in without_marks(facts.doc).strip().splitlines():
        lines += wrapped(line.strip(), DOC_WIDTH)
    if note:
        if lines:
            lines[-1] = f"{lines[-1]} [{note}]"
        else:
            lines.append(f"[{note}]")
    if facts.since:
        lines.append(f"Since {facts.since}.")
    if facts.deprecated is not None:
        why = " ".join(without_marks(facts.deprecated).split())
        lines += wrapped(f"Deprecated: {why}" if why else "Deprecated.", DOC_WIDTH)
    return tuple(lines)


def value_note(unit: str | None, limits: Range | None, bound: int | None = None) -> str:
    """Returns unit, range and largest size of a value for documentation, for example "m, 0.01 to
    1.0"."""
    parts = [unit] if unit else []
    if limits is not None:
        parts.append(range_words(limits))
    if bound is not None:
        parts.append(f"at most {bound}")
    return ", ".join(parts)


def range_words(limits: Range) -> str:
    if limits.minimum is None:
        return f"at most {limits.maximum}"
    if limits.maximum is None:
        return f"at least {limits.minimum}"
    return f"{limits.minimum} to {limits.maximum}"


def range_text(limits: Range, unit: str | None) -> str:
    """Returns a range as messages show it, for example "[0.01, 1.0] m/s". A number without a
    dimension, whose unit is "1", is shown without a unit."""
    lower = "-inf" if limits.minimum is None else str(limits.minimum)
    upper = "inf" if limits.maximum is None else str(limits.maximum)
    return f"[{lower}, {upper}]{f' {unit}' if unit and unit != '1' else ''}"


def is_number(value: Value | None) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def snake_case(name: str) -> str:
    """Returns a name in snake case: "laser_distance_sensor" for "LaserDistanceSensor", and "rx90"
    for "Rx90"."""
    out = ""
    for i, letter in enumerate(name):
        starts = letter.isupper() and i > 0
        after_small = starts and (name[i - 1].islower() or name[i - 1].isdigit())
        before_small = starts and i + 1 < len(name) and name[i + 1].islower()
        if (after_small or (before_small and name[i - 1] != "_")) and name[i - 1] != "_":
            out += "_"
        out += letter.lower()
    return out


def has_output(model: Model, path: str) -> bool:
    """Returns whether code is generated for the file `path`. No code is generated for a file that
    includes nothing and declares nothing but annotations."""
    file = next(f for f in model.files if f.path == path)
    printed = any(not isinstance(d, AnnotationDeclaration) for d in file.declarations)
    return printed or bool(file.includes)
