"""When configure.sh runs CMake: a script in place of cmake notes what it is asked for."""

import subprocess
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]


class Machine:
    def __init__(self, folder: Path) -> None:
        self.programs = folder / "bin"
        self.programs.mkdir()
        self.log = folder / "log"
        self.build = folder / "build"
        self.build.mkdir()
        cmake = self.programs / "cmake"
        cmake.write_text(f'#!/bin/bash\necho "$@" >>{self.log}\ntouch {self.build}/build.ninja\n')
        cmake.chmod(0o755)

    def configure(self, *arguments: str, **environment: str) -> list[str]:
        """The arguments that CMake gets; none when it is not run."""
        self.log.write_text("")
        subprocess.run(
            [TREE / "tools/configure.sh", self.build, "RelWithDebInfo", *arguments],
            env={"PATH": f"{self.programs}:/usr/bin:/bin", **environment},
            check=True,
        )
        return self.log.read_text().split()


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_the_demo_after_the_tests_configures_nothing_anew(machine: Machine) -> None:
    assert "-DBUILD_TESTING=ON" in machine.configure("-DBUILD_TESTING=ON")
    assert machine.configure() == []
    assert machine.configure("-DBUILD_TESTING=ON") == []


def test_the_tests_after_the_demo_are_configured(machine: Machine) -> None:
    assert machine.configure()
    assert machine.configure() == []
    assert "-DBUILD_TESTING=ON" in machine.configure("-DBUILD_TESTING=ON")


def test_another_value_of_one_setting_is_configured(machine: Machine) -> None:
    machine.configure("-DGECOS_PROFILE=record")
    assert machine.configure("-DGECOS_PROFILE=use")
    assert machine.configure("-DGECOS_PROFILE=record")


@pytest.mark.parametrize(
    ("environment", "errors"),
    [({}, False), ({"CI": "true"}, True), ({"GECOS_WERROR": "ON"}, True),
     ({"CI": "true", "GECOS_WERROR": "OFF"}, False)],
)  # fmt: skip
def test_warnings_are_errors_in_continuous_integration_only(
    machine: Machine, environment: dict[str, str], errors: bool
) -> None:
    assert ("-DGECOS_WERROR=ON" in machine.configure(**environment)) == errors
