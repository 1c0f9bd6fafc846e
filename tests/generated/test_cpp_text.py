"""Generated C++ has no literal that compilers refuse, no local that hides a constant, and no
operation that hides a member of its base classes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from gecos.proxy import Object
from gecos.servant import Servant
from generating import TREE
from gidl.compile import compile_files
from gidl.targets.cpp import names as cpp
from gidl.targets.emit import render
from gidl.targets.python import names as python
from gidl.wire import wire_layout


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


@pytest.mark.parametrize("first", ["A", "B"])
def test_structs_that_contain_each_other_are_checked_before_they_are_sent(
    first: str, tmp_path: Path
) -> None:
    """Only A has a member that can be wrong. Whichever struct is declared first, a B that contains
    such an A is refused."""
    structs = {
        "A": "struct A { sequence<B> bs; @range(min=0, max=1) double x; };",
        "B": "struct B { sequence<A> parts; };",
    }
    last = "B" if first == "A" else "A"
    calls = "interface I { @actor void f(in B whole); };"
    text = f"struct A; struct B; {structs[first]} {structs[last]} {calls}"
    types = sources(tmp_path, text)["types.cpp"]
    for name in structs:
        body = types.partition(f"gecos_violation(const {name}& value) {{\n")[2]
        assert "gecos_violation(item)" in body.partition("\n}\n")[0]


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


def members_of_bases() -> set[str]:
    """What the base classes of proxies and servants, and those classes themselves, declare."""
    found: set[str] = set()
    for header, name in (("object", "Object"), ("servant", "Servant")):
        text = (TREE / "runtime/cpp/gecos" / f"{header}.hpp").read_text()
        body = text.partition(f"\nclass {name} {{\n")[2].partition("\n};\n")[0]
        assert body
        body = re.sub("//.*", "", body)
        found |= set(re.findall(r"\bgecos_\w+", body))
        for line in body.splitlines():
            if not line.startswith(("  friend ", "   ")):
                found |= set(re.findall(r"(?<![~:.>\w])([a-z]\w*)\((?!\*)", line))
    templates = TREE / "codegen/gidl/targets/cpp/templates"
    for template in ("client.hpp.j2", "server.hpp.j2"):
        found |= set(re.findall(r"\b(gecos_\w+)\(", (templates / template).read_text()))
    return found - {"requires"}


def test_members_of_the_base_classes_are_no_names_of_operations() -> None:
    found = members_of_bases()
    assert {"gecos_call", "gecos_subscribe", "gecos_publish", "gecos_description"} <= found
    assert {name for name in found if not name.startswith("gecos_")} == set()
    for name in sorted(found):
        assert cpp.method_name(name) not in found | {name}
    assert len({cpp.method_name(name) for name in found}) == len(found)


def test_members_of_the_base_classes_are_no_names_of_operations_in_python() -> None:
    found = {n for base in (Object, Servant) for n in dir(base) if not n.startswith("_")}
    assert found
    for name in sorted(found):
        assert python.method_name(name) not in found


def test_operations_and_parameters_are_called_beside_those_members(tmp_path: Path) -> None:
    texts = sources(
        tmp_path,
        "interface I { void gecos_call(in double gecos_session_, in double gecos_publish); };"
        " interface gecos_subscribe { void f(); };",
    )
    head = "gecos_call_(double gecos_session__, double gecos_publish_) const"
    assert f"gecos::Command<void> I::{head} {{" in texts["client.cpp"]
    assert "return gecos_call<void>(" in texts["client.cpp"]
    assert "this->gecos_call_(gecos_session__, gecos_publish_)" in texts["server.cpp"]
    assert "class gecos_subscribe_ : public virtual gecos::Object" in texts["client.hpp"]


def test_a_name_longer_than_a_line_is_printed(tmp_path: Path) -> None:
    name, member = "L" + 50 * "o" + "ng", "m" + 50 * "e"
    files = sources(tmp_path, f"struct {name} {{ double {member}; double b; }};")
    (printing,) = re.findall(r"print_all\(out,\s*(.)", files["types.cpp"])
    assert printing == '"'
