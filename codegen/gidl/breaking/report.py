"""Collects incompatible changes, each with its reason and an alternative."""

from __future__ import annotations

from gidl.diagnostics.findings import Findings, Note
from gidl.model import Facts, Location

CATEGORIES = ("WIRE", "SOURCE", "QOS", "SECURITY")


def category_of(code: str) -> str:
    """Returns the category of a code: G10xx is WIRE, G11xx is SOURCE, G12xx is QOS, and G13xx is
    SECURITY."""
    return CATEGORIES[int(code[1:3]) - 10]


class Report:
    def __init__(self, label: str) -> None:
        self.findings = Findings()
        self._label = label
        self._broken: set[str] = set()  # scoped names that have a WIRE finding

    def add(
        self,
        code: str,
        subject: str,
        message: str,
        why: str,
        instead: str,
        *,
        new: Facts | None = None,
        old: Facts | None = None,
    ) -> None:
        """Adds a finding at the location of `new`, with a note at the location of `old`. A removed
        declaration has no `new`; the finding is then at the location of `old`."""
        notes: tuple[Note, ...] = ()
        if new is not None:
            at = new.location
            if old is not None:
                notes = (Note("the old declaration is here", self._old(old.location)),)
        else:
            assert old is not None
            at = self._old(old.location)
        category = category_of(code)
        if category == "WIRE":
            self._broken.add(subject)
        self.findings.error(code, at, f"{category}: {message}", why, instead, notes=notes)

    def has_broken(self, subject: str) -> bool:
        """Returns whether the declaration or member named `subject` has a WIRE finding."""
        return subject in self._broken

    def _old(self, place: Location) -> Location:
        return Location(f"{self._label}{place.file}", place.line, place.column)
