"""Every code has a page, a file that causes it, and no page is about a code that is gone."""

import re
from pathlib import Path

import gidl
import pytest
from gidl.cli.explain import all_titles, page
from gidl.cli.main import main

PACKAGE = Path(gidl.__file__).parent
HERE = Path(__file__).parent

# Caused by what a file is, by generating from it or by laying it out: see test_cli.py, test_fmt.py,
# test_breaking.py, test_encodings.py, test_omniidl.py, test_generated_files.py,
# test_file_names.py, test_type_names.py, test_no_effect.py, test_project.py.
ELSEWHERE = {"G0001", "G0002", "G0011", "G0014", "G0706", "G0708", "G0801", "G0802", "G1008"}
ELSEWHERE |= {
    "G0114",
    "G0021",
    "G0022",
    "G0023",
    "G0024",
    "G0025",
    "G0026",
    "G1401",
    "G1402",
    "G1403",
    "G1404",
    "G1405",
}


def codes_in_source() -> set[str]:
    texts = (p.read_text(encoding="utf-8") for p in PACKAGE.rglob("*.py"))
    return {code for text in texts for code in re.findall(r'"(G\d{4})"', text)}


def test_every_code_has_a_page_and_every_page_a_code() -> None:
    assert {code for code, _ in all_titles()} == codes_in_source()


def test_every_code_is_caused_by_a_bad_file() -> None:
    goldens = (p for folder in ("bad", "lint", "breaking") for p in (HERE / folder).rglob("*.txt"))
    said = "".join(p.read_text(encoding="utf-8") for p in goldens)
    assert codes_in_source() - set(re.findall(r"\[(G\d{4})\]", said)) == ELSEWHERE


def test_a_page_is_printed_for_any_spelling(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "g102"]) == 0
    assert capsys.readouterr().out.startswith("G0102: a type is not known\n")
    assert page("G9999") is None


def test_an_unknown_code_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "G0999"]) == 2
    assert "there is no code G0999" in capsys.readouterr().err


def test_all_codes_are_listed_without_an_argument(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain"]) == 0
    assert "G0314  a type contains itself" in capsys.readouterr().out
