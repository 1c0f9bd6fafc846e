"""Words in front of a command that runs where the tree is an empty folder."""

from __future__ import annotations

import os
import sysconfig
from collections.abc import Mapping, Sequence
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
MOUNTS_OF_ITS_OWN = ("unshare", "-m") if os.geteuid() == 0 else ("unshare", "-Urm")
MOUNT = """
mount --bind "$1" "$2"; mount -t tmpfs none "$3"; shift 3
while [ "$1" != -- ]; do mount --bind "$1" "$2"; shift 2; done
shift; exec "$@"
"""


def without_tree(
    packages: Path,
    also: Mapping[str, Path] | None = None,
    mounts: Sequence[str] = MOUNTS_OF_ITS_OWN,
) -> Sequence[str | Path]:
    """`packages`: an empty folder, in which the packages of the tree's virtual environment are
    seen. `also`: folders, by the place where they are seen. `mounts`: words that make mounts of
    its own."""
    of_environment = sysconfig.get_path("purelib")
    pairs = [word for place, folder in (also or {}).items() for word in (folder, place)]
    words = (of_environment, packages, TREE, *pairs, "--")
    return (*mounts, "sh", "-euc", MOUNT, "sh", *words)
