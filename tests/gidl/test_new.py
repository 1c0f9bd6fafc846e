"""`gidl new` writes a device whose files fit together; tests/system runs one."""

import ast
from pathlib import Path

import pytest
from gidl.cli import main


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_is_written_generates(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert main(["new", "thermometer"]) == 0
    folder = here / "thermometer"
    monkeypatch.chdir(folder)
    assert main(["gen", "-I", ".", "lab/thermometer.gidl"]) == 0
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
        "lab/gas_sensor.gidl",
        "server.py",
        "client.cpp",
        "CMakeLists.txt",
        "README.md",
    }
    texts = [p.read_text() for p in files]
    assert not any("${" in text and "Name}" in text for text in texts)
    assert 'gecos.serve({"GAS_SENSOR": MyGasSensor()}' in (here / "elsewhere/server.py").read_text()
    ast.parse((here / "elsewhere/server.py").read_text())


@pytest.mark.parametrize("name", ["", "9lives", "a b", "../x", "_x", "x_", "ünit"])
def test_a_name_that_is_none_is_refused(
    here: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", name]) == 2
    assert "is no name" in capsys.readouterr().err
    assert not any(here.iterdir())


@pytest.mark.parametrize("name", ["object", "reading", "lab", "import", "union", "port"])
def test_a_name_with_a_meaning_of_its_own_is_refused(
    here: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new", name]) == 2
    assert "has a meaning already" in capsys.readouterr().err
    assert not any(here.iterdir())


def test_a_folder_with_something_in_it_is_left_alone(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "lamp").mkdir()
    (here / "lamp" / "mine").write_text("mine")
    assert main(["new", "lamp"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert [p.name for p in (here / "lamp").iterdir()] == ["mine"]
