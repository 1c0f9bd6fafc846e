"""Findings for other tools, and the depfile for builds."""

import json
from pathlib import Path

import gidl.cli.depfile
import pytest
from gidl.cli.main import main

WRONG = "module lab {\n  struct S { Missing x; };\n  struct S { long y; };\n};\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wr ong.gidl").write_text(WRONG)
    return tmp_path


def test_sarif_names_places_rules_and_second_places(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "--error-format", "sarif", "wr ong.gidl", "missing.gidl"]) == 100
    out, err = capsys.readouterr()
    assert err == ""
    report = json.loads(out)
    assert report["version"] == "2.1.0"
    (run,) = report["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert {"id": "G0102", "shortDescription": {"text": "a type is not known"}} in rules
    results = {result["ruleId"]: result for result in run["results"]}
    assert set(results) == {"G0001", "G0101", "G0102"}
    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert result["level"] == "error"
    place = results["G0102"]["locations"][0]["physicalLocation"]
    assert place == {
        "artifactLocation": {"uri": "wr%20ong.gidl"},
        "region": {"startLine": 2, "startColumn": 14, "endColumn": 21},
    }
    (second,) = results["G0101"]["relatedLocations"]
    assert second["physicalLocation"]["region"]["startLine"] == 2
    assert results["G0001"]["locations"][0]["physicalLocation"] == {
        "artifactLocation": {"uri": "missing.gidl"}
    }


def test_sarif_without_findings_is_a_whole_report(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "good.gidl").write_text("@final struct S { long x; };\n")
    for verb in (["check"], ["lint"], ["breaking", "--against", "."]):
        (here / "wr ong.gidl").write_text("@final struct T { long x; };\n")
        assert main([*verb, "--error-format", "sarif", "good.gidl", "wr ong.gidl"]) == 0
        assert json.loads(capsys.readouterr().out)["runs"][0]["results"] == []


def test_github_gets_one_command_per_finding(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("a,b.gidl").write_text(
        "struct S { Frma x; double port; };\n@final struct Frame { long x; };\n"
    )
    assert main(["check", "--error-format", "github-actions", "a,b.gidl"]) == 100
    out, err = capsys.readouterr()
    assert err == ""
    assert out == (
        "::error file=a%2Cb.gidl,line=1,col=12,title=gidl G0102::unknown type 'Frma'\n"
        "::warning file=a%2Cb.gidl,line=1,col=27,title=gidl G0702::'port' is a keyword of a part "
        "of IDL that .gidl does not use%0Ahelp: write '_port' for other IDL compilers: the name "
        "remains 'port'\n"
    )


def test_the_depfile_names_all_that_was_read(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "idl").mkdir()
    (here / "idl" / "base.gidl").write_text("@final struct B { long x; };\n")
    (here / "idl" / "top.gidl").write_text('#include "base.gidl"\n@final struct T { B inside; };\n')
    command = ["gen", "--lang", "lcm", "--depfile", "out/gidl.d", "idl/top.gidl"]
    assert main(command) == 0
    rule = (here / "out" / "gidl.d").read_text().replace("\\\n", " ")
    made, _, needs = rule.partition(": ")
    assert made.split() == ["generated/lcm/top.lcm"]
    assert {"idl/base.gidl", "idl/top.gidl"} <= set(needs.split())
    assert {Path(gidl.cli.depfile.__file__).as_posix()} <= set(needs.split()), (
        "a newer gidl writes anew"
    )
    assert all(Path(name).is_file() for name in needs.split())
