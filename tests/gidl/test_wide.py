"""`--wide=utf8` reads wide text as text; without it, it is refused."""

from pathlib import Path

from gidl.cli.main import main
from gidl.compile import Compiled, compile_files
from gidl.model import Constant, MapType, StringType, Struct, Typedef, Value

TEXT = r"""
typedef wstring Text;
struct Label { wstring long_one; wstring<5> short_one; wchar letter; map<wchar, wstring> names; };
const wstring GREETING = L"gr" L"\u00fc\u00df" "e";
const wstring<2> EUROS = L"\u20ac\u20ac";
const wchar EURO = L'\u20ac';
const wchar QUOTE = L'\'';
"""


def compiled(tmp_path: Path, text: str) -> Compiled:
    file = tmp_path / "a.idl"
    file.write_text(text, encoding="utf-8")
    return compile_files([str(file)], wide=True)


def constant(found: Compiled, name: str) -> Value:
    declaration = found.model.find(name)
    assert isinstance(declaration, Constant)
    return declaration.value


def test_wide_types_are_strings_with_room_for_every_character(tmp_path: Path) -> None:
    found = compiled(tmp_path, TEXT)
    assert found.findings == ()
    text = found.model.find("Text")
    assert isinstance(text, Typedef) and text.type == StringType()
    label = found.model.find("Label")
    assert isinstance(label, Struct)
    assert [m.type for m in label.members] == [
        StringType(),
        StringType(20),
        StringType(4),
        MapType(StringType(4), StringType()),
    ]


def test_wide_literals_are_text(tmp_path: Path) -> None:
    found = compiled(tmp_path, TEXT)
    values = [constant(found, name) for name in ("GREETING", "EUROS", "EURO", "QUOTE")]
    assert values == ["grüße", "€€", "€", "'"]


def test_what_does_not_fit_is_an_error(tmp_path: Path) -> None:
    found = compiled(tmp_path, "const wstring<1> A = L\"12345\"; const wchar B = L'12';")
    assert [f.code for f in found.findings] == ["G0301", "G0010"]


def test_every_verb_that_compiles_takes_the_option(tmp_path: Path) -> None:
    file = tmp_path / "a.gidl"
    file.write_text(TEXT)
    here = ["-I", str(tmp_path), str(file)]
    assert main(["check", *here]) == 100
    assert main(["check", "--wide=utf8", *here]) == 0
    assert main(["dump", "--wide=utf8", *here]) == 0
    assert main(["gen", "--wide=utf8", "--out", str(tmp_path / "out"), *here]) == 0
    against = ["--against", str(tmp_path)]
    assert main(["breaking", "--wide=utf8", *against, *here]) == 0
    assert main(["lint", "--wide=utf8", "--except", "G0910", *here]) == 0


def test_the_formatter_needs_no_option(tmp_path: Path) -> None:
    file = tmp_path / "a.idl"
    file.write_text('const  wstring A = L"x  y";\nstruct S { wchar  c ; };\n')
    assert main(["fmt", str(file)]) == 0
    assert file.read_text() == 'const wstring A = L"x  y";\nstruct S { wchar c; };\n'
