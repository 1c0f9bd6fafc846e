"""Types and codecs in C++: what a value is called, how large it is, how it is written and read.

Sizes, writing and checking are statements, a list of lines each; reading is one boolean expression.
"""

from __future__ import annotations

from gidl.targets.cpp.lower.checks import Checks
from gidl.targets.cpp.lower.reading import Reading
from gidl.targets.cpp.lower.sizes import Sizes
from gidl.targets.cpp.lower.types import PRIMITIVES, Slot
from gidl.targets.cpp.lower.writing import Writing

__all__ = ["PRIMITIVES", "Lowering", "Slot"]


class Lowering(Sizes, Writing, Reading, Checks):
    """All of it, for one model."""
