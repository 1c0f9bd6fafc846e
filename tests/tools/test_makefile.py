"""What the targets of the Makefile build, and the presets of CMake that they use."""

import json
import re
import runpy
import subprocess
from pathlib import Path, PurePath

import pytest

TREE = Path(__file__).resolve().parents[2]


def would_run(target: str) -> str:
    done = subprocess.run(
        ["make", "--dry-run", target], cwd=TREE, capture_output=True, text=True, check=True
    )
    return done.stdout


def test_the_demo_builds_what_it_runs_and_nothing_else() -> None:
    built = re.search(r"cmake --build build .*--target (.+)", would_run("demo"))
    assert built
    demo = runpy.run_path(str(TREE / "examples/demo.py"), run_name="demo")
    programs = {PurePath(path).name for path in (*demo["SERVERS"], demo["PROGRAM"])}
    assert set(built[1].split()) == programs | {"runtime/python/all"}


@pytest.mark.parametrize(
    ("target", "preset"), [("build-tests", "dev"), ("test-asan", "asan"), ("test-tsan", "tsan")]
)
def test_a_target_and_its_preset_configure_one_folder_alike(target: str, preset: str) -> None:
    configured = re.search(r"tools/configure.sh (\S+) (\S+) (.+)", would_run(target))
    assert configured
    presets = {
        p["name"]: p
        for p in json.loads((TREE / "CMakePresets.json").read_text())["configurePresets"]
    }
    assert configured[3].split() == [f"--preset={preset}"]
    assert presets[preset]["binaryDir"] == f"${{sourceDir}}/{configured[1]}"
    assert presets["base"]["cacheVariables"]["CMAKE_BUILD_TYPE"] == configured[2]


def test_cmake_reads_the_presets() -> None:
    done = subprocess.run(
        ["cmake", "--list-presets"], cwd=TREE, capture_output=True, text=True, check=True
    )
    assert re.findall(r'"(\w+)"', done.stdout) == ["dev", "release", "asan", "tsan", "clang"]
