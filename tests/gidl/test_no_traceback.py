"""Whatever the input, there are findings and no traceback."""

import json
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.compile import Compiled, compile_files
from gidl.diagnostics.findings import as_json, as_text
from gidl.targets.model_json import model_text
from gidl.wire import hashes, wire_layout
from gidl.wire.events import events_as_streams
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

HERE = Path(__file__).parent
TEXTS = [
    p.read_text(encoding="utf-8")
    for folder in ("good", "bad")
    for p in sorted((HERE / folder).glob("*.gidl"))
]
WORDS = sorted({w for text in TEXTS for w in text.replace("(", " ( ").replace(")", " ) ").split()})
SETTINGS = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def compile_text(folder: Path, data: bytes) -> Compiled:
    file = folder / "some.gidl"
    file.write_bytes(data)
    compiled = compile_files([str(file)], [str(HERE.parents[1] / "idl")])
    assert as_text(list(compiled.findings), compiled.sources).count("error[") <= 100
    as_json(list(compiled.findings), compiled.sources)
    if not compiled.has_errors:
        model = events_as_streams(compiled.model)
        model_text(model, wire_layout.build(model), whole=True)
        for interface in compiled.model.interfaces():
            hashes.interface_hash(compiled.model, interface)
    return compiled


@SETTINGS
@given(st.binary(max_size=300))
def test_bytes(tmp_path: Path, data: bytes) -> None:
    compile_text(tmp_path, data)


@SETTINGS
@given(st.text(max_size=300))
def test_text(tmp_path: Path, text: str) -> None:
    compile_text(tmp_path, text.encode("utf-8", "replace"))


@SETTINGS
@given(st.lists(st.sampled_from(WORDS), max_size=80))
def test_words_of_the_language_in_any_order(tmp_path: Path, words: list[str]) -> None:
    compile_text(tmp_path, " ".join(words).encode())


@SETTINGS
@given(st.sampled_from(TEXTS), st.data())
def test_files_with_a_piece_cut_out_doubled_or_replaced(
    tmp_path: Path, text: str, data: st.DataObject
) -> None:
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 60)))
    instead = data.draw(st.sampled_from(["", text[start:end] * 2, *WORDS]))
    compile_text(tmp_path, (text[:start] + instead + text[end:]).encode())


@pytest.mark.parametrize(
    "text",
    [
        "module m {" * 5000,
        "const long X = " + "(" * 5000,
        "const long X = " + "-" * 5000 + "1;",
        "const long X = 1" + " + 1" * 50_000 + ";",
        "const long X = " + "1" * 500_000 + ";",  # in linear time
        "const double X = 1." + "1" * 500_000 + ";",
        "#define X " + '\\"' * 200_000 + "\n",
        "struct S { " + "sequence<" * 3000,
        "typedef " + "map<long, " * 1000,
        "@a" * 5000,
        "@a(" * 5000,
        "interface I { " * 3000,
        "}" * 5000,
        "/" * 5000,
        '"' * 5000,
        "#if " + "(" * 5000 + "\n#endif\n",
        "enum E { " + ", ".join(f"E{i}" for i in range(20_000)) + " };",
        "const string S = " + '"x" ' * 5000 + ";",
        "struct S { long a" + "[2]" * 3000 + "; };",
    ],
    ids=lambda t: t[:20],
)
def test_excess(tmp_path: Path, text: str) -> None:
    compile_text(tmp_path, text.encode())


def test_ten_megabytes_are_refused(tmp_path: Path) -> None:
    compiled = compile_text(tmp_path, b"struct S { double x; };\n" * 450_000)
    assert [f.code for f in compiled.findings] == ["G0011"]


def test_too_long_a_chain_of_declarations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "chain.gidl"
    types = "".join(f"typedef T{i} T{i + 1};\n" for i in range(600))
    file.write_text(f"typedef long T0;\n{types}struct S {{ T600 x; }};\n")
    command = ["--error-format", "json", str(file)]
    for verb in (["check"], ["gen", "--lang", "lcm", "--out", str(tmp_path / "made")]):
        assert main([*verb, *command]) == 100
        (found,) = json.loads(capsys.readouterr().out)
        assert (found["code"], found["line"]) == ("G0322", 65)


def test_too_long_a_chain_of_forward_declarations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "chain.gidl"
    declared = "".join(f"struct T{i};\n" for i in range(600))
    types = "".join(f"struct T{i} {{ sequence<T{i + 1}> x; }};\n" for i in range(599))
    file.write_text(f"{declared}{types}struct T599 {{ long x; }};\n")
    assert main(["check", str(file)]) == 100
    assert "chain.gidl:1136:8: error[G0322]: 'T535'" in capsys.readouterr().err
