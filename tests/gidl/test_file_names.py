"""Names of generated files and modules, and .idl files in the place of .gidl files."""

import errno
import importlib.util
import json
import keyword
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from gidl.cli.main import main
from gidl.files.names import interfaces_below, python_stem, same_modules, source_stem
from gidl.files.standard_modules import STANDARD

STRUCT = "@final struct {} {{ double x; }};\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "idl").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("path", "module"),
    [
        ("robcl/geometry.gidl", "robcl/geometry"),
        ("robcl/geometry.idl", "robcl/geometry"),
        ("LAMP.IDL", "LAMP"),
        ("my-device.gidl", "my_device"),
        ("my lab/a.b.gidl", "my_lab/a_b"),
        ("2fast/3.gidl", "_2fast/_3"),
        ("class/import.idl", "class_/import_"),
        ("größe.gidl", "größe"),
        ("o\u0308l.gidl", "öl"),
        ("lab/__init__.gidl", "lab/__init___"),
        (".gidl", "_"),
        ("types.gidl", "types_"),
        ("enum/lamp.idl", "enum_/lamp"),
        ("lab/types.gidl", "lab/types"),
        ("numpy.gidl", "numpy_"),
        ("gecos.gidl", "gecos_"),
        ("gecos/object.gidl", "gecos_idl/object"),
        ("robcl.gidl", "robcl_"),
        ("gecos_idl.gidl", "gecos_idl_"),
        ("lcm/lamp.gidl", "lcm_/lamp"),
    ],
)
def test_a_module_can_be_imported_and_hides_none(path: str, module: str) -> None:
    assert python_stem(path) == module
    for part in module.split("/"):
        assert part.isidentifier() and not keyword.iskeyword(part)


def test_the_table_has_the_standard_library_of_this_python() -> None:
    assert sys.stdlib_module_names <= STANDARD


def test_other_endings_stay() -> None:
    assert source_stem("lab/lamp.txt") == "lab/lamp.txt"
    assert python_stem("lab/lamp.txt") == "lab/lamp_txt"


@pytest.mark.parametrize(
    ("paths", "what"),
    [
        (["my-lamp.gidl", "my_lamp.idl"], "the Python module my_lamp"),
        (["lamp.gidl", "lamp_types.gidl"], "the Python module lamp_types"),
        (["lab.gidl", "lab/lamp.gidl"], "the Python package lab"),
        (["a/b/c.gidl", "a/b.gidl"], "the Python package a.b"),
        (["enum.gidl", "enum_.gidl"], "the Python module enum_"),
    ],
)
def test_two_files_of_one_module_are_told(paths: list[str], what: str) -> None:
    (clash,) = same_modules(paths)
    assert {clash.path, clash.other} == set(paths)
    assert clash.what == what


class TestIdl:
    def test_the_files_are_those_of_a_gidl_file(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "idl" / "lamp.idl").write_text("interface Lamp { @actor void on(); };\n")
        assert main(["gen", "--depfile", "gidl.d"]) == 0
        made = {p.relative_to("generated").as_posix() for p in Path("generated").rglob("*.*")}
        assert {"cpp/lamp_types.hpp", "cpp/lamp_client.cpp", "cpp/lamp_json.hpp"} <= made
        assert {"python/lamp.py", "python/lamp_types.py", "model/lamp.json"} <= made
        assert not [path for path in made if ".idl" in path]
        assert "idl/lamp.idl" in Path("gidl.d").read_text()
        assert main(["gen", "--check"]) == 0
        assert main(["gen", "--check", "idl/lamp.idl"]) == 0

    def test_every_verb_looks_for_it(self, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
        lamp = here / "idl" / "lamp.idl"
        lamp.write_text("struct  Lamp { double height; };\n")
        assert main(["check"]) == 0
        assert main(["lint"]) == 100
        assert "idl/lamp.idl:1:" in capsys.readouterr().err
        assert main(["fmt"]) == 0
        assert lamp.read_text() == "struct Lamp { double height; };\n"
        capsys.readouterr()
        assert main(["dump"]) == 0
        assert json.loads(capsys.readouterr().out)["files"][0]["path"] == "lamp.idl"
        (here / "was").mkdir()
        (here / "was" / "lamp.gidl").write_text("struct Lamp { float height; };\n")
        assert main(["breaking", "--against", "was"]) == 100
        said = capsys.readouterr().err
        assert "was float and is now double" in said
        assert "has moved" not in said, "its headers and modules are called as before"

    def test_hidden_folders_are_not_searched(self, here: Path) -> None:
        (here / "idl" / ".venv").mkdir()
        (here / "idl" / ".venv" / "wrong.idl").write_text("struct {\n")
        (here / "idl" / "lamp.idl").write_text(STRUCT.format("Lamp"))
        assert main(["check"]) == 0

    @pytest.mark.parametrize("verb", ["check", "gen", "breaking"])
    def test_a_folder_that_cannot_be_read_ends_the_run(
        self,
        here: Path,
        verb: str,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        (here / "idl" / "lab").mkdir()
        (here / "idl" / "lab" / "lamp.gidl").write_text(STRUCT.format("Lamp"))
        (here / "idl" / "oven.gidl").write_text(STRUCT.format("Oven"))
        shutil.copytree(here / "idl", here / "was")
        assert main(["gen"]) == 0
        before = sorted(Path("generated").rglob("*"))
        real = os.scandir

        def locked(folder: Path) -> Any:
            if Path(folder).name == "lab" and Path(folder).parent.name == "idl":
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
            return real(folder)

        monkeypatch.setattr("os.scandir", locked)
        capsys.readouterr()
        assert main([verb, *(["--against", "was"] if verb == "breaking" else [])]) == 1
        assert capsys.readouterr() == ("", "gidl: idl/lab: Permission denied\n")
        monkeypatch.undo()
        monkeypatch.chdir(here)
        assert sorted(Path("generated").rglob("*")) == before

    def test_links_to_folders_are_followed_once(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "far" / "lamp").mkdir(parents=True)
        (here / "far" / "lamp" / "lamp.gidl").write_text(STRUCT.format("Lamp"))
        (here / "idl" / "again").symlink_to(here / "far")
        (here / "idl" / "lab").symlink_to(here / "far")
        (here / "far" / "back").symlink_to(here / "idl")
        assert interfaces_below(Path("idl")) == [Path("idl/again/lamp/lamp.gidl")]
        (here / "far" / "wrong.gidl").write_text("struct {\n")
        assert main(["check"]) == 100
        assert "idl/again/wrong.gidl:1:" in capsys.readouterr().err

    def test_a_folder_with_the_ending_of_a_file_is_searched(self, here: Path) -> None:
        (here / "idl" / "acme.idl").mkdir()
        (here / "idl" / "acme.idl" / "lamp.gidl").write_text(STRUCT.format("Lamp"))
        assert main(["gen"]) == 0
        assert Path("generated/cpp/acme.idl/lamp_types.hpp").is_file()

    def test_a_name_declared_in_one_is_found(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "idl" / "shape.idl").write_text(STRUCT.format("Ball"))
        (here / "idl" / "user.gidl").write_text('#include "shap.idl"\nstruct U { Ball b; };\n')
        assert main(["check", "idl/user.gidl"]) == 100
        assert "did you mean 'shape.idl'?" in capsys.readouterr().err
        (here / "idl" / "user.gidl").write_text("struct U { Ball one; };\n")
        assert main(["check", "idl/user.gidl"]) == 100
        assert '#include "shape.idl"' in capsys.readouterr().err

    def test_beside_a_gidl_file_of_its_name_it_is_refused(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "idl" / "lamp.gidl").write_text(STRUCT.format("Lamp"))
        (here / "idl" / "lamp.idl").write_text(STRUCT.format("Light"))
        for verb in ("check", "gen"):
            assert main([verb]) == 100
            said = capsys.readouterr().err
            assert (
                "idl/lamp.idl: error[G0021]: this file generates the files lamp_types.hpp" in said
            )
            assert "as does idl/lamp.gidl\n" in said
        assert main(["gen", "idl/lamp.idl"]) == 0


@pytest.mark.parametrize(
    ("name", "told", "what"),
    [
        ('la"mp.gidl', 'la"mp.gidl', "'\"'"),
        ("la\\mp.gidl", "la\\mp.gidl", r"'\\'"),
        ("la\nmp.gidl", r"la\nmp.gidl", "the control character U+000A"),
        ("la\x1bmp.idl", r"la\x1bmp.idl", "the control character U+001B"),
        ("la\u2028mp.idl", r"la\u2028mp.idl", "the control character U+2028"),
    ],
)
def test_a_name_that_ends_an_include_or_a_line_is_refused(
    here: Path, name: str, told: str, what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "idl" / name).write_text(STRUCT.format("Lamp"))
    assert main(["gen"]) == 100
    said = capsys.readouterr().err
    assert f"idl/{told}: error[G0001]: the name of this file has {what}, which" in said
    assert not Path("generated").exists()


def test_a_folder_above_the_roots_may_be_called_anything(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / 'o"h' / "idl").mkdir(parents=True)
    (here / 'o"h' / "idl" / "lamp.gidl").write_text(STRUCT.format("Lamp"))
    assert main(["gen", 'o"h/idl/lamp.gidl']) == 0


def test_two_files_of_one_module_are_refused_where_python_is_wanted(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "idl" / "my-lamp.gidl").write_text(STRUCT.format("Lamp"))
    (here / "idl" / "my_lamp.gidl").write_text(STRUCT.format("Light"))
    assert main(["gen"]) == 100
    said = capsys.readouterr().err
    assert "idl/my_lamp.gidl: error[G0022]: this file generates the Python module my_lamp" in said
    assert "as does idl/my-lamp.gidl\n" in said
    assert not Path("generated").exists()
    assert main(["gen", "--lang", "cpp,lcm,model"]) == 0


def test_what_is_generated_imports_whatever_the_files_are_called(here: Path) -> None:
    names = ("my-device", "a.b", "2fast", "class", "types", "enum", "array", "gecos", "numpy")
    for number, name in enumerate((*names, "robcl", "dataclasses", "typing", "json/lamp")):
        place = here / "idl" / f"{name}.gidl"
        place.parent.mkdir(exist_ok=True)
        before = f'#include "{names[number - 1]}.gidl"\n' if 0 < number < len(names) else ""
        after = f"S{number - 1} inside;" if before else "sequence<double> x;"
        place.write_text(
            f"{before}module lab {{ @final struct S{number} {{ {after} }};\n"
            f"  interface I{number} {{ @actor void go(in S{number} what); }}; }};\n"
        )
    assert main(["gen", "--lang", "python"]) == 0
    python = here / "generated" / "python"
    modules = [p.relative_to(python).with_suffix("") for p in python.rglob("*.py")]
    assert len(modules) == 26
    tree = Path(__file__).resolve().parents[2]
    path = [python, tree / "runtime" / "python", tree / "generated" / "python"]
    imports = "; ".join(f"import {'.'.join(module.parts)}" for module in modules)
    assert importlib.util.find_spec("gecos") is not None
    run = subprocess.run(
        [sys.executable, "-c", f"{imports}; import enum, numpy, gecos, types; enum.IntEnum"],
        env={"PYTHONPATH": ":".join(map(str, path))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
