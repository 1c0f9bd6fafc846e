"""good/*.gidl and preprocessor/*.gidl are accepted without a word; beside each bad/*.gidl stands
what must be said about it.

After a deliberate change of a text: `GIDL_WRITE_GOLDENS=1 pytest tests/gidl/test_corpus.py`, then
read the difference.
"""

import os
from pathlib import Path

import pytest
from gidl.compile import Compiled, compile_files
from gidl.diagnostics.findings import as_text

HERE = Path(__file__).parent
GOOD = [
    *sorted((HERE / "good").glob("*.gidl")),
    *sorted((HERE / "preprocessor").glob("*.gidl")),  # conditions, macros, guards, circles
]
BAD = sorted((HERE / "bad").glob("*.gidl"))
IDL = HERE.parents[1] / "idl"


def findings_text(compiled: Compiled) -> str:
    return as_text(list(compiled.findings), compiled.sources)


@pytest.mark.parametrize("file", BAD, ids=lambda p: p.stem)
def test_bad_file_is_reported_as_in_its_golden(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(file.parent)
    golden = file.with_suffix(".txt")
    said = findings_text(compile_files([file.name]))
    if os.environ.get("GIDL_WRITE_GOLDENS"):
        golden.write_text(said, encoding="utf-8")
    assert said == golden.read_text(encoding="utf-8")
    assert said


def test_the_corpus_is_large_enough_to_mean_something() -> None:
    assert len(GOOD) >= 60
    assert len(BAD) >= 120


def test_every_golden_has_its_file() -> None:
    assert {p.stem for p in (HERE / "bad").glob("*.txt")} == {p.stem for p in BAD}


@pytest.mark.parametrize("file", GOOD, ids=lambda p: p.stem)
def test_good_file_is_accepted_without_a_word(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(file.parent)
    assert findings_text(compile_files([file.name], [str(IDL), "."])) == ""


def test_the_interfaces_of_the_tree_are_accepted_without_a_word() -> None:
    files = sorted(str(p) for p in IDL.rglob("*.gidl"))
    assert len(files) >= 11
    assert findings_text(compile_files(files, [str(IDL)])) == ""


def test_one_run_shows_the_errors_of_every_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE / "bad")
    compiled = compile_files(["oneway.gidl", "maps.gidl"])
    assert {f.location.file for f in compiled.findings if f.location} == {
        "oneway.gidl",
        "maps.gidl",
    }
