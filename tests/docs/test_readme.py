"""The README's example is real: its interface compiles, and so does what uses it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]

CPP_AROUND = """\
#include <chrono>
#include <iostream>

#include "gecos/gecos.hpp"
#include "oven_client.hpp"

using namespace std::chrono_literals;

template <class Error>
int fail(const Error& error) {{
  std::cerr << error << std::endl;
  return 1;
}}

int main() {{
{block}
  return warm ? 0 : fail(warm.error());
}}
"""

PYTHON_AROUND = """\
import gecos
from oven import Oven

{block}
"""


def block(language: str) -> str:
    """The first fenced block of `language` in the README."""
    text = (TREE / "README.md").read_text(encoding="utf-8")
    found = re.search(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert found is not None, f"the README has no {language} block"
    return found[1]


def run(*command: object, **environment: str) -> None:
    done = subprocess.run(
        [str(word) for word in command],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What gidl makes of the README's interface."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "oven.gidl").write_text(block("idl"))
    command = [sys.executable, "-m", "gidl", "gen", "-I", folder, "--out", folder / "out"]
    run(*command, folder / "oven.gidl")
    return folder / "out"


def test_the_interface_has_ten_lines() -> None:
    assert len(block("idl").splitlines()) == 10


def test_the_cpp_compiles(generated: Path, tmp_path: Path) -> None:
    source = tmp_path / "program.cpp"
    source.write_text(CPP_AROUND.format(block=block("cpp")))
    roots = [TREE / "runtime/cpp", TREE / "generated/cpp", generated / "cpp"]
    run(
        *("c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror"),
        *(f"-I{root}" for root in roots),
        source,
    )


def test_the_python_is_well_typed(generated: Path, tmp_path: Path) -> None:
    source = tmp_path / "program.py"
    source.write_text(PYTHON_AROUND.format(block=block("python")))
    roots = [TREE / "runtime/python", TREE / "generated/python", generated / "python"]
    run(
        *(sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases"),
        *("--config-file", os.devnull, "--cache-dir", tmp_path / "cache"),
        source,
        MYPYPATH=":".join(str(root) for root in roots),
    )
