"""The gate: random .gidl files, and those of the corpus, through the whole compiler and both
languages. `python tests/generated/gate --random 20 --seed 7`; exits 1 with what differs."""

from __future__ import annotations

import sys
from pathlib import Path

TREE = Path(__file__).resolve().parents[3]
for place in (
    "codegen",
    "runtime/python",
    "generated/python",
    "tests/generated",
    "tests/generated/gate",
):
    if str(TREE / place) not in sys.path:
        sys.path.insert(0, str(TREE / place))

from gate_run import main  # noqa: E402  (found by the lines above)

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
