"""Makes the mistakes of C++ programs: at run time, in front of the compiler, and with CMake."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from mistakes import TREE, Mistake, of_kind, settled, write_files

CMAKE_LISTS = """\
cmake_minimum_required(VERSION 3.22)
project(mistake CXX)
include(CMakePackageConfigHelpers)
foreach(name generated gecos_session json)
  add_library(robcl::${{name}} INTERFACE IMPORTED)
endforeach()
set(PACKAGE_idl "{tree}/idl")
set(PACKAGE_python "{tree}/codegen")
configure_package_config_file("{tree}/cmake/robclConfig.cmake.in"
  "${{CMAKE_BINARY_DIR}}/robcl/robclConfig.cmake" INSTALL_DESTINATION lib/cmake/robcl)
file(COPY "{tree}/cmake/Gidl.cmake" DESTINATION "${{CMAKE_BINARY_DIR}}/robcl")
foreach(name SystemLibraries robclTargets robclArmTargets)
  file(WRITE "${{CMAKE_BINARY_DIR}}/robcl/${{name}}.cmake" "")
endforeach()
set(robcl_DIR "${{CMAKE_BINARY_DIR}}/robcl")
{before}
{code}
"""


def each(kind: str) -> pytest.MarkDecorator:
    mistakes = of_kind(kind)
    return pytest.mark.parametrize("mistake", mistakes, ids=[m.name for m in mistakes])


@pytest.fixture(scope="module")
def folder(build: Path) -> Path:
    """Where the build put the program and the folders of its headers."""
    return build / "tests" / "mistakes" / "cpp"


@pytest.fixture
def runtime() -> Iterator[Path]:
    """A runtime folder of the program's own, with a path short enough for a socket."""
    with tempfile.TemporaryDirectory(prefix="gecos-") as made:
        yield Path(made)


@each("cpp")
def test_a_mistake_of_a_running_program(mistake: Mistake, folder: Path, runtime: Path) -> None:
    """The message is what the program prints, else the last line on stderr."""
    environment = os.environ | {"GECOS_RUNTIME_DIR": str(runtime)}
    environment.pop("GECOS_BROKER", None)
    ended = subprocess.run(
        [folder / "cpp_mistakes", mistake.name],
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
    )
    told = ended.stdout or ended.stderr.strip().splitlines()[-1]
    assert settled(told, runtime) == mistake.says


@pytest.fixture(scope="module")
def compiled(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the compiler says of each mistake. All are compiled as one source, in namespaces of
    their own, because reading the headers takes most of the time."""
    here = tmp_path_factory.mktemp("compile")
    whole = '#include "bench.hpp"\n'
    mistakes = of_kind("compile")
    for i, mistake in enumerate(mistakes):
        (here / f"mistake_{i}.cpp").write_text(mistake.made_by)
        whole += f'namespace mistake_{i} {{\n#include "mistake_{i}.cpp"\n}}\n'
    (here / "whole.cpp").write_text(whole)
    compiler, *headers = (folder / "compiler.txt").read_text().splitlines()
    options = ["-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-fno-diagnostics-color"]
    ended = subprocess.run(
        [
            *(compiler, *options),
            *(f"-I{header}" for header in [TREE / "tests" / "mistakes" / "cpp", *headers]),
            here / "whole.cpp",
        ],
        env=os.environ | {"LC_ALL": "C"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    told = {mistake.name: "" for mistake in mistakes}
    name = ""
    for line in ended.stderr.splitlines():
        found = re.match(r"\S*/mistake_(\d+)\.cpp:\d+:\d+: (error|warning)", line)
        if found:
            name = mistakes[int(found[1])].name
        if name:
            told[name] += line + "\n"
    return told


@each("compile")
def test_a_mistake_that_the_compiler_sees(mistake: Mistake, compiled: dict[str, str]) -> None:
    expect_parts(mistake, compiled[mistake.name])


@each("cmake")
def test_a_mistake_in_a_cmake_file(mistake: Mistake, tmp_path: Path) -> None:
    uses_gidl = "gidl_generate" in mistake.made_by
    before = "find_package(robcl REQUIRED)" if uses_gidl else ""
    text = CMAKE_LISTS.format(tree=TREE, before=before, code=mistake.made_by)
    (tmp_path / "CMakeLists.txt").write_text(text)
    write_files(mistake, tmp_path)
    ended = subprocess.run(
        [
            *("cmake", "-S", tmp_path, "-B", tmp_path / "build", "-G", "Ninja"),
            *(f"-DPython_EXECUTABLE={sys.executable}", "-Wno-dev"),
        ],
        capture_output=True,
        text=True,
        timeout=100,
    )
    expect_parts(mistake, " ".join(settled(ended.stderr, tmp_path).split()))


def expect_parts(mistake: Mistake, told: str) -> None:
    """Each line of `says` stands in what was told, in this order."""
    rest = told
    for line in mistake.says.splitlines():
        assert line in rest, f"{mistake.table}.toml, {mistake.name}: {line!r} is not in\n{told}"
        rest = rest.partition(line)[2]
