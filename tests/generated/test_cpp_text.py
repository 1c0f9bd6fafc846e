"""Generated C++ has no literal that compilers refuse, and no local that hides a constant."""

from __future__ import annotations

import re
from pathlib import Path

from gidl import wire_layout
from gidl.compile import compile_files
from gidl.emit import render


def sources(folder: Path, text: str) -> dict[str, str]:
    """The generated C++ of an interface file: name of a file -> text."""
    (folder / "x.gidl").write_text(text)
    compiled = compile_files([str(folder / "x.gidl")], [str(folder)])
    assert not compiled.has_errors, compiled.findings
    layout = wire_layout.build(compiled.model)
    texts = render(compiled.model, layout, ["cpp"])
    return {path.removeprefix("cpp/x_"): text for path, text in texts.items()}


def test_fields_of_any_width_are_read_with_literals_that_fit(tmp_path: Path) -> None:
    """9223372036854775808, which -2**63 would be written with, is too large for any signed type."""
    fields = [f"bitset B{n} {{ bitfield<{n}, int64> v; }};" for n in (40, 63, 64)]
    text = sources(tmp_path, "\n".join(fields))["types.cpp"]
    decimals = [int(number) for number in re.findall(r"\b[0-9]+\b(?!U)", text)]
    assert 2**62 in decimals
    assert max(decimals) < 2**63
    assert "v = static_cast<std::int64_t>((raw >> 0) & 0xffffffffffffffffU);" in text


# Members and parameters of these names make gidl choose other names for its own variables.
LOCALS = """
const long item = 1; typedef long row; const long key = 2; typedef string entry;
const long why = 3; const long size = 4; const long to = 5; const long from = 6;
const long value = 7; const long guard = 8; const long run = 9; const long call = 10;
const long read = 11;
struct Text { string t; };
struct All {
  sequence<string> item; sequence<sequence<string> > more; string row[2][3];
  map<string, map<string, Text> > key; string entry; Text why; string size; Text to; Text from;
};
struct Tree { sequence<Tree> guard; sequence<sequence<Text> > value; };
interface Calls {
  All get(in sequence<string> item, in string size, in string to, in string from, in Text value,
          in string call, in string read, out sequence<string> more);
  sequence<string> list(in sequence<string> value);
  @cancelable void go(in string run, in sequence<Text> call);
};
"""


def test_no_local_has_the_name_of_a_constant_or_typedef(tmp_path: Path) -> None:
    """A constant `item` is called `item_`; no variable of a body may be."""
    texts = sources(tmp_path, LOCALS)
    words = re.findall(r"\b(?:const|typedef) \w+ (\w+)", LOCALS)
    called = re.compile(rf"\b(?:{'|'.join(words)})_+\b")
    assert len(words) == 13
    assert {*called.findall(texts["types.hpp"])} == {f"{word}_" for word in words}
    for part in ("types.cpp", "client.cpp", "server.cpp"):
        assert not called.findall(texts[part]), part
        assert re.search(r"\b_(?:item|value|from)\b", texts[part]), part
