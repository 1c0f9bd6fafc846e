"""C++ text of types and codecs: names, encoded sizes, and code that encodes, decodes and checks.

Sizing, encoding and checking are statements, given as lines; decoding is one boolean expression.
"""

from __future__ import annotations

from gidl.targets.cpp.decoding import Reading
from gidl.targets.cpp.encoded_sizes import Sizes
from gidl.targets.cpp.encoding import Writing
from gidl.targets.cpp.value_checks import Checks


class Lowering(Sizes, Writing, Reading, Checks):
    """The names, sizes, encoding, decoding and checks of all types of one model."""
