"""The encoding on a big-endian machine: the tests that read tests/vectors, compiled for s390x and
run under qemu. Bytes on the wire do not depend on the host."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
COMPILER = "s390x-linux-gnu-g++"
EMULATOR = "qemu-s390x"
GOOGLETEST = Path("/usr/src/googletest/googletest")
EIGEN = Path("/usr/include/eigen3")


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(TREE / "codegen")}


def product(folder: Path) -> list[Path]:
    """What is on trial: the wire, frames, and generated types; and GoogleTest, so that both parts
    take about as long to compile."""
    cpp = TREE / "runtime" / "cpp"
    return [
        *(GOOGLETEST / "src" / name for name in ("gtest-all.cc", "gtest_main.cc")),
        *sorted((cpp / "gecos" / "wire").glob("*.cpp")),
        *sorted((cpp / "robcl" / "frames").glob("*.cpp")),
        *sorted((TREE / "generated" / "cpp").glob("*/*_types.cpp")),
        *sorted((folder / "cpp").glob("*_types.cpp")),
    ]


def trial(folder: Path) -> list[Path]:
    """types.json, frames.json, decoder.json and packet.json, by the tests that every host runs."""
    tests = TREE / "tests" / "cpp"
    return [
        folder / "cases.cpp",
        tests / "generated" / "vectors_test.cpp",
        *(tests / "wire" / f"{name}.cpp"
          for name in ("json", "frame_vectors_test", "packet_test", "vectors_test")),
    ]  # fmt: skip


def compiled(folder: Path, name: str, sources: list[Path]) -> str:
    """All in one translation unit: most of the time would go into the same headers again. Paths
    below `folder` are relative, so that ccache knows them in the next run."""
    lines = [
        f'#include "{path.relative_to(folder) if path.is_relative_to(folder) else path}"\n'
        for path in sources
    ]
    (folder / f"{name}.cpp").write_text("".join(lines), encoding="utf-8")
    include = [
        "-I.", "-Icpp", f"-I{TREE / 'runtime' / 'cpp'}", f"-I{TREE / 'generated' / 'cpp'}",
        f"-I{TREE / 'tests' / 'cpp' / 'wire'}", f"-I{TREE / 'tests' / 'cpp' / 'generated'}",
        f"-I{GOOGLETEST}", f"-I{GOOGLETEST / 'include'}", "-isystem", "portable",
    ]  # fmt: skip
    vectors = f'-DGECOS_VECTORS="{TREE / "tests" / "vectors"}"'
    launcher = ["ccache"] if shutil.which("ccache") else []
    command = [*launcher, COMPILER, "-std=c++20", "-O0", *include, vectors]
    done = subprocess.run(
        [*command, "-c", f"{name}.cpp", "-o", f"{name}.o"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return f"{name}.o"


def test_all_that_is_needed_is_installed() -> None:
    """`make setup` installs it; nothing here is skipped where it is missing."""
    for program in (COMPILER, EMULATOR):
        assert shutil.which(program), f"{program} is missing: run `make setup`"
    for folder in (GOOGLETEST, EIGEN):
        assert folder.is_dir(), f"{folder} is missing: run `make setup`"


@pytest.mark.timeout(600)
def test_a_big_endian_machine_reads_and_writes_the_same_bytes(tmp_path: Path) -> None:
    everything = TREE / "tests" / "idl" / "everything.gidl"
    search = ["-I", str(TREE / "idl"), "-I", str(everything.parent), "--out", str(tmp_path)]
    for command in (
        ["-m", "gidl", "gen", "--lang", "cpp", *search, str(everything)],
        [str(TREE / "tests" / "generated" / "write_cpp_cases.py"), str(tmp_path / "cases.cpp")],
    ):
        subprocess.run([sys.executable, *command], check=True, env=environment())
    # Headers that are the same on every machine; the rest of /usr/include belongs to this one.
    portable = tmp_path / "portable"
    portable.mkdir()
    (portable / "tl").symlink_to("/usr/include/tl")
    (portable / "Eigen").symlink_to(EIGEN / "Eigen")

    with ThreadPoolExecutor(2) as pool:
        parts = [
            pool.submit(compiled, tmp_path, "product", product(tmp_path)),
            pool.submit(compiled, tmp_path, "trial", trial(tmp_path)),
        ]
        objects = [part.result() for part in parts]
    subprocess.run([COMPILER, "-static", *objects, "-o", "trial"], cwd=tmp_path, check=True)
    done = subprocess.run([EMULATOR, str(tmp_path / "trial")], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    passed = re.search(r"\[  PASSED  \] (\d+) tests", done.stdout)
    assert passed and int(passed.group(1)) > 10, done.stdout
