"""Collects incompatible changes, each with its reason and an alternative."""

from __future__ import annotations

from gidl.diagnostics import Findings, Note
from gidl.model import Facts, Location

CATEGORIES = ("WIRE", "SOURCE", "QOS", "SECURITY")


def category_of(code: str) -> str:
    """G10.. is WIRE, G11.. SOURCE, G12.. QOS, G13.. SECURITY."""
    return CATEGORIES[int(code[1:3]) - 10]


class Report:
    def __init__(self, label: str) -> None:
        self.findings = Findings()
        self._label = label
        self._broken: set[str] = set()  # subjects of WIRE findings

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
        """Adds a finding at the place in the new files, with a note at the old one; a removal with
        no place in the new files is shown in the old ones."""
        notes: tuple[Note, ...] = ()
        if new is not None:
            at = new.location
            if old is not None:
                notes = (Note("it was here", self._old(old.location)),)
        else:
            assert old is not None
            at = self._old(old.location)
        category = category_of(code)
        if category == "WIRE":
            self._broken.add(subject)
        self.findings.error(code, at, f"{category}: {message}", why, instead, notes=notes)

    def has_broken(self, subject: str) -> bool:
        """Whether a WIRE finding is about this declaration or member."""
        return subject in self._broken

    def _old(self, place: Location) -> Location:
        return Location(f"{self._label}{place.file}", place.line, place.column)
