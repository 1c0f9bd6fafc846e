"""omniidl, a CORBA compiler of its own, agrees with ours about plain CORBA IDL.

Where the two differ, docs/gidl-differences.md says which paragraph of OMG IDL 4.2 settles it; the
tables there are read here, so that neither a new difference nor a gone one stays unsaid.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from gidl.compile import compile_files
from gidl.diagnostics.findings import Findings
from gidl.omg import omg_text

HERE = Path(__file__).parent
TREE = HERE.parents[1]
OMNIIDL = shutil.which("omniidl")
NOT_CORBA = re.compile(r"@|\bmap<|\bbitmask\b|\bbitset\b|\bu?int(8|16|32|64)\b|^#pragma once", re.M)
GOOD = [*sorted((HERE / "good").glob("*.gidl")), *sorted((HERE / "preprocessor").glob("*.gidl"))]
INTERFACES = sorted((TREE / "idl" / "robcl").glob("*.gidl"))
DOCUMENT = (TREE / "docs" / "gidl-differences.md").read_text(encoding="utf-8")

pytestmark = pytest.mark.skipif(OMNIIDL is None, reason="needs omniidl (make setup installs it)")


def table(title: str) -> set[str]:
    """First column of the table under a heading of the document."""
    section = DOCUMENT.split(f"## {title}\n")[1].split("\n## ")[0]
    return set(re.findall(r"^\| `([a-z_0-9]+)` \|", section, re.M))


ONLY_WE_ACCEPT = table("What we accept and omniidl does not")
ONLY_OMNIIDL_ACCEPTS = table("What omniidl accepts and we do not")


def plain(files: list[Path]) -> list[Path]:
    return [f for f in files if not NOT_CORBA.search(f.read_text(encoding="utf-8"))]


def omniidl(file: Path) -> tuple[bool, str]:
    """Whether it takes the file, and what it says."""
    assert OMNIIDL is not None
    run = subprocess.run(
        [OMNIIDL, "-bdump", file.name], cwd=file.parent, capture_output=True, check=False
    )
    return run.returncode == 0, run.stderr.decode("utf-8", "replace")


@pytest.mark.parametrize("file", [*GOOD, *INTERFACES], ids=lambda p: p.stem)
def test_what_we_dump_is_taken(file: Path, tmp_path: Path) -> None:
    compiled = compile_files([str(file)], [str(TREE / "idl"), str(file.parent)])
    assert not compiled.has_errors
    findings = Findings()
    text = omg_text(compiled.model, "corba", True, findings)
    if findings.found:
        assert all("CORBA cannot express" in f.message for f in findings.found)
        assert all(f.location is not None for f in findings.found)
        return
    dumped = tmp_path / "dumped.idl"
    dumped.write_text(text, encoding="utf-8")
    taken, said = omniidl(dumped)
    assert taken, f"{said}\n{text}"


def test_most_of_what_is_plain_is_dumped() -> None:
    dumped = 0
    for file in plain(GOOD):
        compiled = compile_files([str(file)], [str(TREE / "idl"), str(file.parent)])
        findings = Findings()
        omg_text(compiled.model, "corba", True, findings)
        dumped += not findings.found
    assert dumped >= 25


@pytest.mark.parametrize("file", plain(sorted((HERE / "bad").glob("*.gidl"))), ids=lambda p: p.stem)
def test_what_is_wrong_is_wrong_for_both(file: Path) -> None:
    taken, said = omniidl(file)
    assert taken == (file.stem in ONLY_OMNIIDL_ACCEPTS), said


@pytest.mark.parametrize("file", plain(GOOD), ids=lambda p: p.stem)
def test_what_is_right_is_right_for_both(file: Path) -> None:
    taken, said = omniidl(file)
    assert taken == (file.stem not in ONLY_WE_ACCEPT), said


def test_the_tables_name_files_of_the_corpus() -> None:
    assert {f.stem for f in plain(GOOD)} >= ONLY_WE_ACCEPT
    assert {f.stem for f in plain(sorted((HERE / "bad").glob("*.gidl")))} >= ONLY_OMNIIDL_ACCEPTS
