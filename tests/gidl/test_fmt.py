"""`gidl fmt`: one layout, nothing else changed, and a second time nothing at all.

After a deliberate change: `GIDL_WRITE_GOLDENS=1 pytest tests/gidl/test_fmt.py`, then read the
difference.
"""

import io
import os
import re
import resource
import shutil
import sys
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.compile import compile_files, room_for_nesting
from gidl.fmt import UnreadableError, layout
from gidl.fmt.pieces import scan
from gidl.targets.model_json import model_text
from gidl.wire import wire_layout
from gidl.wire.events import events_as_streams
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

HERE = Path(__file__).parent
IDL = HERE.parents[1] / "idl"
CASES = sorted((HERE / "fmt").glob("*.gidl"))
CORPUS = [
    *sorted((HERE / "good").rglob("*.gidl")),
    # The vocabulary is declared in every run already.
    *(p for p in sorted(IDL.rglob("*.gidl")) if p.name != "annotations.gidl"),
]
DIRECTIVES = sorted((HERE / "preprocessor").glob("*.gidl"))  # no line of these can be joined
SETTINGS = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def model_of(file: Path) -> str | None:
    """The model as JSON, which has everything but places; None of a file with errors."""
    compiled = compile_files([str(file)], [str(IDL), str(HERE / "good")])
    if compiled.has_errors:
        return None
    model = events_as_streams(compiled.model)
    return model_text(model, wire_layout.build(model))


def assert_only_white_space_moves(place: Path, text: str, *, may_be_wrong: bool = False) -> None:
    place.write_text(text, encoding="utf-8")
    before = model_of(place)
    if before is None and may_be_wrong:
        reject()
    assert before is not None
    laid_out = layout(text)
    assert layout(laid_out) == laid_out
    place.write_text(laid_out, encoding="utf-8")
    assert model_of(place) == before


@pytest.mark.parametrize("case", CASES, ids=lambda p: p.stem)
def test_layout_is_as_in_the_golden(case: Path) -> None:
    golden = case.with_suffix(".txt")
    result = layout(case.read_text(encoding="utf-8"))
    if os.environ.get("GIDL_WRITE_GOLDENS"):
        golden.write_text(result, encoding="utf-8")
    assert result == golden.read_text(encoding="utf-8")
    assert layout(result) == result


def test_there_are_files_to_try() -> None:
    assert len(CASES) >= 2
    assert len(CORPUS) >= 13


@pytest.mark.parametrize("file", [*CORPUS, *DIRECTIVES], ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_the_model_stays_the_same(file: Path, tmp_path: Path) -> None:
    assert model_of(file) is not None
    shutil.copytree(HERE / "preprocessor" / "parts", tmp_path / "parts")
    place = tmp_path / file.name
    assert_only_white_space_moves(place, file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", CORPUS, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_one_line_per_line_of_the_author_or_all_on_one(file: Path, tmp_path: Path) -> None:
    """However far the author went in breaking lines or in joining them."""
    text = file.read_text(encoding="utf-8")
    if "\n#" in text.replace("\n#pragma once", "").replace("\n#include", ""):
        text = re.sub(r"(?m)^#(if|el|end|error).*\n", "", text)
    pieces = [p for p in scan(text) if not p.is_comment]
    for separator in ("\n", " "):
        broken = ""
        for p in pieces:
            if p.text == "::" and not p.spaced:  # behind a space it ends an annotation's name
                broken = broken.removesuffix(separator)
            broken += f"\n{p.text}\n" if p.kind == "directive" else f"{p.text}{separator}"
        assert_only_white_space_moves(tmp_path / file.name, broken)


@SETTINGS
@given(st.sampled_from(CORPUS), st.randoms(use_true_random=False))
def test_any_white_space_gives_the_same_model(tmp_path: Path, file: Path, random: object) -> None:
    """White space between any two pieces is replaced, comments included."""
    choose = random.choice  # type: ignore[attr-defined]
    text = ""
    for piece in scan(file.read_text(encoding="utf-8")):
        if piece.kind == "directive":
            text += f"\n{piece.text}\n"
        else:
            space = choose([" ", " ", "  ", "\n", "\n\n", "\n      ", "\t", "\r\n\r\n\r\n"])
            end = "\n" if piece.is_line_comment else ""
            text += f"{piece.text}{end}{space}"
    assert_only_white_space_moves(tmp_path / "mangled.gidl", text, may_be_wrong=True)


@SETTINGS
@given(st.sampled_from(CORPUS), st.data())
def test_comments_anywhere_stay_where_they_are(
    tmp_path: Path, file: Path, data: st.DataObject
) -> None:
    """A comment put between any two pieces is kept, and so is what it says about them."""
    pieces = scan(file.read_text(encoding="utf-8"))
    at = data.draw(st.integers(0, len(pieces) - 1))
    comment = data.draw(
        st.sampled_from(["// c\n", "/* c */", "/** c\n   * d */", "\n// c\n", "\n/// c\n"])
    )
    lines = file.read_text(encoding="utf-8").split("\n")
    piece = pieces[at]
    line = lines[piece.line - 1]
    lines[piece.line - 1] = line[: piece.column] + comment + line[piece.column :]
    assert_only_white_space_moves(tmp_path / "commented.gidl", "\n".join(lines), may_be_wrong=True)


def test_conditions_around_half_a_body_are_refused_by_line() -> None:
    with pytest.raises(UnreadableError) as caught:
        layout("#if 1\nstruct A {\n#else\nstruct B {\n#endif\n long x; };\n")
    assert caught.value.line == 2


def test_a_skipped_hash_inside_a_line_is_not_made_a_line_of_its_own() -> None:
    with pytest.raises(UnreadableError, match="has text before a '#' on the same line") as caught:
        layout("#if 0\nold #else\nmodule m { const long x = 1; };\n#endif\n")
    assert caught.value.line == 2


def test_deep_nesting_is_laid_out() -> None:
    text = "".join(f"module m{i} {{\n" for i in range(190)) + "struct S { long x; };" + "};" * 190
    with room_for_nesting():
        assert layout(layout(text)) == layout(text)


def test_an_empty_file_stays_empty() -> None:
    assert layout("") == ""
    assert layout("\n\n \n") == ""


def test_line_ends_and_byte_order_marks_are_made_one_kind() -> None:
    assert layout("\ufeffstruct S {\r\n  long x;  // a\r\n};\r\n") == layout(
        "struct S {\n  long x;  // a\n};\n"
    )


class TestCommand:
    @pytest.fixture(autouse=True)
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "idl").mkdir()
        (tmp_path / "idl" / "a.gidl").write_text("struct  A { long x; };\n")
        (tmp_path / "idl" / "b.gidl").write_text("struct B { long x; };\n")
        return tmp_path

    def test_check_shows_the_difference_and_writes_nothing(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["fmt", "--check"]) == 100
        out = capsys.readouterr().out
        assert "-struct  A { long x; };\n+struct A { long x; };\n" in out
        assert out.endswith("gidl: 1 of 2 files not formatted; to fix, run: gidl fmt\n")
        assert (here / "idl" / "a.gidl").read_text() == "struct  A { long x; };\n"

    def test_check_names_the_files_that_were_named(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["fmt", "--check", "idl/b.gidl", "idl/a.gidl"]) == 100
        assert capsys.readouterr().out.endswith("to fix, run: gidl fmt idl/a.gidl\n")

    def test_writes_what_differs_and_nothing_else(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        stamp = (here / "idl" / "b.gidl").stat().st_mtime_ns
        assert main(["fmt"]) == 0
        assert capsys.readouterr().out == "gidl: 2 files, 1 formatted\n"
        assert (here / "idl" / "a.gidl").read_text() == "struct A { long x; };\n"
        assert (here / "idl" / "b.gidl").stat().st_mtime_ns == stamp
        assert main(["fmt", "--check"]) == 0

    def test_stdin_goes_to_stdout(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"struct  A{long x;};")))
        assert main(["fmt", "-"]) == 0
        assert capsys.readouterr() == ("struct A { long x; };\n", "")

    def test_a_wrong_file_stays_as_it_is_and_the_others_are_laid_out(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "idl" / "wrong.gidl").write_text("struct  { long x; };\n")
        assert main(["fmt"]) == 100
        said = capsys.readouterr()
        assert "idl/wrong.gidl:1:9: error[G0100]" in said.err
        assert said.out == "gidl: 3 files, 1 formatted, 1 left unchanged because of errors\n"
        assert (here / "idl" / "wrong.gidl").read_text() == "struct  { long x; };\n"
        assert (here / "idl" / "a.gidl").read_text() == "struct A { long x; };\n"

    def test_what_cannot_be_laid_out_is_a_finding(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        half = "#if 1\nstruct  A {\n#else\nstruct B {\n#endif\n long x; };\n"
        (here / "idl" / "a.gidl").write_text(half)
        assert main(["fmt"]) == 100
        assert (
            "idl/a.gidl:2:1: error[G0014]: this file cannot be formatted" in capsys.readouterr().err
        )
        assert (here / "idl" / "a.gidl").read_text() == half


def test_on_a_full_disk_the_file_stays_as_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "big.gidl"
    text = "module m{" + "".join(f"struct S{i}{{long a;}};" for i in range(1000)) + "};"
    file.write_text(text)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        status = main(["fmt", str(file)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (status, capsys.readouterr().err) == (1, f"gidl: {file}: File too large\n")
    assert file.read_text() == text
    assert [found.name for found in tmp_path.iterdir()] == ["big.gidl"]


def test_a_file_that_is_laid_out_keeps_its_mode_and_stays_behind_its_link(tmp_path: Path) -> None:
    file, link = tmp_path / "a.gidl", tmp_path / "link.gidl"
    file.write_text("module m{struct S{long a;};};")
    file.chmod(0o640)
    link.symlink_to(file)
    assert main(["fmt", str(link)]) == 0
    assert link.is_symlink()
    assert file.stat().st_mode & 0o777 == 0o640
    assert "\n" in file.read_text()
