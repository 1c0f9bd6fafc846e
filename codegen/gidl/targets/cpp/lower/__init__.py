"""C++ text of types and codecs: names, encoded sizes, and code that encodes, decodes and checks.

Sizing, encoding and checking are statements, given as lines; decoding is one boolean expression.
"""

from __future__ import annotations

from gidl.targets.cpp.lower.checks import Checks
from gidl.targets.cpp.lower.reading import Reading
from gidl.targets.cpp.lower.sizes import Sizes
from gidl.targets.cpp.lower.types import PRIMITIVES, Slot
from gidl.targets.cpp.lower.writing import Writing

__all__ = ["PRIMITIVES", "Lowering", "Slot"]


class Lowering(Sizes, Writing, Reading, Checks):
    """The names, sizes, encoding, decoding and checks of all types of one model."""
