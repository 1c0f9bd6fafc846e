"""Modules that gidl generates while the tests run."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest


@contextmanager
def imported(module: str, source: Path, root: Path, out: Path) -> Iterator[Any]:
    """Generates Python from `source`, whose includes begin at `root`, into the folder `out`, and
    imports `module` of it. The module can be imported until the context ends."""
    words = ["--lang", "python", "-I", root, "--out", out, source]
    subprocess.run(
        [sys.executable, "-m", "gidl", "gen", *words], check=True, stdout=subprocess.DEVNULL
    )
    with pytest.MonkeyPatch.context() as path:
        path.syspath_prepend(str(out / "python"))
        yield importlib.import_module(module)
