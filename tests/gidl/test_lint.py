"""Each rule of `gidl lint` has a folder: good.gidl, bad.gidl, and what is said about the bad one.

After a deliberate change of a text: `GIDL_WRITE_GOLDENS=1 pytest tests/gidl/test_lint.py`, then
read the difference.
"""

import os
import re
from pathlib import Path

import pytest
from gidl import lint
from gidl.cli.main import main

HERE = Path(__file__).parent
IDL = HERE.parents[1] / "idl"
RULES = sorted(p for p in (HERE / "lint").iterdir() if p.is_dir())


def linted(file: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    status = main(["lint", "-I", str(IDL), file])
    out, err = capsys.readouterr()
    assert out == ""
    return status, err.rpartition("gidl: ")[0]


def test_every_rule_has_a_folder() -> None:
    assert {rule.__module__.rpartition(".")[2] for rule in lint.ALL} == {p.name for p in RULES}


@pytest.mark.parametrize("rule", RULES, ids=lambda p: p.name)
def test_good_file_passes_every_rule(
    rule: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(rule)
    assert linted("good.gidl", capsys) == (0, "")


@pytest.mark.parametrize("rule", RULES, ids=lambda p: p.name)
def test_bad_file_is_reported_as_in_its_golden_and_by_no_other_rule(
    rule: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(rule)
    status, said = linted("bad.gidl", capsys)
    golden = rule / "bad.txt"
    if os.environ.get("GIDL_WRITE_GOLDENS"):
        golden.write_text(said, encoding="utf-8")
    assert said == golden.read_text(encoding="utf-8")
    source = (Path(lint.__file__).parent / f"{rule.name}.py").read_text(encoding="utf-8")
    assert set(re.findall(r"\[(G\d{4})\]", said)) == set(re.findall(r'"(G\d{4})"', source))
    assert status == 100


def test_an_excepted_rule_is_not_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(HERE / "lint" / "version_missing")
    assert main(["lint", "--except", "G0908", "bad.gidl"]) == 0
    assert main(["lint", "--except", "g0907", "bad.gidl"]) == 100
    assert main(["lint", "--except", "G0102", "bad.gidl"]) == 2
    assert "there is no lint rule with the code G0102" in capsys.readouterr().err


def test_files_with_errors_show_those_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wrong.gidl").write_text("struct S { Missing x; double width; };\n")
    status, said = linted("wrong.gidl", capsys)
    assert status == 100
    assert re.findall(r"\[(G\d{4})\]", said) == ["G0102"]


def test_included_files_are_not_spoken_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.gidl").write_text("struct S { double width; };\n")
    Path("good.gidl").write_text('#include "bad.gidl"\n@final struct T { S inside; };\n')
    assert linted("good.gidl", capsys) == (0, "")


def test_the_interfaces_of_the_tree_are_clean(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(IDL.parent)
    assert main(["lint"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(r"gidl: no lint findings in \d+ files\n", err)
