"""What the tests of generated code share: the interface with everything, generated once."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
for folder in ("codegen", "runtime/python", "generated/python", "tests/generated"):
    if str(TREE / folder) not in sys.path:
        sys.path.insert(0, str(TREE / folder))

from generating import generate  # noqa: E402  (found by the lines above)
from gidl.model import Model  # noqa: E402


@pytest.fixture(scope="session")
def model() -> Model:
    import type_values

    return type_values.load()


@pytest.fixture(scope="session")
def everything(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Output folder for tests/idl/everything.gidl; its Python can be imported."""
    out = tmp_path_factory.mktemp("everything")
    generate(out, TREE / "tests" / "idl" / "everything.gidl")
    sys.path.insert(0, str(out / "python"))
    yield out
    sys.path.remove(str(out / "python"))
