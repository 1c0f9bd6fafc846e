"""Types in Python: hints, defaults, and the steps of layouts, by the nodes of the wire layout."""

from __future__ import annotations

from gidl.targets.python.lower.steps import Lowering
from gidl.targets.python.lower.types import CODES

__all__ = ["CODES", "Lowering"]
