"""What declarations are called in generated code; nothing has the name of something else."""

from __future__ import annotations

from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.compile import compile_files
from gidl.names.languages import CPP_TYPES, PYTHON_TYPES
from gidl.names.type_names import Language, TypeNames, name_types


def named(folder: Path, language: Language, **files: str) -> TypeNames:
    for name, text in files.items():
        (folder / f"{name}.gidl").write_text(text)
    compiled = compile_files([str(folder / f"{name}.gidl") for name in files], [str(folder)])
    assert not compiled.has_errors, compiled.findings
    return name_types(compiled.model, language)


def test_cpp_keeps_modules_and_names(tmp_path: Path) -> None:
    text = "module a { module b { struct P { long x; }; }; };"
    point = named(tmp_path, CPP_TYPES, one=text).types["a::b::P"]
    assert (point.scope, point.name) == (("a", "b"), "P")


def test_a_module_inside_another_never_hides_the_runtime(tmp_path: Path) -> None:
    text = "module a { module gecos { struct P { long x; }; }; };"
    assert named(tmp_path, CPP_TYPES, one=text).types["a::gecos::P"].scope == ("a", "gecos_")


def test_an_escaped_name_beside_one_that_is_written_so(tmp_path: Path) -> None:
    names = named(tmp_path, CPP_TYPES, one="struct class { long x; }; struct class_ { long x; };")
    assert [names.types[n].name for n in ("class", "class_")] == ["class_", "class__"]


@pytest.mark.parametrize("language", [CPP_TYPES, PYTHON_TYPES])
def test_what_an_interface_brings_along_gives_way_to_what_is_declared(
    tmp_path: Path, language: Language
) -> None:
    text = """
    struct ArmServant { long x; };
    struct Arm_measure_result { long x; };
    struct Arm_State { long x; };
    interface Arm {
      struct State { long x; };
      void measure(out long a, out long b);
    };
    """
    names = named(tmp_path, language, one=text)
    assert names.servants["Arm"].name == "ArmServant_"
    assert names.results["Arm::measure"].name == "Arm_measure_result_"
    assert names.types["Arm::State"].name == "Arm_State_"
    assert names.types["Arm_State"].name == "Arm_State"


CALLS = """
struct Arm_put_result { long x; };
interface Arm {
  long put(in long a);
  void drop();
  attribute long speed;
  readonly attribute long load;
};
"""


def test_every_call_has_structs_in_cpp(tmp_path: Path) -> None:
    names = named(tmp_path, CPP_TYPES, one=CALLS)
    assert {key: place.name for key, place in names.arguments.items()} == {
        "Arm::put": "Arm_put_arguments",
        "Arm::speed=": "Arm_set_speed_arguments",
    }
    assert {key: place.name for key, place in names.results.items()} == {
        "Arm::put": "Arm_put_result_",
        "Arm::speed": "Arm_speed_result",
        "Arm::load": "Arm_load_result",
    }


def test_single_results_have_no_structs_in_python(tmp_path: Path) -> None:
    names = named(tmp_path, PYTHON_TYPES, one=CALLS)
    assert not names.arguments
    assert not names.results


def test_cpp_gives_way_to_what_is_included(tmp_path: Path) -> None:
    names = named(
        tmp_path,
        CPP_TYPES,
        one="interface Arm { struct State { long x; }; };",
        two='#include "one.gidl"\nstruct Arm_State { long x; };',
    )
    assert names.types["Arm::State"].name == "Arm_State"
    assert names.types["Arm_State"].name == "Arm_State_"


def test_python_adds_modules_only_where_a_file_has_a_name_twice(tmp_path: Path) -> None:
    text = """
    module a { struct State { long x; }; struct Pose { long x; }; };
    module b { struct State { long x; }; };
    """
    types = named(tmp_path, PYTHON_TYPES, one=text).types
    assert [types[n].name for n in ("a::State", "b::State", "a::Pose")] == [
        "a_State", "b_State", "Pose",
    ]  # fmt: skip


def test_names_do_not_depend_on_what_else_is_compiled(tmp_path: Path) -> None:
    one = "interface Arm { struct State { long x; }; };"
    alone = named(tmp_path, CPP_TYPES, one=one).types["Arm::State"]
    beside = named(tmp_path, CPP_TYPES, zero="struct Arm_State { long x; };", one=one)
    assert beside.types["Arm::State"] == alone


ADDED = """
module m {
  interface I { enum Mode { p, q }; };
  interface Lamp { @sensor void g(out long b, out long c); };
};
"""
DECLARED = """
module m {
  struct I_Mode { long x; };
  struct LampServant { long z; };
  struct LampInterface { long t; };
  struct Lamp_g_result { long x; };
};
"""


class TestNamesOfTwoFiles:
    @pytest.fixture
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "a.gidl").write_text(ADDED)
        (tmp_path / "b.gidl").write_text(DECLARED)
        (tmp_path / "c.gidl").write_text('#include "a.gidl"\n#include "b.gidl"\n')
        return tmp_path

    def test_a_file_that_includes_both_is_refused(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen", "c.gidl"]) == 100
        said = capsys.readouterr().err
        for name, what in (
            ("I_Mode", "'m::I::Mode'"),
            ("LampServant", "the servant of 'm::Lamp'"),
            ("LampInterface", "the description of 'm::Lamp'"),
            ("Lamp_g_result", "the results of 'm::Lamp::g'"),
        ):
            assert (
                "c.gidl:1:1: error[G0114]: two files that this file includes give the same "
                f"C++ name 'm::{name}' to {what} and to 'm::{name}'" in said
            )
        assert "help: rename 'm::Lamp::g' or 'm::Lamp_g_result', or include one" in said
        assert "a.gidl:3:22: note: 'm::I::Mode' is declared here" in said
        assert "b.gidl:3:10: note: 'm::I_Mode' is declared here" in said
        assert said.count("error[") == 4
        assert main(["gen", "c.gidl", "--lang", "python"]) == 0

    def test_two_files_of_one_run_are_refused(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["gen", "a.gidl", "b.gidl"]) == 100
        said = capsys.readouterr().err
        assert "b.gidl:3:10: error[G0114]: two files give the same C++ name 'm::I_Mode'" in said
        assert main(["gen", "a.gidl"]) == 0

    def test_a_name_that_gives_way_is_no_clash(self, here: Path) -> None:
        (here / "b.gidl").write_text(f'#include "a.gidl"\n{DECLARED}')
        assert main(["gen", "c.gidl"]) == 0

    def test_a_module_and_a_type_are_a_clash(
        self, here: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (here / "b.gidl").write_text("module m { module I_Mode { struct P { long x; }; }; };")
        assert main(["gen", "c.gidl"]) == 100
        assert "'m::I_Mode' to 'm::I::Mode' and to module 'm::I_Mode'" in capsys.readouterr().err
