"""The examples of docs/gidl.md: interfaces compile, code compiles, commands run."""

import re
import shlex
import shutil
import sys
from pathlib import Path
from textwrap import indent

import pytest
from blocks import TREE, blocks, check_python, compile_cpp, run

REFERENCE = "docs/gidl.md"
IDL = TREE / "idl"
TO_COME = {"mutable"}  # refused by the compiler, and said to be

CPP_BEFORE = """\
#include "gecos/gecos.hpp"
#include "workshop_client.hpp"

void piece(gecos::Lab& lab, const workshop::Changer& changer) {
"""

PYTHON_BEFORE = """\
import gecos
from workshop import Changer, Tool

def piece(lab: gecos.Lab, changer: Changer) -> None:
"""


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What gidl makes of the interface that the pieces of code use."""
    out = tmp_path_factory.mktemp("workshop")
    root = TREE / "tests" / "idl" / "workshop"
    gidl("gen", "-I", root, "--out", out, root / "workshop.gidl")
    return out


def gidl(*words: object) -> None:
    run(sys.executable, "-m", "gidl", *words)


def interfaces(folder: Path) -> list[Path]:
    """Each interface of the page as a file."""
    files = []
    for at, block in enumerate(blocks(REFERENCE, "idl")):
        files.append(folder / f"example_{at}.gidl")
        files[-1].write_text(block)
    return files


def test_the_interfaces_are_right_and_laid_out(tmp_path: Path) -> None:
    for file in interfaces(tmp_path):
        gidl("lint", "-I", IDL, file)
        gidl("fmt", "--check", file)


def test_they_are_generated(tmp_path: Path) -> None:
    stage, mapped = interfaces(tmp_path)
    gidl("gen", "-I", IDL, "-I", tmp_path, "--out", tmp_path / "out", stage, mapped)
    including = '#include "example_0_client.hpp"\n#include "example_0_server.hpp"\n'
    compile_cpp(f'{including}#include "example_1_types.hpp"\n', tmp_path / "out", tmp_path)
    check_python("from example_0 import Stage, StageServant\n", tmp_path / "out", tmp_path)


def test_every_annotation_stands_in_an_example() -> None:
    vocabulary = (TREE / "codegen/gidl/include/gecos/annotations.gidl").read_text()
    declared = set(re.findall(r"^@annotation (\w+)", vocabulary, re.MULTILINE))
    used = set(re.findall(r"@(\w+)", "".join(blocks(REFERENCE, "idl"))))
    assert declared - used == TO_COME


def test_the_cpp_compiles(workshop: Path, tmp_path: Path) -> None:
    pieces = "".join(blocks(REFERENCE, "cpp"))
    compile_cpp(CPP_BEFORE + pieces + "  (void)screwdriver;\n}\n", workshop, tmp_path)


def test_the_python_is_well_typed(workshop: Path, tmp_path: Path) -> None:
    pieces = "".join(indent(block, "    ") for block in blocks(REFERENCE, "py"))
    check_python(PYTHON_BEFORE + pieces, workshop, tmp_path)


def commands() -> list[str]:
    """What the page says to type, of gidl; comments are left out."""
    lines = [line for block in blocks(REFERENCE, "sh") for line in block.splitlines()]
    return [re.sub(r"\s+#\s.*", "", line) for line in lines if line.startswith("gidl ")]


def test_every_command_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a tree with interfaces, in which nothing was changed since the last commit."""
    shutil.copytree(IDL, tmp_path / "idl")
    plain = '/** A. */ @version("1.0") interface A { @sensor readonly attribute long count; };\n'
    (tmp_path / "a.gidl").write_text(plain)  # CORBA can express it
    monkeypatch.chdir(tmp_path)
    for words in ("init -q -b main", "add .", "-c user.name=a -c user.email=a@b commit -qm all"):
        run("git", *words.split())
    asked = commands()
    assert len(asked) >= 12
    for command in asked:
        verb, *words = shlex.split(command)[1:]
        included = verb in ("gen", "check", "lint", "dump") or "--mock" in words
        gidl(verb, *words, *(("-I", "idl") if included else ()))
