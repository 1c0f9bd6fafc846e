"""`gidl new` writes a device whose files fit together; tests/system runs one."""

import ast
import re
from pathlib import Path

import pytest
from gidl.cli.main import main
from gidl.files.names import python_module


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_is_written_generates(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["new", "thermometer"]) == 0
    folder = here / "thermometer"
    monkeypatch.chdir(folder)
    assert main(["gen"]) == 0
    assert {p.name for p in (folder / "generated").iterdir()} == {"python"}
    assert main(["gen", "--lang", "cpp,python"]) == 0
    generated = folder / "generated"
    header = (generated / "cpp/lab/thermometer_client.hpp").read_text()
    assert "class Thermometer" in header
    module = ast.parse((generated / "python/lab/thermometer.py").read_text())
    classes = {node.name for node in ast.walk(module) if isinstance(node, ast.ClassDef)}
    assert "ThermometerServant" in classes
    types = (generated / "python/lab/thermometer_types.py").read_text()
    assert "ThermometerFault" in types


def test_every_name_of_the_template_is_filled_in(here: Path) -> None:
    assert main(["new", "Gas-Sensor", "--into", "elsewhere"]) == 0
    files = [p for p in (here / "elsewhere").rglob("*") if p.is_file()]
    assert {p.relative_to(here / "elsewhere").as_posix() for p in files} == {
        "idl/lab/gas_sensor.gidl",
        "gidl.toml",
        "server.py",
        "client.cpp",
        "CMakeLists.txt",
        "README.md",
    }
    texts = [p.read_text() for p in files]
    assert not any("${" in text and "Name}" in text for text in texts)
    assert 'gecos.serve({"GAS_SENSOR": device}' in (here / "elsewhere/server.py").read_text()
    ast.parse((here / "elsewhere/server.py").read_text())


@pytest.mark.parametrize("name", ["", "9lives", "a b", "../x", "_x", "x_", "ünit"])
def test_a_name_that_is_none_is_refused(
    here: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", name]) == 2
    assert "is not a valid name" in capsys.readouterr().err
    assert not any(here.iterdir())


@pytest.mark.parametrize("name", ["object", "reading", "lab", "import", "union", "port"])
def test_a_name_with_a_meaning_of_its_own_is_refused(
    here: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", name]) == 2
    assert "is reserved or already declared" in capsys.readouterr().err
    assert not any(here.iterdir())


def test_a_folder_with_something_in_it_is_left_alone(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "lamp").mkdir()
    (here / "lamp" / "mine").write_text("mine")
    assert main(["new", "lamp"]) == 2
    assert "exists already" in capsys.readouterr().err
    assert [p.name for p in (here / "lamp").iterdir()] == ["mine"]


WELL = """\
module lab {
  interface Pump {
    @sensor @stream(rate="20Hz") @range(min=2, max=4) readonly attribute double flow;
  };
  interface Valve { @actor void open(in boolean wide); };
};
"""


@pytest.fixture
def well(here: Path) -> Path:
    (here / "lab").mkdir()
    (here / "lab" / "well.gidl").write_text(WELL)
    return here / "lab" / "well.gidl"


def classes_of(server: Path) -> set[str]:
    tree = ast.parse(server.read_text())
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}


def test_a_mock_stands_in_for_every_interface_of_a_file(here: Path, well: Path) -> None:
    assert main(["new", "--mock", "lab/well.gidl", "-I", "."]) == 0
    assert classes_of(here / "well_mock" / "server.py") == {"Beat", "MockPump", "MockValve"}
    text = (here / "well_mock" / "server.py").read_text()
    assert "self._held_flow: float = 3.0" in text
    assert "Beat(50000000, " in text


@pytest.mark.parametrize("name", ["my well-pump.idl", "types.gidl", "2fast.gidl"])
def test_a_mock_of_a_file_of_any_name_imports_its_module(
    here: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "lab").mkdir()
    (here / "lab" / name).write_text(WELL)
    for language in ("python", "cpp"):
        words = ["--lang", language, "--into", language]
        assert main(["new", "--mock", f"lab/{name}", "-I", "lab", *words]) == 0
    tree = ast.parse((here / "python" / "server.py").read_text())
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert python_module(name) in imported
    project = (here / "cpp" / "CMakeLists.txt").read_text()
    assert re.search(r"^project\(\w+ CXX\)$", project, re.MULTILINE)


@pytest.mark.parametrize("wanted", ["Valve", "lab::Valve"])
def test_or_for_the_one_that_is_named(here: Path, well: Path, wanted: str) -> None:
    words = ["--lang", "cpp", "--into", "valve", "--interface", wanted]
    assert main(["new", "--mock", "lab/well.gidl", "-I", ".", *words]) == 0
    text = (here / "valve" / "server.cpp").read_text()
    assert "class MockValve" in text and "class MockPump" not in text
    assert "Publishing" not in text
    cmake = (here / "valve" / "CMakeLists.txt").read_text()
    assert f'gidl_generate(well_interface "{well}" ROOT "{here}"' in cmake


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["--mock", "lab/well.gidl", "--interface", "Tap"], 2, "there is lab::Pump, lab::Valve"),
        (["--mock", "lab/none.gidl"], 100, "cannot be read"),
        (["--mock", "-"], 2, "or --mock and a file"),
        (["tap", "--mock", "lab/well.gidl"], 2, "for example thermometer, or --mock"),
        ([], 2, "for example thermometer, or --mock"),
        (["--mock", "types.gidl"], 2, "declares no interface to mock"),
        (["--mock", "lab/well.gidl", "--into", "lab"], 2, "exists already"),
    ],
)
def test_what_cannot_be_mocked_is_refused(
    here: Path,
    well: Path,
    words: list[str],
    status: int,
    said: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (here / "types.gidl").write_text("struct S { long x; };\n")
    assert main(["new", *words]) == status
    assert said in capsys.readouterr().err
    assert {p.name for p in here.iterdir()} == {"lab", "types.gidl"}
