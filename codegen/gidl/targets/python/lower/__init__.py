"""Types and codecs in Python: hints, defaults, how a value is written and read.

Writing is statements that append to `out`; reading is an expression over `source`. All of it goes
by the nodes of the wire layout.
"""

from __future__ import annotations

from gidl.targets.python.lower.plans import Plans
from gidl.targets.python.lower.reading import Reading
from gidl.targets.python.lower.runs import Leaf, Run
from gidl.targets.python.lower.shapes import Shapes
from gidl.targets.python.lower.types import CODES, Slot, holds_array, indented
from gidl.targets.python.lower.writing import Writing

__all__ = ["CODES", "Leaf", "Lowering", "Run", "Slot", "holds_array", "indented"]


class Lowering(Writing, Reading, Shapes, Plans):
    """All of it, for one module."""
