"""No name of an interface breaks generated C++: whatever its bodies call their parameters, locals
and members may be what a type, parameter or member is called. As clang sees it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest
from generating import TREE, generate
from gidl.names.languages import CPP_TYPES, CPP_WORDS
from gidl.syntax.keywords import CPP, USED_BY_LOWER
from names_in_use import members_file, types_file

sys.path.insert(0, str(TREE / "tools"))
from cpp_names_of_headers import source

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
OURS = CPP_TYPES.type_words - CPP_WORDS
COMMON = {"EIO", "INT_MAX", "NULL", "assert", "errno", "linux", "major", "std", "stdin", "unix"}
NAMES = sorted(word for word in OURS | COMMON if word.islower() or word.lower() not in OURS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The generated C++ of interfaces that have all those names."""
    out = tmp_path_factory.mktemp("names")
    (out / "members.gidl").write_text(members_file("members", NAMES))
    (out / "types.gidl").write_text(types_file("types", NAMES))
    generate(out, "--lang", "cpp", out / "members.gidl", out / "types.gidl")
    return out / "cpp"


def test_the_names_are_all_that_bodies_of_types_declare() -> None:
    """A local that a template gets tomorrow has to be among them."""
    qualifier = r"(?:const |static |constexpr )*"
    local = re.compile(rf"^ +(?! |return\b){qualifier}[\w:<>, ]+[*&]* ([a-z]+)_?(?:\{{| = |;)")
    found = set()
    for path in (TREE / "generated" / "cpp").rglob("*_types.cpp"):
        found |= {m[1] for line in path.read_text().splitlines() if (m := local.match(line))}
    assert {"number", "size"} <= found <= set(NAMES)


@pytest.mark.parametrize("file", ["everything.gidl", "events/button.gidl", "inward/feeder.gidl"])
def test_a_constant_may_have_the_name_of_anything_in_generated_code(
    file: str, tmp_path: Path
) -> None:
    """Whatever generated code calls a parameter or a local, now or after the next change of a
    template, must not hide a constant around it."""
    interfaces = tmp_path / Path(file).name
    text = (TREE / "tests" / "idl" / file).read_text()
    interfaces.write_text(text)
    generate(tmp_path / "before", "--lang", "cpp", interfaces)
    written = "".join(path.read_text() for path in (tmp_path / "before" / "cpp").glob("*"))
    taken = {word.lower() for word in re.findall(r"\w+", text)}
    names = sorted(
        set(re.findall(r"\b[a-z][a-z\d]*(?:_[a-z\d]+)*_?\b", written)) - taken - CPP_WORDS
    )
    assert "self" in names
    constants = "".join(f"const long _{name} = 1;\n" for name in names)
    interfaces.write_text(re.sub(r"(?m)^module \w+ \{", rf"\g<0>\n{constants}", text, count=1))
    generate(tmp_path, "--lang", "cpp", interfaces)
    sources = sorted((tmp_path / "cpp").glob("*.cpp"))
    compiles(tmp_path / "cpp", "".join(f'#include "{s.name}"\n' for s in sources))


@pytest.mark.parametrize("part", ["members", "types"])
def test_types_and_members_of_these_names_compile(folder: Path, part: str) -> None:
    sources = sorted(folder.glob(f"{part}_*.cpp"))
    assert len(sources) == 5
    compiles(folder, "".join(f'#include "{source.name}"\n' for source in sources))


def compiles(folder: Path, text: str) -> None:
    every = folder / "all.cpp"
    every.write_text(text)
    include = [f"-I{f}" for f in (folder, TREE / "generated" / "cpp", TREE / "runtime" / "cpp")]
    include += ["-isystem", "/usr/include/eigen3"]
    clang = [TREE / "tools/clang.sh", "-std=c++20", "-fsyntax-only", *WARNINGS]
    run = subprocess.run(
        [*clang, *include, every],
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr[:4000]


def mocked(interfaces: Path) -> Path:
    """Writes a mock server of `interfaces` and returns its source."""
    folder = interfaces.with_suffix(".mock")
    command = [sys.executable, "-m", "gidl", "new", "--mock", interfaces]
    command += ["--lang", "cpp", "--into", folder]
    subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": str(TREE / "codegen")})
    return folder / "server.cpp"


def distinct(words: Iterable[str]) -> list[str]:
    """Names that IDL takes, which compares without regard to case."""
    lower = {word.lower(): word for word in sorted(words) if word.lower() not in USED_BY_LOWER}
    return sorted(lower.values())


def test_names_of_system_headers_compile_behind_these_headers(tmp_path: Path) -> None:
    macros = distinct(CPP_WORDS - CPP)
    lines = [f"typedef long {name};" for name in distinct(CPP_TYPES.root_words - {"clock"})]
    lines += ["module clock { struct stat { long clock; }; };"]
    for first in range(0, len(macros), 100):
        some = macros[first : first + 100]
        lines += [f"module m{first} {{", "  struct Members {", *(f"    long {n};" for n in some)]
        lines += ["  };", "  enum Literals {", *(f"    {n}," for n in some), "    OTHER };", "};"]
    lines += ["interface Calls {", *(f"  long {n}(in long {n});" for n in macros[::20]), "};"]
    (tmp_path / "headers.gidl").write_text("\n".join(lines))
    generate(tmp_path, "--lang", "cpp", tmp_path / "headers.gidl")
    sources = sorted((tmp_path / "cpp").glob("*.cpp"))
    compiles(tmp_path / "cpp", source() + "".join(f'#include "{s.name}"\n' for s in sources))


def test_a_type_is_never_called_as_its_members(tmp_path: Path) -> None:
    (tmp_path / "same.gidl").write_text(
        """
        module same {
          struct value { long value_; };
          struct Below { long int_; };
          struct int : Below { long x; };
          union make_x switch (long) { case 1: long x; };
          union goto switch (long) { case 1: long goto_; };
          bitset class { bitfield<3> class_; };
          interface Site { void new_(); };
          interface new : Site { attribute long x; };
          interface set_x { attribute double x; };
        };
        module gecos { struct wire { long x; }; };
        module nlohmann { struct json { long x; }; };
        """
    )
    generate(tmp_path, "--lang", "cpp", tmp_path / "same.gidl")
    sources = sorted((tmp_path / "cpp").glob("*.cpp"))
    compiles(tmp_path / "cpp", "".join(f'#include "{s.name}"\n' for s in sources))


def test_the_arms_of_a_union_may_be_called_as_the_members_of_a_bitset(tmp_path: Path) -> None:
    (tmp_path / "packed.gidl").write_text(
        """
        module packed {
          struct Point { long x; };
          union Goal switch (boolean) { case TRUE: Point bits; case FALSE: string set_bits; };
          bitset Gap { bitfield<3> width; };
          interface Arm {
            void go(in Goal to, in sequence<Goal> via, in map<string, Goal> named, in Gap open);
          };
        };
        """
    )
    generate(tmp_path, "--lang", "cpp", tmp_path / "packed.gidl")
    compiles(
        tmp_path / "cpp",
        """
        #include "gecos/wire/layout.hpp"
        #include "packed_calls.hpp"
        gecos::Bytes sent(const packed::Arm_go_arguments& all) {
          return gecos::layout::to_bytes(all);
        }
        """,
    )


def test_a_parameter_is_not_called_as_a_constant_or_an_alias_around_its_interface(
    tmp_path: Path,
) -> None:
    (tmp_path / "around.gidl").write_text("const long depth = 1;\nconst long value = 2;\n")
    (tmp_path / "hidden.gidl").write_text(
        """
        #include "around.gidl"
        module lab {
          const long speed = 1;
          const long unix = 1;
          const long out_ = 1;
          const long self = 1;
          const long each = 1;
          typedef double angle;
          module arm {
            const long elsewhere = 1;
            interface Joint {
              void turn(in double speed, in double speed_, in long depth, inout long angle);
              void stop(out long speed, out double angle);
              @cancelable void go(in double angle);
              attribute long goal;
              void wait(in long unix, in float out_, in long out__, in long out___);
            };
          };
          interface Base { void move(in long elsewhere, in long value); };
          interface Shop : Base, arm::Joint {};
        };
        """
    )
    generate(tmp_path, "--lang", "cpp", tmp_path / "around.gidl", tmp_path / "hidden.gidl")
    mock = mocked(tmp_path / "hidden.gidl")
    client = " ".join((tmp_path / "cpp" / "hidden_client.hpp").read_text().split())
    assert "turn( double speed_, double speed__, std::int32_t depth_" in client
    assert "move(std::int32_t elsewhere, std::int32_t value)" in client
    assert "int32_t unix__, float out_, std::int32_t out___, std::int32_t out____" in client
    sources = sorted((tmp_path / "cpp").glob("*.cpp"))
    compiles(tmp_path / "cpp", "".join(f'#include "{s}"\n' for s in [*sources, mock]))


def test_a_parameter_may_be_called_as_a_class_of_its_interface(tmp_path: Path) -> None:
    (tmp_path / "alike.gidl").write_text(
        """
        module alike {
          interface Base {
            void go(in long _Object, in long Servant, in long Base, in long ArmServant);
            @cancelable void wait(in long _Object, in long BaseServant);
          };
          interface Arm : Base {
            void turn(in long Base, in long Arm, in long ArmServant, out double BaseServant);
            void _Object(out double Servant);
          };
        };
        """
    )
    generate(tmp_path, "--lang", "cpp", tmp_path / "alike.gidl")
    sources = sorted((tmp_path / "cpp").glob("*.cpp"))
    mock = mocked(tmp_path / "alike.gidl")
    compiles(tmp_path / "cpp", "".join(f'#include "{s}"\n' for s in [*sources, mock]))


# What a mock needs itself.
MOCKED = """
module mocked {
  struct np { long x; };
  enum Beat { SLOW, FAST };
  struct MockLamp { @range(min=1, max=3) long x; };
  @range(min=2, max=4) typedef double Half;
  typedef Half Halves[3][2];
  interface Mock { void mocks(in long mock_); void mock_streams(in long says, in string beats); };
  interface Shop : Mock {
    Halves range(in long held_clock_, in MockLamp got, out Beat mock_answer, inout long each_0);
    @sensor @stream(rate="10Hz") readonly attribute ::mocked::Beat beat;
    attribute MockLamp clock;
    void held_beat_(in map<string, long> Beat, in ::mocked::Beat run);
    @cancelable(feedback="mocked::MockLamp")
    void go(in string Publishing, in long mocks, @secret in string lab);
  };
};
module mocks { interface Shop { long x(); }; };
"""


def test_a_mock_of_whatever_names_compiles(tmp_path: Path) -> None:
    (tmp_path / "mocked.gidl").write_text(MOCKED)
    generate(tmp_path, "--lang", "cpp", tmp_path / "mocked.gidl")
    command = [sys.executable, "-m", "gidl", "new", "--mock", str(tmp_path / "mocked.gidl")]
    command += ["--lang", "cpp", "--into", str(tmp_path / "mock")]
    subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": str(TREE / "codegen")})
    compiles(tmp_path / "cpp", f'#include "{tmp_path}/mock/server.cpp"\n')


# Unions whose first arm is or contains an array that a mock has to fill.
CHOSEN = """
module chosen {
  union Numbers switch (long) { case 1: @min(1) long x[3]; case 2: string y; };
  struct Row { @min(2) double cells[2][3]; };
  union Rows switch (boolean) { case TRUE: Row first; };
  union Nested switch (long) { case 1: Rows inner[2]; };
  typedef Numbers Several[4];
  struct All { Numbers one; Several many; Nested deep[2]; };
  interface Chooser {
    @sensor Numbers chosen_numbers();
    @sensor Rows chosen_rows(out Nested inner, out All whole);
    @sensor Several chosen_several();
    readonly attribute Nested held;
    @cancelable(feedback="chosen::All") void go(in Numbers to);
  };
};
"""


def test_a_mock_fills_the_arrays_of_unions(tmp_path: Path) -> None:
    (tmp_path / "chosen.gidl").write_text(CHOSEN)
    generate(tmp_path, "--lang", "cpp", tmp_path / "chosen.gidl")
    mock = mocked(tmp_path / "chosen.gidl")
    filled = "for (auto& mock_value_each : std::get<1>(mock_value.value)) {"
    assert filled in mock.read_text()
    compiles(tmp_path / "cpp", f'#include "{mock}"\n')
