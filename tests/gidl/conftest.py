"""Lets the tests of the compiler import it from the tree."""

import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
if str(TREE / "codegen") not in sys.path:
    sys.path.insert(0, str(TREE / "codegen"))
