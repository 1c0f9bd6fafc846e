"""Generated C++ has no literal that compilers refuse, and no local that hides a constant."""

from __future__ import annotations

import re
from pathlib import Path

from gidl import wire_layout
from gidl.compile import compile_files
from gidl.emit import render


def types_source(folder: Path, text: str) -> str:
    """The generated x_types.cpp of an interface file."""
    (folder / "x.gidl").write_text(text)
    compiled = compile_files([str(folder / "x.gidl")], [str(folder)])
    assert not compiled.has_errors, compiled.findings
    layout = wire_layout.build(compiled.model)
    return render(compiled.model, layout, ["cpp"])["cpp/x_types.cpp"]


def test_fields_of_any_width_are_read_with_literals_that_fit(tmp_path: Path) -> None:
    """9223372036854775808, which -2**63 would be written with, is too large for any signed type."""
    fields = [f"bitset B{n} {{ bitfield<{n}, int64> v; }};" for n in (40, 63, 64)]
    text = types_source(tmp_path, "\n".join(fields))
    decimals = [int(number) for number in re.findall(r"\b[0-9]+\b(?!U)", text)]
    assert 2**62 in decimals
    assert max(decimals) < 2**63
    assert "v = static_cast<std::int64_t>((raw >> 0) & 0xffffffffffffffffU);" in text
