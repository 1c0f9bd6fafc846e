"""Incompatible changes between two checked models of interfaces.

WIRE: old and new programs refuse or misread each other. SOURCE: programs have to be changed before
they build again. QOS: a weaker promise. SECURITY: different clients may call. A change is reported
once, under the first category that applies.
"""

from __future__ import annotations

from gidl.breaking import calls, values
from gidl.breaking.report import CATEGORIES, Report, category_of
from gidl.breaking.sides import Sides
from gidl.diagnostics import Finding
from gidl.model import Model

__all__ = ["CATEGORIES", "category_of", "compare"]


def compare(old: Model, new: Model, label: str = "old:") -> list[Finding]:
    """Findings, sorted by category, then place. Places in the old files begin with `label`."""
    sides = Sides(old, new)
    report = Report(label)
    values.compare(sides, report)
    calls.compare(sides, report)
    order = [file.path for file in new.files]
    found = report.findings.in_order(order)
    return sorted(found, key=lambda f: CATEGORIES.index(category_of(f.code)))
