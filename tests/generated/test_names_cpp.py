"""No name of an interface breaks generated C++: whatever its bodies call their parameters, locals
and members may be what a type, parameter or member is called. As clang sees it."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from generating import TREE, generate
from gidl.keywords import CPP
from gidl.languages import CPP_TYPES
from names_in_use import members_file, types_file

WORDS = CPP_TYPES.type_words
NAMES = sorted(word for word in WORDS - CPP if word.islower() or word.lower() not in WORDS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The generated C++ of interfaces that have all those names."""
    out = tmp_path_factory.mktemp("names")
    (out / "members.gidl").write_text(members_file("members", NAMES))
    (out / "types.gidl").write_text(types_file("types", NAMES))
    generate(out, "--lang", "cpp", out / "members.gidl", out / "types.gidl")
    return out / "cpp"


def test_the_names_are_all_that_bodies_of_types_declare() -> None:
    """A local that a template gets tomorrow has to be among them."""
    qualifier = r"(?:const |static |constexpr )*"
    local = re.compile(rf"^ +(?! |return\b){qualifier}[\w:<>, ]+[*&]* ([a-z]+)_?(?:\{{| = |;)")
    found = set()
    for source in (TREE / "generated" / "cpp").rglob("*_types.cpp"):
        found |= {m[1] for line in source.read_text().splitlines() if (m := local.match(line))}
    assert {"number", "size"} <= found <= set(NAMES)


@pytest.mark.parametrize("part", ["members", "types"])
def test_types_and_members_of_these_names_compile(folder: Path, part: str) -> None:
    every = folder / f"all_of_{part}.cpp"
    sources = sorted(folder.glob(f"{part}_*.cpp"))
    assert len(sources) == 4
    every.write_text("".join(f'#include "{source.name}"\n' for source in sources))
    include = [f"-I{f}" for f in (folder, TREE / "generated" / "cpp", TREE / "runtime" / "cpp")]
    clang = [TREE / "tools/clang.sh", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra"]
    run = subprocess.run(
        [*clang, *include, every],
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr[:4000]
