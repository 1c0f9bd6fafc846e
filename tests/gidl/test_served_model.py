"""The model that an object serves: whole, and the same in C++ and Python."""

from __future__ import annotations

import json
import re
from pathlib import Path

from gidl.compile import compile_files
from gidl.targets.emit import render
from gidl.targets.served_model import served_model
from gidl.wire.events import events_as_streams
from gidl.wire.wire_layout import build

TEXT = """
module lab {
  enum Unused { NO };
  enum Kind { SMALL, BIG };
  @range(min=0, max=1) typedef double Share;
  typedef sequence<Share, 4> Shares;
  struct Base { long id; };
  struct Tip : Base { Shares parts; };
  union Held switch (Kind) { case SMALL: Tip small; };
  bitset Low { bitfield<3> bits; };
  bitset Flags : Low { bitfield<2> more; };
  exception Broken { Flags which; };
  interface Store { void keep(); };
  struct Progress { double fraction; };
  /// It says "it's ready", and costs 3 €: \\\\ )json" ''' )json
  interface Arm : Store {
    attribute Held shown;
    @cancelable(feedback="lab::Progress") Store fetch(in map<string, long> places) raises (Broken);
  };
};
"""


def texts(tmp_path: Path) -> dict[str, str]:
    file = tmp_path / "arm.gidl"
    file.write_text(TEXT)
    compiled = compile_files([str(file)], [str(tmp_path)])
    assert not compiled.has_errors, compiled.findings
    model = events_as_streams(compiled.model)
    layout = build(model)
    found = {i.name: served_model(model, layout, i) for i in model.interfaces()}
    generated = render(model, layout, ["cpp", "python"])
    cpp, python = generated["cpp/arm_interface.cpp"], generated["python/arm.py"]
    assert re.findall(r'R"json\((.*?)\)json"', cpp, re.DOTALL) == list(found.values())
    module = compile(python, "arm.py", "exec")
    constants = [c for c in module.co_consts if isinstance(c, str) and c.startswith('{"interface"')]
    assert constants == list(found.values()), "as the languages read their literals"
    return found


def test_it_holds_all_types_that_the_members_use_and_no_other(tmp_path: Path) -> None:
    arm = json.loads(texts(tmp_path)["lab::Arm"])
    assert [t["name"].removeprefix("lab::") for t in arm["types"]] == [
        "Kind", "Share", "Shares", "Base", "Tip", "Held", "Low", "Flags", "Broken", "Progress",
    ]  # fmt: skip
    assert arm["references"] == ["lab::Store"]
    assert [m["name"] for m in arm["interface"]["members"]] == ["shown", "fetch"]


def test_a_base_has_a_text_of_its_own(tmp_path: Path) -> None:
    store = json.loads(texts(tmp_path)["lab::Store"])
    assert [m["name"] for m in store["interface"]["members"]] == ["keep"]
    assert (store["types"], store["references"]) == ([], [])


def test_quotes_and_other_alphabets_in_comments_arrive(tmp_path: Path) -> None:
    text = texts(tmp_path)["lab::Arm"]
    assert text.isascii()
    said = json.loads(text)["interface"]["doc"]
    assert said == "It says \"it's ready\", and costs 3 €: \\\\ )json\" ''' )json"
