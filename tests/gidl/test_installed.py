"""Interfaces that an installed package brings are found without a folder named for them."""

from pathlib import Path

import pytest
from gidl.cli.main import main

USES_IT = '#include "acme/arm.gidl"\nmodule shop { struct Two { acme::Joint left, right; }; };\n'


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project whose virtual environment, inside of it, has the package acme."""
    site = tmp_path / "env" / "site-packages"
    idl = site / "acme_interfaces" / "idl" / "acme"
    idl.mkdir(parents=True)
    (idl / "joint.gidl").write_text("module acme { struct Joint { double angle; }; };\n")
    (idl / "arm.gidl").write_text('#pragma once\n#include "acme/joint.gidl"\n')
    info = site / "acme-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme\nVersion: 1\n")
    (info / "entry_points.txt").write_text(
        "[gidl.interfaces]\nacme = acme_interfaces.idl\nremoved = acme_gone.idl\n"
    )
    (tmp_path / "shop.gidl").write_text(USES_IT)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(site)
    return tmp_path


def generated(*words: str) -> str:
    assert main(["gen", "--lang", "cpp", "--out", "out", *words, "shop.gidl"]) == 0
    return Path("out/cpp/shop_types.hpp").read_text()


@pytest.mark.parametrize("words", [(), ("-I", ".")])
def test_they_are_included_by_the_name_that_the_package_gives_them(
    here: Path, words: tuple[str, ...]
) -> None:
    assert '#include "acme/arm_types.hpp"' in generated(*words)


def test_a_folder_that_is_named_comes_first(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "idl" / "acme").mkdir(parents=True)
    (here / "idl/acme/arm.gidl").write_text("module acme { struct Joint { float degrees; }; };\n")
    assert main(["dump", "--whole", "-I", "idl", "shop.gidl"]) == 0
    assert "degrees" in capsys.readouterr().out


def test_what_no_package_has_is_not_found(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "shop.gidl").write_text('#include "acme/leg.gidl"\n')
    assert main(["check", "shop.gidl"]) == 100
    assert "there is no file 'acme/leg.gidl'" in capsys.readouterr().err
