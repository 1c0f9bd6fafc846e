"""What declarations are called in generated code; nothing has the name of something else."""

from __future__ import annotations

from pathlib import Path

import pytest
from gidl.compile import compile_files
from gidl.languages import CPP_TYPES, PYTHON_TYPES
from gidl.type_names import Language, TypeNames, name_types


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


def test_operations_of_the_runtime_have_structs_in_cpp(tmp_path: Path) -> None:
    (tmp_path / "gecos").mkdir()
    text = "module gecos { interface Keeper { long put(in long a); void drop(); }; };"
    names = named(tmp_path, CPP_TYPES, **{"gecos/keeper": text})
    assert names.arguments["gecos::Keeper::put"].name == "Keeper_put_arguments"
    assert names.results["gecos::Keeper::put"].name == "Keeper_put_result"
    assert "gecos::Keeper::drop" not in names.arguments | names.results
    others = named(tmp_path, CPP_TYPES, one=text.replace("module gecos", "module lab"))
    assert not others.arguments
    assert not others.results


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
