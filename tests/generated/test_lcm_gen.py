"""lcm-gen's own code for the generated .lcm files, on the shared vectors: same fingerprints, same
bytes, same values, in Python and in C++."""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import pytest
from generating import generate
from gidl.model import Model
from gidl.wire import wire_layout
from gidl.wire.wire_layout import Layout
from type_values import TREE, Case, cases, python_type

CASES = cases()


def wheel() -> Path:
    """The folder that the wheel `lcm` lies in: lcm-gen, headers and all."""
    return Path(str(distribution("lcm").locate_file("")))


def lcm_gen() -> str:
    found = wheel() / "bin" / "lcm-gen"
    return str(found) if found.exists() else str(shutil.which("lcm-gen"))


@pytest.fixture(scope="session")
def layout(model: Model) -> Layout:
    return wire_layout.build(model)


@pytest.fixture(scope="session")
def lcm_files(everything: Path) -> list[str]:
    folders = (TREE / "generated" / "lcm", everything / "lcm")
    found = {p.relative_to(each): str(p) for each in folders for p in sorted(each.rglob("*.lcm"))}
    return list(found.values())  # each once: whatever passes objects brings gecos/object_ref.lcm


def full_name(layout: Layout, case: Case) -> str:
    known: Any = layout.structs.get(case.type) or layout.unions[case.type]
    return str(known.lcm.name)


def message(layout: Layout, case: Case) -> bytes:
    known: Any = layout.structs.get(case.type) or layout.unions[case.type]
    return struct.pack(">q", known.fingerprint) + case.bytes


def test_fingerprints_of_our_code_are_those_of_the_layout(
    model: Model, layout: Layout, everything: Path
) -> None:
    for case in CASES:
        ours = python_type(model, case.type).fingerprint() & 0xFFFF_FFFF_FFFF_FFFF
        assert ours.to_bytes(8, "big") == message(layout, case)[:8], case.type


@pytest.fixture(scope="session")
def answers(
    layout: Layout, lcm_files: list[str], tmp_path_factory: pytest.TempPathFactory
) -> list[dict[str, Any]]:
    """What lcm-gen's Python says to each case."""
    out = tmp_path_factory.mktemp("lcm_python")
    subprocess.run([lcm_gen(), "-p", "--ppath", str(out), *lcm_files], check=True)
    asked = [(full_name(layout, case), message(layout, case).hex()) for case in CASES]
    peer = Path(__file__).with_name("lcm_peer.py")
    answer = subprocess.run(
        [sys.executable, "-I", "-c", _PEER, str(out), str(peer)],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 0, answer.stderr
    found: list[dict[str, Any]] = json.loads(answer.stdout)
    return found


# Isolated from our path: lcm-gen's package `gecos` has the name of the runtime.
_PEER = "import runpy, sys; sys.path.insert(0, sys.argv[1]); runpy.run_path(sys.argv[2])"


@pytest.mark.parametrize("index", range(len(CASES)), ids=lambda i: CASES[i].id)
def test_lcm_gens_python_agrees(index: int, layout: Layout, answers: list[dict[str, Any]]) -> None:
    case, answer = CASES[index], answers[index]
    assert answer["fingerprint"] == message(layout, case)[:8].hex()
    assert answer["message"] == message(layout, case).hex()
    _expect_members(case, answer["members"])


def _expect_members(case: Case, members: dict[str, Any]) -> None:
    """Members that are lowered to themselves have the value that was meant."""
    assert isinstance(case.value, dict)
    for name, meant in case.value.items():
        got = members.get(name)
        if isinstance(meant, float) and isinstance(got, float):
            assert got == meant, name
        if isinstance(meant, str) and isinstance(got, str):
            assert got == meant, name
        if type(meant) is int and type(got) is int and meant < 2**7:
            assert got == meant, name
        wrapped = isinstance(got, list) and got and isinstance(got[0], dict)
        if isinstance(meant, list) and isinstance(got, list) and not wrapped:
            assert len(got) == len(meant), name


def test_lcm_gens_cpp_agrees(layout: Layout, lcm_files: list[str], tmp_path: Path) -> None:
    subprocess.run([lcm_gen(), "-x", "--cpp-hpath", str(tmp_path), *lcm_files], check=True)
    names = sorted({full_name(layout, case) for case in CASES})
    lines = [f'#include "{name.replace(".", "/")}.hpp"' for name in names]
    checks = [
        f'  check<{full_name(layout, case).replace(".", "::")}>("{case.type}", '
        f'"{message(layout, case).hex()}");'
        for case in CASES
    ]
    source = tmp_path / "main.cpp"
    main = "\n".join(["int main() {", *checks, "  return failures;", "}"])
    source.write_text("\n".join([*lines, _CHECK, main]), encoding="utf-8")
    program = tmp_path / "peer"
    compiler = os.environ.get("CXX", "c++")
    include = wheel() / "include"
    subprocess.run(
        [compiler, "-std=c++17", f"-I{tmp_path}", f"-I{include}", str(source), "-o", str(program)],
        check=True,
    )
    done = subprocess.run([str(program)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert done.stdout.count("same") == len(CASES)


_CHECK = r"""
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

static int failures = 0;

template <class T>
void check(const char* name, const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  T value;
  const int read = value.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
  std::vector<std::uint8_t> again(static_cast<std::size_t>(value.getEncodedSize()));
  value.encode(again.data(), 0, static_cast<int>(again.size()));
  const bool same = read == static_cast<int>(bytes.size()) && again == bytes;
  std::printf("%s %s\n", same ? "same" : "DIFFERS", name);
  failures += same ? 0 : 1;
}
"""


# Enumerators and flags that are words of C++ or Python, macros, or what lcm-gen declares itself.
WORDS = """
module words {
  enum Grip { None, None_, soft };
  enum Mode { auto, manual, NULL, getHash, @value(9) get_hash };
  @bit_bound(40) bitmask Rights { class, _import, @position(35) staticmethod };
  interface Arm { enum Side { Arm_Side, lambda }; };
  struct Hand { Grip held; Mode way; Rights allowed; Arm::Side which; };
};
"""
# What they are called in .lcm, and their values.
CONSTANTS = {
    "Grip": {"None_": 0, "None__": 1, "soft": 2},
    "Mode": {"auto_": 0, "manual": 1, "NULL_": 2, "getHash_": 3, "get_hash_": 9},
    "Rights": {"class_": 1, "import_": 2, "staticmethod_": 2**35},
    "Arm_Side": {"Arm_Side_": 0, "lambda_": 1},
}


@pytest.fixture
def words(tmp_path: Path) -> str:
    """The .lcm file of those enumerators."""
    (tmp_path / "words.gidl").write_text(WORDS)
    generate(tmp_path, "--lang", "lcm", tmp_path / "words.gidl")
    return str(tmp_path / "lcm" / "words.lcm")


def test_python_of_lcm_gen_has_enumerators_that_are_words(words: str, tmp_path: Path) -> None:
    subprocess.run([lcm_gen(), "-p", "--ppath", str(tmp_path), words], check=True)
    checks = [
        f"assert words.{kind}.{name} == {value}"
        for kind, constants in CONSTANTS.items()
        for name, value in constants.items()
    ]
    # get_hash() fails if a constant has taken its place.
    checks.append("words.Hand.decode(words.Hand().encode()).get_hash()")
    program = "\n".join(
        [f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import words", *checks]
    )
    subprocess.run([sys.executable, "-I", "-c", program], check=True)


def test_cpp_of_lcm_gen_has_enumerators_that_are_words(words: str, tmp_path: Path) -> None:
    subprocess.run([lcm_gen(), "-x", "--cpp-hpath", str(tmp_path), words], check=True)
    source = tmp_path / "words.cpp"
    lines = [f'#include "words/{kind}.hpp"' for kind in ("Hand", *CONSTANTS)]
    lines += [
        f"static_assert(words::{kind}::{name} == {value});"
        for kind, constants in CONSTANTS.items()
        for name, value in constants.items()
    ]
    source.write_text("\n".join(["#include <cstddef>", *lines, ""]), encoding="utf-8")
    compiler = os.environ.get("CXX", "c++")
    include = [f"-I{tmp_path}", f"-I{wheel() / 'include'}"]
    subprocess.run([compiler, "-std=c++17", "-fsyntax-only", *include, str(source)], check=True)
