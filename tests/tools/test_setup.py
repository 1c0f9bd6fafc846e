"""What setup.sh does on machines that this one is not: its neighbours are played by scripts."""

import subprocess
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
FIRST = "build-essential"
ALL_BUT_TWO = """\
ii  build-essential
ii  clang-17
ii  omniidl
ii  cmake
ii  pkg-config
ii  python3
ii  python3-venv
ii  python3-dev:amd64
ii  libeigen3-dev
ii  liborocos-kdl-dev:amd64
ii  liburdfdom-dev:amd64
ii  libexpected-dev
ii  nlohmann-json3-dev
ii  libtomlplusplus-dev:amd64
ii  libsodium-dev:amd64
ii  libglib2.0-0t64:amd64
ii  libgtest-dev:amd64
ii  g++-s390x-linux-gnu
ii  qemu-user
ii  iproute2
rc  libbenchmark-dev:amd64
"""


class Machine:
    """A folder of programs that come before the real ones."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.installed("")
        self.user(1000)
        self.program("sudo", "exit 1")
        self.program("apt-get", f'echo "$@" >> {folder}/apt.log')

    def program(self, name: str, body: str) -> None:
        path = self.folder / name
        path.write_text(f"#!/bin/bash\n{body}\n")
        path.chmod(0o755)

    def installed(self, packages: str) -> None:
        (self.folder / "packages").write_text(packages.replace("ii  ", "ii "))
        self.program("dpkg-query", f"cat {self.folder}/packages")

    def user(self, number: int) -> None:
        self.program("id", f"echo {number}")

    def set_up(self, *parts: str) -> subprocess.CompletedProcess[str]:
        """Runs setup.sh up to the interpreter, which is one that it must refuse."""
        return subprocess.run(
            [TREE / "tools/setup.sh", *parts],
            env={"PATH": f"{self.folder}:/usr/bin:/bin", "GECOS_PYTHON": "/bin/false"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=30,
        )

    def apt_calls(self) -> list[str]:
        log = self.folder / "apt.log"
        return log.read_text().splitlines() if log.exists() else []


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_who_may_not_install_is_told_the_command(machine: Machine) -> None:
    machine.installed(ALL_BUT_TWO)
    done = machine.set_up()
    assert done.returncode == 1
    assert (
        "apt-get update && apt-get install -y --no-install-recommends ninja-build libbenchmark-dev"
        in done.stderr
    )
    assert machine.apt_calls() == []


def test_root_installs_what_is_missing_and_nothing_else(machine: Machine) -> None:
    machine.installed(ALL_BUT_TWO)
    machine.user(0)
    machine.set_up()
    assert machine.apt_calls() == [
        "update -q",
        "install -y --no-install-recommends ninja-build libbenchmark-dev",
    ]


def test_each_step_is_said_before_it_is_done(machine: Machine) -> None:
    machine.installed(ALL_BUT_TWO)
    machine.user(0)
    machine.program("apt-get", 'echo "(apt-get $1)"')
    assert machine.set_up().stdout.splitlines() == [
        "setup: apt-get update",
        "(apt-get update)",
        "setup: apt-get install ninja-build libbenchmark-dev (minutes on a fresh machine)",
        "(apt-get install)",
    ]


def test_sudo_that_asks_nothing_is_used(machine: Machine) -> None:
    machine.installed(ALL_BUT_TWO)
    machine.program("sudo", '[ "$1" = -n ] && exit 0; exec "$@"')
    machine.set_up()
    assert len(machine.apt_calls()) == 2


def test_with_everything_there_apt_is_left_alone(machine: Machine) -> None:
    machine.user(0)
    machine.installed(
        ALL_BUT_TWO.replace("rc  libbenchmark", "ii  libbenchmark") + "ii  ninja-build\n"
    )
    assert machine.set_up().stdout == ""
    assert machine.apt_calls() == []


def test_an_interpreter_that_is_too_old_is_refused_with_the_setting(machine: Machine) -> None:
    machine.user(0)
    done = machine.set_up()
    assert done.returncode == 1
    assert "GECOS_PYTHON=/path/to/python3 make setup" in done.stderr


def test_a_machine_without_dpkg_is_told_what_it_needs(machine: Machine) -> None:
    machine.program("dpkg-query", "exit 127")
    done = machine.set_up()
    assert done.returncode == 1
    assert "knows Debian 12, Debian 13 and Ubuntu 24.04" in done.stderr
    assert FIRST in done.stderr


TEST_TOOLING = {"libgtest-dev", "libbenchmark-dev", "clang", "omniidl", "qemu-user"}


def test_the_demo_needs_no_test_tooling(machine: Machine) -> None:
    machine.user(0)
    machine.set_up("build")
    installed = set(machine.apt_calls()[1].split())
    assert {"build-essential", "libglib2.0-0", "python3-dev"} <= installed
    assert not TEST_TOOLING & installed
    assert not [name for name in installed if "s390x" in name or "clang" in name]


def test_everything_of_the_tests_is_installed_where_no_part_is_named(machine: Machine) -> None:
    machine.user(0)
    machine.set_up()
    assert set(machine.apt_calls()[1].split()) >= TEST_TOOLING


def test_formatting_needs_no_compiler(machine: Machine) -> None:
    machine.user(0)
    machine.set_up("format")
    assert machine.apt_calls()[1].split()[3:] == ["python3", "python3-venv"]


def test_fuzzing_needs_the_runtime_of_the_very_clang_that_is_there(machine: Machine) -> None:
    machine.user(0)
    machine.installed(ALL_BUT_TWO + "ii  ninja-build\n")
    machine.program("clang++", "echo 17.0.6")
    machine.set_up("fuzz")
    assert machine.apt_calls() == [
        "update -q",
        "install -y --no-install-recommends libclang-rt-17-dev",
    ]


def test_a_part_that_does_not_exist_is_refused_with_those_that_do(machine: Machine) -> None:
    done = machine.set_up("tset")
    assert done.returncode == 2
    assert "there is no tset; name any of gidl, build, tests" in done.stderr
