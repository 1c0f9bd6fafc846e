"""Declarations of several files and modules that have the same name, and names that are the same
after escaping, are told apart."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from gecos import wire
from generating import TREE

ALIKE = TREE / "tests" / "idl" / "alike"

ESCAPED = """
module escaped {
  struct Words { long def; long def_; long int; long int_; long class; long class_; long self; };
  exception Errors { long args; long args_; string text; string text_; };
  enum Kinds { class, class_, name, name_, mro, mro_, value };
  bitmask Flags { real, imag, to_bytes };
  enum Numbers { numerator, denominator, bit_count, is_integer };
  union Arms switch (long) {
    case 1: long if; case 2: string if_; case 3: long make_if; case 4: long tag; case 5: long tag_;
  };
  struct bool_ { long x; };
  enum True_ { A, B };
  enum arm { LEFT, RIGHT };
  bitset key { bitfield<3> low; };
  struct Beside { long _True; escaped::True_ other; sequence<escaped::bool_> more; boolean bool; };
  union ByArm switch (escaped::arm) {
    case LEFT: escaped::key low[2]; case RIGHT: map<long, long> numbers;
  };
  struct print;
  typedef sequence<print> Prints;
  struct print { long x; Prints more; };
  @version("1.0") interface Calls {
    void with(in sequence<escaped::bool_> bool, in escaped::True_ _True);
    void delete(in long def, in long def_);
    void delete_(in long out_, in long source, in long self, in long cls);
    long lambda(in long lambda, out long lambda_);
    attribute long yield;
    attribute long yield_;
    void list(in sequence<long> several, in sequence<string> texts, @optional in long run);
    @cancelable void gecos_on_stop(in long run, in long run_);
    sequence<string> int(in sequence<string> texts, in map<string, long> numbers);
  };
};
"""

# What a mock needs itself.
MOCKED = """
module mocked {
  struct np { long x; };
  struct gecos { sequence<double> x; };
  enum Beat { SLOW, FAST };
  struct publish { long x; };
  struct main { @range(min=1, max=3) long x; };
  struct Callable { long x; };
  struct MockLamp { long x; };
  struct print { long x; };
  interface FirstShop { mocked::print show(in long much); };
  interface First_Shop {};
  struct time { long x; };
  @version("1.0") interface Lamp {
    double npt(in np np_, in gecos gecos_, in long print, in long range, in long bytes);
  };
};
module mocked {
  @range(min=2, max=4) typedef double Half;
  typedef Half Halves[3][2];
  typedef octet Key[4];
  typedef string Words[2];
  @version("1.0") interface Shop : Lamp {
    sequence<long> list(in long threading, in long contextlib, in long builtins);
    gecos mock_streams(in publish np, in Callable gecos, out main done, out time when);
    Halves range(in long range, in long np, in MockLamp MockShop, out Key bytes, out Words text);
    @sensor @stream(rate="10Hz") readonly attribute Beat stamp;
    attribute time clock;
    void dict(in map<string, long> int);
    string answer(in long result, inout long back);
    Beat pace(in double result);
  };
};
"""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("alike")
    (folder / "escaped.gidl").write_text(ESCAPED)
    (folder / "mocked.gidl").write_text(MOCKED)
    gidl = [sys.executable, "-m", "gidl"]
    environment = {**os.environ, "PYTHONPATH": str(TREE / "codegen")}
    files = [*sorted(ALIKE.rglob("*.gidl")), folder / "escaped.gidl", folder / "mocked.gidl"]
    for command in (
        ["gen", "--lang", "python", "--out", str(folder), *map(str, files)],
        ["new", "--mock", str(folder / "mocked.gidl"), "--into", str(folder / "mock")],
        ["new", "--mock", str(ALIKE / "both.gidl"), "--into", str(folder / "mock_both")],
    ):
        search = ["-I", str(ALIKE), "-I", str(folder), "-I", str(TREE / "idl")]
        subprocess.run([*gidl, *command, *search], check=True, env=environment)
    (folder / "mock" / "server.py").rename(folder / "python" / "mock_mocked.py")
    (folder / "mock_both" / "server.py").rename(folder / "python" / "mock_both.py")
    sys.path.insert(0, str(folder / "python"))
    yield folder
    sys.path.remove(str(folder / "python"))


def test_types_of_one_name_from_three_files_are_three(out: Path) -> None:
    left, right = import_module("left.state_types"), import_module("right.state_types")
    both = import_module("both_types")
    own = both.both_State(left.State.ON, right.State("a"), left.Pose(1.5), right.Pose(2))
    value = both.Three(own, [right.State("b")], {"c": left.State.ON})
    assert wire.from_bytes(both.Three, wire.to_bytes(value)) == value
    more = both.more_State(own)
    assert wire.from_bytes(both.more_State, wire.to_bytes(more)) == more
    either = both.Either(left.State.ON, right.Mode.FAST)
    assert wire.from_bytes(both.Either, wire.to_bytes(either)) == either


def test_servants_and_results_give_way_to_declared_types(out: Path) -> None:
    module = import_module("both")
    assert module.LampServant.__name__ == "LampServant"
    assert module.LampServant(1).x == 1
    assert issubclass(module.Lamp, import_module("left.state").Lamp)
    assert issubclass(module.LampServant_, import_module("right.state").LampServant)
    assert {"Lamp", "LampServant", "LampServant_", "Lamp_measure_result"} <= set(module.__all__)


def test_exceptions_of_one_name_are_read_as_what_they_are(out: Path) -> None:
    module = import_module("both")
    raised = module._LAMP_FAIL.raises
    assert [kind._gecos_name for kind in raised] == [
        "left::Failed",
        "right::Failed",
        "both::Failed",
    ]


def test_flags_of_a_constant_are_all_named_by_their_bitmask(out: Path) -> None:
    types = import_module("both_types")
    assert types.SOME is types.Marks.FIRST | types.Marks.SIXTH


def test_an_interface_may_have_nothing_but_a_base(out: Path) -> None:
    module = import_module("both")
    handlers = import_module("left.state").LampServant._gecos_handlers
    assert module.BareServant._gecos_handlers == handlers


def test_names_that_differ_in_an_underscore_stay_apart(out: Path) -> None:
    types = import_module("escaped_types")
    words = types.Words(1, 2, 3, 4, 5, 6, 7)
    assert (words.def_, words.def__, words.int_, words.int__) == (1, 2, 3, 4)
    assert wire.from_bytes(types.Words, wire.to_bytes(words)) == words
    assert [k.name for k in types.Kinds] == [
        "class_", "class__", "name_", "name__", "mro_", "mro__", "value_",
    ]  # fmt: skip
    made = types.Arms.make_if_(5)
    assert (made.if_, made.if__) == (5, None)
    assert types.Arms.make_make_if(7).make_if == 7
    assert types.Errors(1, 2, "a", "b").args__ == 2


def test_members_and_locals_do_not_hide_types(out: Path) -> None:
    types = import_module("escaped_types")
    for value in (
        types.Beside(True___=1, other=types.True__.B, more=[types.bool__(2)], bool___=True),
        types.ByArm.make_low([types.key(1), types.key(2)]),
        types.ByArm.make_numbers({1: 2}),
        types.print(1, [types.print(2)]),
    ):
        assert wire.from_bytes(type(value), wire.to_bytes(value)) == value


def test_all_of_it_can_be_imported_and_is_well_typed(out: Path, tmp_path: Path) -> None:
    for module in ("both", "escaped", "mocked", "mock_mocked", "mock_both"):
        import_module(module)
    roots = [TREE / "runtime" / "python", TREE / "generated" / "python", out / "python"]
    judged = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases",
         "--config-file", os.devnull, "--cache-dir", str(tmp_path), str(out / "python")],
        env={**os.environ, "MYPYPATH": os.pathsep.join(map(str, roots))},
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert judged.returncode == 0, judged.stdout + judged.stderr


def test_a_mock_answers_whatever_its_interface_calls_things(out: Path) -> None:
    mock: Any = import_module("mock_mocked")
    types = import_module("mocked_types")
    shop = mock.MockShop("SHOP")
    assert list(shop.list(1, 2, 3)) == []
    result = shop.mock_streams(types.publish(), types.Callable())
    assert result.done == types.main(1) or 1 <= result.done.x <= 3
    assert shop.range(1, 2, types.MockLamp()).result.shape == (3, 2)
    assert shop.npt(types.np(), types.gecos(), 1, 2, 3) == 0.0
    assert len(shop.mock_streams_()) == 1
    assert (shop.answer(1, 2).result, shop.answer(1, 2).back) == ("", 2)
    assert shop.pace(1.5) == types.Beat.SLOW
    assert mock.MockFirstShop("FIRST").show(1) == types.print(0)
