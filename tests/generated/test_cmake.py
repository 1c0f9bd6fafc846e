"""gidl_generate in a project of its own: configured for real, and a header compiled."""

import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
# Gidl.cmake links two libraries of the tree; here they are what headers need of them.
PROJECT = """\
cmake_minimum_required(VERSION 3.22)
project(test {languages})
include("{tree}/cmake/Gidl.cmake")
foreach(name generated gecos_session json)
  add_library(robcl::${{name}} INTERFACE IMPORTED)
  target_include_directories(robcl::${{name}} INTERFACE "{tree}/runtime/cpp" "{tree}/generated/cpp")
  target_compile_features(robcl::${{name}} INTERFACE cxx_std_20)
endforeach()
{body}
"""
BALL = "module shapes { @final struct Ball { double radius; }; };\n"
LAMP = (
    '#include "shapes/ball.idl"\n#include "gecos/object_ref.gidl"\n'
    "module lab { @final struct Lamp { shapes::Ball bulb; gecos::ObjectRef switch_; }; };\n"
)


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """Interfaces in own/lab, and others in far/shapes, where one includes another."""
    for folder in ("own/lab", "far/shapes"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "far/shapes/unit.gidl").write_text("module shapes { typedef double Metre; };\n")
    (tmp_path / "far/shapes/ball.idl").write_text('#include "shapes/unit.gidl"\n' + BALL)
    (tmp_path / "own/lab/lamp.gidl").write_text(LAMP)
    (tmp_path / "own/lab/torch.idl").write_text(LAMP.replace("Lamp", "Torch"))
    return tmp_path


def configured(here: Path, body: str, languages: str = "NONE") -> subprocess.CompletedProcess[str]:
    text = PROJECT.format(tree=TREE, languages=languages, body=body)
    (here / "CMakeLists.txt").write_text(text)
    words = ["cmake", "-S", str(here), "-B", str(here / "build"), "-G", "Ninja"]
    words.append(f"-DPython_EXECUTABLE={sys.executable}")  # another may lack jinja2
    return subprocess.run(words, capture_output=True, text=True, check=False, timeout=100)


def refusal(here: Path, body: str) -> str:
    run = configured(here, body)
    assert run.returncode != 0
    return " ".join(run.stderr.split())


ONE = 'gidl_generate(lamp "own/lab/lamp.gidl" ROOT own IMPORTS far)\n'
TWO = 'gidl_generate(torch "own/lab/torch.idl" ROOT own IMPORTS far)\n'
SAY = """
foreach(target lamp torch)
  get_target_property(links ${target} LINK_LIBRARIES)
  message(STATUS "${target} links ${links}")
endforeach()
"""


def test_what_is_imported_is_generated_once(here: Path) -> None:
    user = (
        'file(WRITE user.cpp "#include \\"lab/lamp_types.hpp\\"\\n'
        '#include \\"lab/torch_types.hpp\\"\\nlab::Lamp lamp; lab::Torch torch;\\n")\n'
        "add_library(user OBJECT user.cpp)\ntarget_link_libraries(user PRIVATE torch lamp)\n"
    )
    run = configured(here, ONE + TWO + SAY + user.replace("user.cpp", f"{here}/user.cpp"), "CXX")
    assert run.returncode == 0, run.stderr
    assert "-- lamp links lamp_imports;robcl::generated;robcl::gecos_session" in run.stdout
    assert "-- torch links lamp_imports;robcl::generated;robcl::gecos_session" in run.stdout
    made = {p.relative_to(here / "build") for p in (here / "build").rglob("*_types.hpp")}
    assert {path.as_posix() for path in made} == {
        "lamp/cpp/lab/lamp_types.hpp",
        "lamp_imports/cpp/shapes/ball_types.hpp",
        "lamp_imports/cpp/shapes/unit_types.hpp",
        "torch/cpp/lab/torch_types.hpp",
    }
    build = ["cmake", "--build", str(here / "build"), "--target", "user"]
    done = subprocess.run(build, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_an_earlier_call_makes_is_linked(here: Path) -> None:
    first = 'gidl_generate(torch "far/shapes/ball.idl" "far/shapes/unit.gidl" ROOT far)\n'
    run = configured(here, first + ONE + SAY, "CXX")
    assert run.returncode == 0, run.stderr
    assert "-- lamp links torch;robcl::generated;robcl::gecos_session" in run.stdout
    assert not (here / "build" / "lamp_imports").exists()


def test_a_later_call_for_what_was_imported_is_refused(here: Path) -> None:
    later = 'gidl_generate(ball "far/shapes/ball.idl" ROOT far)\n'
    said = refusal(here, ONE + later)
    assert "far/shapes/ball.idl was generated already for lamp, which imports it; call" in said
    assert "gidl_generate(ball) before gidl_generate(lamp)" in said


def test_two_names_of_one_file_are_refused(here: Path) -> None:
    first = 'gidl_generate(ball "far/shapes/ball.idl" ROOT far/shapes IMPORTS far)\n'
    assert "shapes/ball.idl here and ball.idl for ball" in refusal(here, first + ONE)


def test_an_included_file_that_no_call_makes_is_named(here: Path) -> None:
    (here / "own/lab/room.gidl").write_text(
        '#include "lab/lamp.gidl"\nmodule lab { @final struct Room { lab::Lamp light; }; };\n'
    )
    room = 'gidl_generate(room "own/lab/room.gidl" ROOT own IMPORTS far)\n'
    said = refusal(here, room)
    assert f"nothing makes the headers of {here}/own/lab/lamp.gidl, which a file of room" in said
    assert "name it in gidl_generate(room), or in another gidl_generate" in said
    run = configured(here, room + ONE, "CXX")  # the order is free
    assert run.returncode == 0, run.stderr


def test_what_is_not_there_is_named(here: Path) -> None:
    assert "ROOT" in refusal(here, "gidl_generate(lamp own/lab/lamp.gidl ROOT nowhere)\n")
    assert "does not exist" in refusal(here, "gidl_generate(lamp gone.gidl)\n")
    body = "gidl_generate(lamp own/lab/lamp.gidl ROOT own IMPORTS nowhere far)\n"
    assert "nowhere: error[G0024]: this folder cannot be searched" in refusal(here, body)


def test_the_project_file_is_heeded_and_watched(here: Path) -> None:
    (here / "own/lab/lamp.gidl").write_text(
        "#ifdef LAMP\nmodule lab { @final struct Lamp { long x; }; };\n#else\n#error dark\n#endif\n"
    )
    assert "#error dark" in refusal(here, ONE)
    (here / "gidl.toml").write_text('roots = ["own"]\ndefines = ["LAMP"]\n')
    watched = (
        "get_property(watched DIRECTORY PROPERTY CMAKE_CONFIGURE_DEPENDS)\n"
        'message(STATUS "watched ${watched}")\n'
    )
    run = configured(here, ONE + watched, "CXX")
    assert run.returncode == 0, run.stderr
    assert f"{here}/gidl.toml" in run.stdout
    (here / "own/lab/torch.idl").write_text("@final struct Torch { long x; };\n")
    torch = ONE.replace("lamp.gidl", "torch.idl")
    assert configured(here, torch, "CXX").returncode == 0
    assert not list((here / "build").rglob("lamp_types.hpp")), "what is left over would be built"
