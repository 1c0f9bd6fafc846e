"""What the command prints, and its exit status."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from gidl.cli.main import main

TREE = Path(__file__).resolve().parents[2]
GOOD = "module lab { @appendable struct S { double x; }; interface I { @sensor S look(); }; };\n"
WRONG = "module lab { struct S { Missing x; }; };\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "idl").mkdir()
    (tmp_path / "idl" / "good.gidl").write_text(GOOD)
    return tmp_path


def test_check_of_a_right_file_is_silent(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "idl/good.gidl"]) == 0
    assert capsys.readouterr() == ("", "")


def test_findings_go_to_stderr_and_exit_with_100(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "wrong.gidl").write_text(WRONG)
    assert main(["check", "wrong.gidl"]) == 100
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("wrong.gidl:1:25: error[G0102]: unknown type 'Missing'\n")
    assert err.endswith("gidl: 1 error, 0 warnings\n")


def test_warnings_alone_are_fine(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "w.gidl").write_text("struct S { double port; };\n")
    assert main(["check", "w.gidl"]) == 0
    assert "warning[G0702]" in capsys.readouterr().err


def test_json_findings_go_to_stdout(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "wrong.gidl").write_text(WRONG)
    assert main(["check", "--error-format", "json", "wrong.gidl"]) == 100
    (finding,) = json.loads(capsys.readouterr().out)
    assert finding["code"] == "G0102"
    assert (finding["file"], finding["line"], finding["column"]) == ("wrong.gidl", 1, 25)


def test_stdin_is_read_for_a_dash(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(WRONG.encode())))
    assert main(["check", "-"]) == 100
    assert capsys.readouterr().err.startswith("-:1:25: error[G0102]")


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (lambda p: None, "G0001"),
        (lambda p: p.mkdir(), "G0001"),
        (os.mkfifo, "G0001"),
        (lambda p: p.write_bytes(b"struct \0"), "G0002"),
        (lambda p: p.write_bytes(b" " * (5 << 20)), "G0011"),
    ],
    ids=["missing", "folder", "pipe", "NUL", "too large"],
)
def test_a_file_that_cannot_be_read_is_a_finding(
    here: Path, make: object, code: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert callable(make)
    make(here / "odd.gidl")
    assert main(["check", "odd.gidl"]) == 100
    assert f"odd.gidl: error[{code}]" in capsys.readouterr().err


def test_pragmas_are_warned_about_once_a_run(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "a.gidl").write_text(
        '#pragma prefix "a"\n#pragma ID A "IDL:A:1.0"\nstruct A { long x; };'
    )
    (here / "b.gidl").write_text('#include "a.gidl"\n#pragma other\nstruct B { A one; };\n')
    assert main(["check", "a.gidl", "b.gidl"]) == 0
    said = capsys.readouterr().err
    assert said.count("G0701") == 1 and "a.gidl:1:1: warning[G0701]" in said


def test_a_header_of_c_is_one_finding_however_many_files_include_it(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "inner.idl").write_text("struct Inner { long x; };\n")
    (here / "c.h").write_text('#include "inner.idl"\ntypedef struct { int x; } c_type;\n')
    (here / "a.gidl").write_text('#include "c.h"\nstruct A { c_type x; };\n')
    (here / "b.gidl").write_text(
        '#include "c.h"\n#include "inner.idl"\nstruct B { c_type x; Inner part; };\n'
    )
    assert main(["check", "a.gidl", "b.gidl"]) == 100
    said = capsys.readouterr().err
    assert "a.gidl:1:1: error[G0216]" in said and "gidl: 1 error, 0 warnings" in said


@pytest.mark.parametrize(
    ("command", "status", "told"),
    [
        ("check - <&-", 100, "-: error[G0001]: stdin cannot be read: Bad file descriptor\n"),
        ("dump idl/good.gidl >&-", 1, "gidl: standard output: Bad file descriptor\n"),
        ("gen --lang lcm >&-", 1, "gidl: standard output: Bad file descriptor\n"),
        ("--version >&-", 1, "gidl: standard output: Bad file descriptor\n"),
        ("check idl/good.gidl >&-", 0, ""),
        ("check missing.gidl 2>&-", 100, ""),
    ],
)
def test_a_closed_standard_stream_is_one_message(
    here: Path, command: str, status: int, told: str
) -> None:
    run = subprocess.run(
        ["sh", "-c", f"{sys.executable} -m gidl {command}"],
        env={"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr.removesuffix("gidl: 1 error, 0 warnings\n")) == (
        status,
        told,
    )
    assert run.stdout == ""


def test_a_deleted_current_folder_is_named(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "gone").mkdir()
    monkeypatch.chdir(here / "gone")
    (here / "gone").rmdir()
    for words in (["check"], ["gen"], ["fmt"], ["new", "lamp"]):
        assert main(words) == 1
        said = capsys.readouterr()
        assert said == ("", "gidl: the current folder: No such file or directory\n")
    assert main(["explain", "G0001"]) == 0


def test_each_file_that_cannot_be_read_is_named(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "one.gidl", "two.gidl"]) == 100
    said = capsys.readouterr().err
    assert "one.gidl: error[G0001]" in said and "two.gidl: error[G0001]" in said


@pytest.mark.parametrize("arguments", [[], ["frobnicate"], ["gen", "--lang", "cobol"]])
def test_wrong_usage_exits_with_2(here: Path, arguments: list[str]) -> None:
    assert main(arguments) == 2


def test_no_files_and_no_idl_folder_is_wrong_usage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check"]) == 2


def test_a_hidden_declaration_names_the_file_to_include(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "idl" / "user.gidl").write_text("module lab { struct T { S s; }; };\n")
    assert main(["check"]) == 100
    assert 'is not included: #include "good.gidl"' in capsys.readouterr().err


def test_dump_is_the_same_every_time(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "idl/good.gidl"]) == 0
    first = capsys.readouterr().out
    assert main(["dump", "idl/good.gidl"]) == 0
    assert capsys.readouterr().out == first
    (file,) = json.loads(first)["files"]
    assert [d["name"] for d in file["declarations"]] == ["lab::S", "lab::I"]


def test_the_module_runs_as_a_program(here: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-m", "gidl", "check", "idl/good.gidl"],
        env={"PYTHONPATH": str(TREE / "codegen")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


class TestGen:
    def test_writes_what_changed_and_nothing_else(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen"]) == 0
        header = here / "generated" / "cpp" / "good_types.hpp"
        stamp = header.stat().st_mtime_ns
        model = here / "generated" / "model" / "good.json"
        model.write_text(model.read_text() + " ")
        capsys.readouterr()
        assert main(["gen"]) == 0
        assert ", 1 written" in capsys.readouterr().out
        assert header.stat().st_mtime_ns == stamp

    def test_check_shows_the_difference_and_the_command_that_mends_it(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen", "--lang", "model"]) == 0
        model = here / "generated" / "model" / "good.json"
        model.write_text(model.read_text().replace('"look"', '"stare"'))
        capsys.readouterr()
        assert main(["gen", "--lang", "model", "--check"]) == 100
        said = capsys.readouterr().out
        named = "generated/model/good.json"
        assert f"--- {named}\n+++ {named}\t(as generated)\n" in said, "`patch` takes it"
        assert '-     "name": "stare",' in said
        assert '+     "name": "look",' in said
        assert "gidl: 1 file in generated/ not up to date;" in said
        assert said.endswith("to fix, run: gidl gen --lang model\n")
        assert '"stare"' in model.read_text()

    def test_check_is_silent_about_what_is_right(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        main(["gen"])
        capsys.readouterr()
        assert main(["gen", "--check"]) == 0
        assert "are up to date" in capsys.readouterr().out

    def test_deletes_what_is_no_longer_generated_and_only_that(self, here: Path) -> None:
        (here / "idl" / "old.gidl").write_text("module old { struct O { double x; }; };\n")
        assert main(["gen"]) == 0
        out = here / "generated"
        own = out / "cpp" / "mine.hpp"
        own.write_text("// by hand\n")
        gone = sorted(p for p in out.rglob("old*") if p.is_file())
        assert gone
        (here / "idl" / "old.gidl").unlink()
        assert main(["gen", "--check"]) == 100
        assert main(["gen"]) == 0
        assert not any(p.exists() for p in gone)
        assert own.exists()

    def test_writes_nothing_from_wrong_interfaces(self, here: Path) -> None:
        (here / "idl" / "wrong.gidl").write_text(WRONG)
        assert main(["gen"]) == 100
        assert not (here / "generated").exists()

    def test_says_why_when_the_folder_cannot_be_written(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "generated").write_text("a file")
        assert main(["gen"]) == 1
        assert "gidl: " in capsys.readouterr().err

    def test_refuses_an_interface_that_inherits_what_every_object_answers(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        text = '#include "gecos/object.gidl"\ninterface E : gecos::GecosObject { void hit(); };\n'
        (here / "idl" / "e.gidl").write_text(text)
        assert main(["gen"]) == 100
        error = capsys.readouterr().err
        assert "e.gidl:2:11: error[G0801]: E: every object answers the operations" in error
        assert not (here / "generated").exists()

    def test_an_interface_may_use_the_types_of_what_every_object_answers(self, here: Path) -> None:
        text = '#include "gecos/object.gidl"\ninterface E { void hit(in gecos::Holder by); };\n'
        (here / "idl" / "e.gidl").write_text(text)
        assert main(["gen"]) == 0
        client = (here / "generated/cpp/e_client.hpp").read_text()
        assert '#include "e_types.hpp"' in client
        assert "gecos/object_client.hpp" not in client


def test_an_unknown_type_of_a_file_that_is_not_included_says_which(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "shapes.gidl").write_text(
        "module lab {\n  // struct Cube\n  struct Ball { double r; };\n"
        "  typedef double Row[3];\n};\n"
    )
    (tmp_path / "a.gidl").write_text("struct A { lab::Ball b; Row r; Cube c; };\n")
    assert main(["check", "-I", str(tmp_path), str(tmp_path / "a.gidl")]) == 100
    said = capsys.readouterr().err
    for name in ("Ball", "Row"):
        assert (
            f"help: '{name}' is declared in lab/shapes.gidl: #include \"lab/shapes.gidl\"" in said
        )
    assert "Cube' is declared" not in said
