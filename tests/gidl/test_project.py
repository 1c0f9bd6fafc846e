"""gidl.toml and the options that it can stand in for."""

import json
import shutil
import subprocess
from dataclasses import fields
from pathlib import Path

import pytest
from gidl import __version__
from gidl.cli.main import main
from gidl.cli.project import Project, line_of, read
from gidl.compile import compile_files
from gidl.diagnostics.findings import Findings
from gidl.model import ArrayType

TREE = Path(__file__).resolve().parents[2]

STRUCT = "module lab {{ @final struct {} {{ double x; }}; }};\n"
WARNS = "@final struct S { double port; };\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project with interfaces in own/, others in other/, and no idl/."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own" / "lab").mkdir(parents=True)
    (tmp_path / "other" / "base").mkdir(parents=True)
    (tmp_path / "other" / "base" / "shape.gidl").write_text(STRUCT.format("Shape"))
    (tmp_path / "own" / "lab" / "oven.gidl").write_text(
        '#include "base/shape.gidl"\nmodule lab { @final struct Oven { Shape door; }; };\n'
    )
    (tmp_path / "gidl.toml").write_text(
        'roots = ["own"]\nimports = ["other"]\nlanguages = ["lcm", "model"]\nout = "made"\n'
    )
    return tmp_path


def files(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


class TestProjectFile:
    def test_gen_alone_does_what_it_says(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen"]) == 0
        assert files(here / "made") == {"lcm/lab/oven.lcm", "model/lab/oven.json"}
        assert capsys.readouterr().out == "gidl: 2 files in made/, 2 written\n"
        for verb in (["check"], ["gen", "--check"], ["fmt", "--check"], ["dump"]):
            assert main(verb) == 0

    def test_it_is_found_from_below(self, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(here / "own" / "lab")
        assert main(["gen"]) == 0
        assert files(here / "made") == {"lcm/lab/oven.lcm", "model/lab/oven.json"}
        assert main(["gen", "--check", "oven.gidl"]) == 0
        assert main(["fmt", "--check"]) == 0

    def test_the_command_line_wins(self, here: Path) -> None:
        command = ["gen", "--lang", "lcm", "--out", "elsewhere", "other/base/shape.gidl"]
        assert main(command) == 0
        assert files(here / "elsewhere") == {"lcm/base/shape.lcm"}
        assert not (here / "made").exists()

    def test_a_language_may_have_a_folder_of_its_own(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        with (here / "gidl.toml").open("a") as toml:
            toml.write('[outputs]\nlcm = "src"\n')
        (here / "src").mkdir()
        (here / "src" / "main.lcm").write_text("package mine;\n")
        oven = here / "own" / "lab" / "oven.gidl"
        oven.rename(oven.with_name("stove.gidl"))
        assert main(["gen"]) == 0
        assert files(here / "src") == {"main.lcm", "lab/stove.lcm"}
        assert "in src/ and made/" in capsys.readouterr().out
        assert files(here / "made") == {"model/lab/stove.json"}
        oven.with_name("stove.gidl").rename(oven)
        assert main(["gen"]) == 0
        assert files(here / "src") == {"main.lcm", "lab/oven.lcm"}
        assert main(["gen", "--check"]) == 0

    def test_generated_files_of_others_further_below_stay(self, here: Path) -> None:
        with (here / "gidl.toml").open("a") as toml:
            toml.write('[outputs]\nlcm = "."\n')
        assert main(["gen"]) == 0
        other = here / "build" / "lab" / "oven.lcm"
        other.parent.mkdir(parents=True)
        other.write_text((here / "lab" / "oven.lcm").read_text())
        stale = here / "lab" / "old.lcm"
        stale.write_text((here / "lab" / "oven.lcm").read_text().replace("oven", "old"))
        assert main(["gen"]) == 0
        assert other.exists()
        assert not stale.exists()

    def test_a_file_from_elsewhere_has_its_own_idl_folder(self, here: Path) -> None:
        far = here / "far" / "idl" / "far"
        far.mkdir(parents=True)
        (far / "one.gidl").write_text(STRUCT.format("One"))
        (far / "two.gidl").write_text('#include "far/one.gidl"\n' + STRUCT.format("Two"))
        assert main(["gen", "--lang", "lcm", "far/idl/far/two.gidl"]) == 0
        assert files(here / "made") == {"lcm/far/two.lcm"}

    def test_the_depfile_names_it(self, here: Path) -> None:
        assert main(["gen", "--depfile", "gidl.d"]) == 0
        needs = (here / "gidl.d").read_text()
        assert "  gidl.toml \\\n" in needs and "other/base/shape.gidl" in needs

    def test_lint_leaves_rules_out(self, here: Path) -> None:
        (here / "own" / "lab" / "oven.gidl").write_text("@final struct Oven { double width; };\n")
        assert main(["lint"]) == 100
        with (here / "gidl.toml").open("a") as toml:
            toml.write('except = ["G0901"]\n')
        assert main(["lint"]) == 0
        assert main(["lint", "--except", "G0907"]) == 100

    def test_breaking_compares_its_roots(
        self, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        for command in (
            ["init", "--quiet"],
            ["add", "."],
            ["-c", "user.name=n", "-c", "user.email=e", "commit", "--quiet", "-m", "first"],
        ):
            subprocess.run(["git", *command], check=True)
        shutil.copytree(here / "own", here / "was")
        assert main(["breaking", "--against", "was"]) == 0
        assert main(["breaking", "--against", "git#ref=HEAD"]) == 0
        (here / "own" / "lab" / "oven.gidl").write_text(STRUCT.format("Oven"))
        monkeypatch.chdir(here / "own")
        capsys.readouterr()
        assert main(["breaking", "--against", "git#ref=HEAD"]) == 100
        assert "HEAD:lab/oven.gidl:2:" in capsys.readouterr().err

    def test_defines_wide_and_strict(self, here: Path) -> None:
        (here / "own" / "lab" / "oven.gidl").write_text(
            "#ifdef LAB\n@final struct S { wstring<MOST> port; };\n#endif\n"
        )
        with (here / "gidl.toml").open("a") as toml:
            toml.write('defines = ["LAB", "MOST=4"]\nwide = "utf8"\n')
        assert main(["check"]) == 0
        assert main(["check", "--strict"]) == 100
        with (here / "gidl.toml").open("a") as toml:
            toml.write("strict = true\n")
        assert main(["check"]) == 100
        assert main(["check", "--no-strict"]) == 0


@pytest.mark.parametrize(
    ("text", "place", "message", "help_line"),
    [
        ('roots = ["own"]\n\nlangauges = ["cpp"]\n', "3:1", "there is no key 'langauges'",
         "did you mean 'languages'?"),
        ("colour = 1\n", "1:1", "there is no key 'colour'", "known keys are roots, imports,"),
        ('roots = [\n  "own",\n  "gone",\n]\n', "1:1",
         "roots: there is no folder 'gone' beside gidl.toml", 'write for example roots = ["idl"]'),
        ('# own\nroots = "own"\n', "2:1", "roots: a list of folders is expected", "for example"),
        ('languages = ["cpp", "cobol"]\n', "1:1",
         "languages: 'cobol' is not one of cpp, lcm, model, python", "for example"),
        ('out = ""\n', "1:1", "out: the name of a folder is expected", 'out = "generated"'),
        ('out = "a\\u0000b"\n', "1:1", "out: the name of a folder is expected", "for example"),
        ('[outputs]\ncpp = "a"\ncobol = "b"\n', "3:1", "there is no key 'outputs.cobol'", "did"),
        ('outputs = "b"\n', "1:1", "outputs: a table is expected", 'cpp = "src" below [outputs]'),
        ('outputs = 3\n', "1:1", "outputs: a table is expected", 'cpp = "src" below [outputs]'),
        ('[outputs]\n\ncpp = 1\n', "3:1", "outputs.cpp: the name of a folder is expected",
         'cpp = "src" below [outputs]'),
        ('defines = ["A B"]\n', "1:1", "defines: 'A B' is not a constant: write NAME or NAME=VALUE",
         "for example"),
        ('wide = true\n', "1:1", "wide: 'utf8' is expected", 'wide = "utf8"'),
        ('strict = "yes"\n', "1:1", "strict: true or false is expected", "strict = true"),
        ('except = ["G0102"]\n', "1:1", "except: 'G0102' is not one of G0708,", "for example"),
        ('roots = ["own"]\nstrict true\n', "2:8",
         "this file is not TOML: Expected '=' after a key", ""),
        ('roots = ["own"\n', "2:1", "this file is not TOML: Unclosed array", ""),
    ],
)  # fmt: skip
def test_a_wrong_project_file_is_told_with_its_line(
    here: Path,
    text: str,
    place: str,
    message: str,
    help_line: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (here / "gidl.toml").write_text(text)
    for verb in ("gen", "fmt"):
        assert main([verb]) == 2
        said = capsys.readouterr().err
        assert f"gidl.toml:{place}: error[G0023]: {message}" in said
        assert help_line in said
    assert not (here / "made").exists()


def test_the_example_of_the_documentation_has_every_key(here: Path) -> None:
    text = (TREE / "docs" / "gidl.md").read_text(encoding="utf-8")
    example = text.split("```toml\n")[1].split("```")[0]
    here.joinpath("gidl.toml").write_text(example)
    for folder in ("idl", "../robcl/idl"):
        (here / folder).mkdir(parents=True)
    findings = Findings()
    said = read(Path("gidl.toml"), findings, {})
    assert findings.found == []
    left_out = Project(Path("gidl.toml"))
    usual = {"file", "roots", "out"}
    assert {
        f.name for f in fields(said) if getattr(said, f.name) == getattr(left_out, f.name)
    } == usual


@pytest.mark.parametrize("data", [b"\xff", b"a = " + b"[" * 5000, b'a = "\\ud800"', b"\0"])
def test_what_is_no_toml_at_all_is_told(
    here: Path, data: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "gidl.toml").write_bytes(data)
    assert main(["check"]) == 2
    assert "error[G0023]: this file is not " in capsys.readouterr().err


def test_every_mistake_is_told_in_one_run(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "gidl.toml").write_text("strict = 1\nwide = 2\n[more]\nx = 1\n")
    assert main(["check", "--error-format", "json"]) == 2
    assert [f["line"] for f in json.loads(capsys.readouterr().out)] == [1, 2, 3]


def test_lines_are_found_behind_text_that_looks_like_a_key() -> None:
    text = 'a = """\nb = 1\n[t]\n"""\nc = [\n  # b = 2\n  "]",\n]\n\n"b" = 3\n[t]\nd = 4\n'
    for ended in (text, text.replace("\n", "\r\n"), text.replace("1\n[t]", "\u2028\n[t]")):
        lines = [line_of(ended, keys) for keys in [("a",), ("c",), ("b",), ("t", "d")]]
        assert lines == [1, 5, 10, 12]


def test_no_files_anywhere_is_wrong_usage(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "own" / "lab" / "oven.gidl").unlink()
    assert main(["check"]) == 2
    assert "the roots of gidl.toml have no interface files" in capsys.readouterr().err


class TestOptions:
    @pytest.fixture(autouse=True)
    def no_project(self, here: Path) -> None:
        (here / "gidl.toml").unlink()

    def test_version(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["--version"]) == 0
        assert capsys.readouterr().out == f"gidl {__version__}\n"

    @pytest.mark.parametrize(
        ("words", "status"),
        [
            ([], 0),
            (["-D", "LEFT"], 100),
            (["-D", "LEFT=0"], 0),
            (["-D", "LEFT=1", "-D", "LEFT=0"], 0),
            (["-D", "2"], 2),
            (["-D", "A(x)=1"], 2),
            (["-D", "A=1\n#error no"], 2),
        ],
    )
    def test_constants_for_the_preprocessor(
        self, here: Path, words: list[str], status: int
    ) -> None:
        (here / "a.gidl").write_text(
            "#if LEFT\n#error left\n#endif\n@final struct A { long x; };\n"
        )
        assert main(["check", *words, "a.gidl"]) == status

    def test_a_constant_may_be_empty_and_is_1_without_a_value(self, here: Path) -> None:
        (here / "a.gidl").write_text(
            "#ifdef LEFT\n@final struct A { long x[2 LEFT * RIGHT]; };\n#endif\n"
        )
        model = compile_files(["a.gidl"], defines=["LEFT=", "RIGHT"]).model
        (member,) = model.struct("A").members
        assert isinstance(member.type, ArrayType) and member.type.dimensions == (2,)

    def test_a_constant_that_cannot_be_read_is_found(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "a.gidl").write_text("@final struct A { long x; };\n")
        assert main(["check", "-D", "MOST=`", "a.gidl"]) == 100
        assert "<-D>:1:1: error[G0005]: ' `' cannot be read" in capsys.readouterr().err

    def test_each_file_begins_with_the_constants(self, here: Path) -> None:
        (here / "a.gidl").write_text("#undef N\n@final struct A { long x; };\n")
        (here / "b.gidl").write_text("@final struct B { long x[N]; };\n")
        assert main(["check", "-D", "N=3", "a.gidl", "b.gidl"]) == 0

    def test_a_folder_that_cannot_be_searched_is_named(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "a.gidl").write_text("@final struct A { long x; };\n")
        assert main(["check", "-I", "nowhere", "-I", "a.gidl", "-I", "own", "a.gidl"]) == 100
        said = capsys.readouterr().err
        assert (
            "nowhere: error[G0024]: this folder cannot be searched for included files: No such"
            in said
        )
        assert (
            "a.gidl: error[G0024]: this folder cannot be searched for included files: Not a dir"
            in said
        )
        assert "own: error" not in said

    def test_strict_takes_warnings_for_errors(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "w.gidl").write_text(WARNS)
        for verb in ("check", "gen", "dump"):
            assert main([verb, "w.gidl"]) == 0
            capsys.readouterr()
            assert (
                main([verb, "--strict", "--out" if verb == "gen" else "-I", ".", "w.gidl"]) == 100
            )
            out, err = capsys.readouterr()
            assert (out, "w.gidl:1:26: error[G0702]" in err) == ("", True)

    def test_strict_of_lint_and_breaking(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "w.gidl").write_text(WARNS)
        assert main(["lint", "--strict", "w.gidl"]) == 100
        said = capsys.readouterr().err
        assert "error[G0702]" in said
        assert "warning[" not in said
        assert main(["breaking", "--against", ".", "w.gidl"]) == 0
        assert main(["breaking", "--strict", "--against", ".", "w.gidl"]) == 100
        assert "error[G0702]" in capsys.readouterr().err
