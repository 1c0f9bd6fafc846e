"""Finds incompatible changes between the old and the new model of a set of interfaces.

There are four categories. WIRE: old and new programs refuse or misread each other's messages.
SOURCE: programs must be changed before they build again. QOS: an interface promises less. SECURITY:
access or protection changed. A change is reported once, under the first of these categories that
applies.
"""

from __future__ import annotations

from gidl.breaking import calls, values
from gidl.breaking.report import CATEGORIES, Report, category_of
from gidl.breaking.sides import Sides
from gidl.diagnostics.findings import Finding
from gidl.model import Model

__all__ = ["CATEGORIES", "category_of", "compare"]


def compare(old: Model, new: Model, label: str = "old:") -> list[Finding]:
    """Returns the incompatible changes, sorted by category, then by place. Messages write `label`
    before the paths of old files."""
    sides = Sides(old, new)
    report = Report(label)
    values.compare(sides, report)
    calls.compare(sides, report)
    order = [file.path for file in new.files]
    found = report.findings.in_order(order)
    return sorted(found, key=lambda f: CATEGORIES.index(category_of(f.code)))
