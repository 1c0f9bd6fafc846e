"""Lets the tests of the compiler import it, and what generated Python stands on, from the tree."""

import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
for room in ("runtime/python", "codegen"):
    if str(TREE / room) not in sys.path:
        sys.path.insert(0, str(TREE / room))
