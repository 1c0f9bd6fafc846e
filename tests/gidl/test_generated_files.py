"""What `gidl gen` deletes, what it leaves alone, how it writes, and what --check says of that."""

import errno
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.cli.output import Outputs, compare, write

STRUCT = "module {0} {{ @final struct {1} {{ double x; }}; }};\n"
INTERFACE = "interface Lamp { @actor void turn(in boolean on); };\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "idl" / "lab").mkdir(parents=True)
    for name in ("oven", "stage"):
        (tmp_path / "idl" / "lab" / f"{name}.gidl").write_text(STRUCT.format("lab", name.title()))
    return tmp_path


def files(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


class TestDeleting:
    def test_naming_a_file_leaves_what_other_files_gave(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen"]) == 0
        before = files(here / "generated")
        (here / "idl" / "lab" / "stage.gidl").unlink()
        for words in ([], ["--check"]):
            assert main(["gen", *words, "idl/lab/oven.gidl"]) == 0
        assert files(here / "generated") == before
        assert "deleted" not in capsys.readouterr().out

    def test_a_named_file_loses_what_it_no_longer_gives(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        oven = here / "idl" / "lab" / "oven.gidl"
        oven.write_text(oven.read_text() + INTERFACE)
        assert main(["gen", "--lang", "cpp"]) == 0
        oven.write_text(STRUCT.format("lab", "Oven"))
        assert main(["gen", "--check", "--lang", "cpp", "idl/lab/oven.gidl"]) == 100
        capsys.readouterr()
        assert main(["gen", "--lang", "cpp", "idl/lab/oven.gidl"]) == 0
        said = capsys.readouterr().out
        for part in ("client", "server"):
            for kind in ("hpp", "cpp"):
                path = f"generated/cpp/lab/oven_{part}.{kind}"
                assert f"gidl: deleted {path}\n" in said
                assert not (here / path).exists()
        assert (here / "generated/cpp/lab/stage_types.hpp").exists()
        assert main(["gen", "--check", "--lang", "cpp"]) == 0

    def test_a_file_written_by_hand_is_not_replaced(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        mine = here / "generated" / "cpp" / "lab" / "oven_types.hpp"
        mine.parent.mkdir(parents=True)
        mine.write_text("// mine\n")
        assert main(["gen", "--lang", "cpp"]) == 100
        said = capsys.readouterr().err
        assert "G1404" in said
        assert "generated/cpp/lab/oven_types.hpp" in said
        assert mine.read_text() == "// mine\n"
        assert [file.name for file in mine.parent.iterdir()] == [mine.name]
        mine.write_text("")  # an empty file is nobody's
        assert main(["gen", "--lang", "cpp"]) == 0

    @pytest.mark.timeout(60)
    def test_a_pipe_in_the_place_of_an_output_is_named(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        pipe = here / "generated" / "lcm" / "lab" / "oven.lcm"
        pipe.parent.mkdir(parents=True)
        os.mkfifo(pipe)
        assert main(["gen", "--lang", "lcm"]) == 100
        assert "generated/lcm/lab/oven.lcm: error[G1404]" in capsys.readouterr().err
        assert main(["gen", "--check", "--lang", "lcm"]) == 100
        assert pipe.is_fifo()

    @pytest.mark.parametrize("words", [[], ["--prune", "idl/lab/oven.gidl"]])
    def test_the_whole_tree_and_prune_clean_up(
        self, here: Path, words: list[str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen", "--lang", "lcm,model"]) == 0
        (here / "idl" / "lab" / "stage.gidl").rename(here / "idl" / "lab" / "table.gidl")
        command = ["gen", "--lang", "lcm,model", *words]
        capsys.readouterr()
        assert main([*command, "--check", "--error-format", "json"]) == 100
        found = json.loads(capsys.readouterr().out)
        stale = ["generated/lcm/lab/stage.lcm", "generated/model/lab/stage.json"]
        assert [f["file"] for f in found if f["code"] == "G1403"] == stale
        assert main(command) == 0
        said = capsys.readouterr().out
        assert [line for line in said.splitlines() if "deleted g" in line] == [
            f"gidl: deleted {path}" for path in stale
        ]
        assert main([*command, "--check"]) == 0

    @pytest.mark.parametrize(
        ("made", "mine"),
        [
            ("python/lab/oven.py", "python/lab/oven_server.py"),
            ("cpp/lab/oven_types.hpp", "cpp/lab/oven_types_old.hpp"),
            ("lcm/lab/oven.lcm", "lcm/lab/oven2.lcm"),
            ("model/lab/oven.json", "model/lab/oven/copy.json"),
        ],
    )
    def test_a_copy_under_a_name_of_its_own_stays(self, here: Path, made: str, mine: str) -> None:
        assert main(["gen"]) == 0
        copy = here / "generated" / mine
        copy.parent.mkdir(exist_ok=True)
        shutil.copy(here / "generated" / made, copy)
        assert main(["gen"]) == 0
        assert copy.exists()
        (here / "idl" / "lab" / "oven.gidl").unlink()
        assert main(["gen"]) == 0
        assert copy.exists()
        assert not (here / "generated" / made).exists()

    def test_everything_that_an_interface_gives_goes_with_it(self, here: Path) -> None:
        oven = here / "idl" / "lab" / "oven.gidl"
        oven.write_text(oven.read_text() + INTERFACE)
        (here / "idl" / "lab" / "stage.gidl").unlink()
        assert main(["gen"]) == 0
        (here / "idl" / "other.gidl").write_text(STRUCT.format("shop", "Other"))
        oven.unlink()
        assert main(["gen"]) == 0
        assert not [path for path in files(here / "generated") if "lab" in path]

    def test_another_run_may_delete_them_first(self, here: Path) -> None:
        assert main(["gen", "--lang", "lcm"]) == 0
        outputs = Outputs(here / "generated")
        difference = compare(outputs, {}, ["lcm"], None)
        assert difference.count == 2
        shutil.rmtree(here / "generated" / "lcm")
        write(outputs, {}, difference)
        assert files(here / "generated") == set()

    def test_files_of_other_makers_stay(self, here: Path) -> None:
        assert main(["gen"]) == 0
        own = here / "generated" / "python" / "lab" / "by_hand.py"
        own.write_text("# mine\n")
        other = here / "generated" / "python" / "notes.txt"
        other.write_text("Generated by gidl from lab/gone.gidl; do not edit.\n")
        assert main(["gen"]) == 0
        assert own.exists()
        assert other.exists()


class TestReports:
    @pytest.fixture
    def wrong(self, here: Path, capsys: pytest.CaptureFixture[str]) -> Path:
        """One generated file differs in its third line, one is missing, one is left over."""
        assert main(["gen", "--lang", "lcm"]) == 0
        lcm = here / "generated" / "lcm" / "lab"
        text = (lcm / "oven.lcm").read_text()
        lines = text.splitlines(keepends=True)
        (lcm / "oven.lcm").write_text("".join([*lines[:2], "// by hand\n", *lines[2:]]))
        (lcm / "old.lcm").write_text(text.replace("oven", "old"))
        (lcm / "stage.lcm").unlink()
        # A warning of the run is part of the same report.
        stage = here / "idl" / "lab" / "stage.gidl"
        stage.write_text(STRUCT.format("lab", "Port"))
        capsys.readouterr()
        return here

    COMMAND = ("gen", "--check", "--lang", "lcm", "--error-format")

    def test_json(self, wrong: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main([*self.COMMAND, "json"]) == 100
        out, err = capsys.readouterr()
        found = {f["code"]: f for f in json.loads(out)}
        assert set(found) == {"G0702", "G1401", "G1402", "G1403"}
        places = {code: (f["file"], f["line"]) for code, f in found.items()}
        assert places["G1401"] == ("generated/lcm/lab/oven.lcm", 3)
        assert places["G1402"] == ("generated/lcm/lab/stage.lcm", None)
        assert places["G1403"] == ("generated/lcm/lab/old.lcm", None)
        assert found["G1401"]["help"] == ["to fix, run: gidl gen --lang lcm"]
        assert err.startswith("gidl: 3 files in generated/ not up to date;")

    def test_sarif(self, wrong: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main([*self.COMMAND, "sarif"]) == 100
        (run,) = json.loads(capsys.readouterr().out)["runs"]
        ids = sorted(result["ruleId"] for result in run["results"])
        assert ids == ["G0702", "G1401", "G1402", "G1403"]
        (changed,) = (r for r in run["results"] if r["ruleId"] == "G1401")
        place = changed["locations"][0]["physicalLocation"]
        assert place["artifactLocation"]["uri"] == "generated/lcm/lab/oven.lcm"
        assert place["region"] == {"startLine": 3, "startColumn": 1}

    def test_github_actions(self, wrong: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main([*self.COMMAND, "github-actions"]) == 100
        lines = capsys.readouterr().out.splitlines()
        assert all(line.startswith(("::error ", "::warning ")) for line in lines)
        assert (
            "::error file=generated/lcm/lab/oven.lcm,line=3,col=1,title=gidl G1401::this file "
            "differs from what gidl gen would write%0Ahelp: to fix, run: gidl gen --lang lcm"
        ) in lines

    def test_text_has_the_difference(self, wrong: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main([*self.COMMAND, "text"]) == 100
        out, err = capsys.readouterr()
        assert "-// by hand\n" in out
        assert "warning[G0702]" in err
        assert out.endswith("to fix, run: gidl gen --lang lcm\n")

    @pytest.mark.parametrize("verb", [["gen"], ["gen", "--check"]])
    def test_a_report_of_nothing_is_whole(
        self, here: Path, verb: list[str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen"]) == 0
        capsys.readouterr()
        assert main([*verb, "--error-format", "json"]) == 0
        assert json.loads(capsys.readouterr().out) == []

    def test_what_cannot_be_generated_is_in_the_one_report(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "e.gidl").write_text(
            '#include "gecos/object.gidl"\n@final struct Port { long x; };\n'
            "interface E : gecos::GecosObject { void hit(); };\n"
        )
        assert main(["gen", "--error-format", "json", "e.gidl"]) == 100
        found = json.loads(capsys.readouterr().out)
        assert {f["code"] for f in found} == {"G0702", "G0801"}

    def test_dump_prints_the_model_and_nothing_else(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "p.gidl").write_text("@final struct Port { long x; };\n")
        assert main(["dump", "--error-format", "json", "p.gidl"]) == 0
        out, err = capsys.readouterr()
        assert list(json.loads(out)) == ["files"]
        assert [f["code"] for f in json.loads(err)] == ["G0702"]


class TestWriting:
    def test_a_full_disk_leaves_everything_as_it_was(
        self, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen", "--lang", "cpp"]) == 0
        before = {p: p.read_text() for p in (here / "generated").rglob("*.?pp")}
        for name in ("oven", "stage"):
            file = here / "idl" / "lab" / f"{name}.gidl"
            file.write_text(file.read_text() + f"interface I{name} {{ @sensor void look(); }};\n")
        real, writes = os.fdopen, []

        def full(*arguments: object, **named: object) -> object:
            writes.append(arguments)
            if len(writes) == 5:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return real(*arguments, **named)  # type: ignore[call-overload]

        monkeypatch.setattr("gidl.cli.output.os.fdopen", full)
        capsys.readouterr()
        assert main(["gen", "--lang", "cpp"]) == 1
        said = capsys.readouterr().err
        assert said.startswith("generated/cpp/lab/")
        assert (
            ": error[G1405]: this output cannot be written: No space left on device\n"
            "      = help: delete files on the full disk, and run gidl again\n"
        ) in said
        assert {p: p.read_text() for p in (here / "generated").rglob("*") if p.is_file()} == before

    def test_a_pipe_is_written_to_and_stays_one(self, here: Path) -> None:
        pipe = here / "inputs.d"
        os.mkfifo(pipe)
        reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
        try:
            assert main(["gen", "--lang", "cpp", "--depfile", str(pipe)]) == 0
            assert pipe.is_fifo()
            assert b"oven" in os.read(reader, 65536)
        finally:
            os.close(reader)

    def test_a_full_standard_output_is_named(
        self, here: Path, capfd: pytest.CaptureFixture[str]
    ) -> None:
        with Path("/dev/full").open("w") as full:
            run = subprocess.run(
                [sys.executable, "-m", "gidl", "dump"],
                env={"PYTHONPATH": os.pathsep.join(sys.path)},
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
                check=False,
            )
        assert run.returncode == 1
        assert run.stderr == "gidl: standard output: No space left on device\n"

    def test_new_files_have_the_usual_permissions_and_old_ones_keep_theirs(
        self, here: Path
    ) -> None:
        assert main(["gen", "--lang", "lcm"]) == 0
        lcm = here / "generated" / "lcm" / "lab" / "oven.lcm"
        (here / "usual").touch()
        assert lcm.stat().st_mode == (here / "usual").stat().st_mode
        lcm.write_text("")
        lcm.chmod(0o600)
        assert main(["gen", "--lang", "lcm"]) == 0
        assert lcm.stat().st_mode & 0o777 == 0o600
