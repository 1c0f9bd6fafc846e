"""Every generated header can be included alone: the build compiles it so, as the first thing of
its own source, and it brings what it names instead of relying on what others bring."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]

BROUGHT_BY = {
    "array": "array", "map": "map", "optional": "optional", "shared_ptr": "memory",
    "string": "string", "string_view": "string_view", "variant": "variant", "vector": "vector",
    "int8_t": "cstdint", "int16_t": "cstdint", "int32_t": "cstdint", "int64_t": "cstdint",
    "uint8_t": "cstdint", "uint16_t": "cstdint", "uint32_t": "cstdint", "uint64_t": "cstdint",
    "numeric_limits": "limits", "size_t": "cstddef", "ostream": "iosfwd", "monostate": "variant",
    "in_place_index": "variant", "get_if": "variant", "move": "utility",
}  # fmt: skip

# Anonymous types that stand in calls alone, so that no type's header names them.
CALLS_ALONE = """
module alone {
  interface Store {
    @sensor map<string, sequence<double>> read(in map<char, boolean> where, @optional in octet how);
    @sensor @stream(rate="1Hz") readonly attribute sequence<map<int16, string>> log;
    @actor attribute sequence<uint8> raw;
  };
};
"""


def generate(out: Path, *files: Path) -> None:
    roots = (out.parent, TREE / "tests/idl/workshop", TREE / "tests/idl", TREE / "idl")
    search = [word for root in roots for word in ("-I", str(root))]
    command = [sys.executable, "-m", "gidl", "gen", "--lang", "cpp", *search, "--out", str(out)]
    subprocess.run([*command, *map(str, files)], check=True, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="session")
def generated(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Folders of C++: that of idl/, that of the tests' interfaces, one that is hard."""
    out = tmp_path_factory.mktemp("headers")
    own = TREE / "tests" / "idl"
    generate(out / "tests", own / "everything.gidl", own / "workshop" / "workshop.gidl")
    (out / "alone.gidl").write_text(CALLS_ALONE)
    generate(out / "alone", out / "alone.gidl")
    return [TREE / "generated" / "cpp", out / "tests" / "cpp", out / "alone" / "cpp"]


def test_a_header_includes_what_it_names(generated: list[Path]) -> None:
    missing = []
    for header in (h for folder in generated for h in folder.rglob("*.hpp")):
        text = re.sub(r"//.*", "", header.read_text())
        included = set(re.findall(r"#include <(\w+)>", text))
        named = set(re.findall(r"\bstd::(\w+)", text))
        assert named <= BROUGHT_BY.keys(), (
            f"{header}: say here what brings {named - set(BROUGHT_BY)}"
        )
        missing += [
            f"{header}: std::{name} without <{BROUGHT_BY[name]}>"
            for name in sorted(named)
            if BROUGHT_BY[name] not in included
        ]
    assert missing == []


def test_a_header_stands_first_in_its_own_source(generated: list[Path]) -> None:
    sources = [s for folder in generated for s in folder.rglob("*.cpp")]
    assert len(sources) > 40
    for source in sources:
        first = re.search(r'#include [<"]([^>"]+)[>"]', source.read_text())
        assert first is not None and first[1].rpartition("/")[2] == f"{source.stem}.hpp", source
