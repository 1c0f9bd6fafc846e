"""Files are UTF-8; comments of older IDL may be Latin-1."""

import os
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.compile import Compiled, compile_files
from gidl.model import Struct


def compiled(tmp_path: Path, data: bytes) -> Compiled:
    file = tmp_path / "a.idl"
    file.write_bytes(data)
    return compile_files([str(file)])


def said(found: Compiled) -> list[tuple[str, int, int]]:
    places = [(f.code, f.location) for f in found.findings]
    return [(code, at.line, at.column) for code, at in places if at is not None]


def test_comments_in_latin_1_are_read_with_one_warning(tmp_path: Path) -> None:
    found = compiled(
        tmp_path, b"/** Gr\xfc\xdfe. */\nstruct A { long x; };\n// \xc3\xa4 and \xe4\n"
    )
    assert said(found) == [("G0706", 1, 7)]
    assert not found.has_errors
    declared = found.model.find("A")
    assert isinstance(declared, Struct)
    assert declared.facts.doc == "Grüße."


@pytest.mark.parametrize(
    ("data", "place"),
    [
        (b'const string S = "\xe4\xe4";', (1, 19)),
        (b"// \xc3\xa4\nstruct \xe9tat { long x; };", (2, 8)),
        (b"//@unit(\xe4)\nstruct A { long x; };", (1, 9)),
    ],
)
def test_other_bytes_are_an_error_at_their_place(
    tmp_path: Path, data: bytes, place: tuple[int, int]
) -> None:
    assert ("G0002", *place) in said(compiled(tmp_path, data))


def test_line_ends_of_an_old_mac_are_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.idl"
    file.write_bytes(b"struct A {\r // the place\r double x;\r};\r")
    for verb in ("check", "fmt"):
        assert main([verb, str(file)]) != 0
        said = capsys.readouterr().err
        assert "error[G0002]: the lines of this file end with CR alone" in said
        assert said.count("error[") == 1


def test_what_conditions_leave_out_is_not_judged(tmp_path: Path) -> None:
    found = compiled(tmp_path, b'#if 0\nconst string S = "\xe4";\n#endif\nstruct A { long x; };\n')
    assert found.findings == ()


def test_the_formatter_writes_utf_8_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.idl"
    file.write_bytes(b"// \xe4\nstruct A { long x; };\n")
    assert main(["fmt", str(file)]) != 0
    assert "is not UTF-8: byte 0xe4 in line 1" in capsys.readouterr().err
    assert file.read_bytes() == b"// \xe4\nstruct A { long x; };\n"


def test_a_file_whose_name_is_not_utf_8_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """No generated file could say what it is made from."""
    (tmp_path / "idl").mkdir()
    (tmp_path / "idl" / os.fsdecode(b"caf\xe9.gidl")).write_text("struct A { long x; };")
    monkeypatch.chdir(tmp_path)
    assert main(["gen"]) == 100
    assert (
        "caf\\udce9.gidl: error[G0001]: the name of this file is not UTF-8"
        in capsys.readouterr().err
    )
    assert not (tmp_path / "generated").exists()
