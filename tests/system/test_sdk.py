"""What `cmake --install` gives, moved elsewhere and used where nothing of the tree is seen."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import radians
from pathlib import Path

import gecos
import pytest
from processes import Laboratory, until
from robcl.frames import mm, translate
from robcl.manipulator import Trajectory
from robcl.six_axis import SixAxis
from without_tree import TREE, without_tree

PROJECTS = ("own_project", "own_arm")
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
SAID = ["not above 500 K", "it is at 400 K"]


def checked(*command: str | Path, env: Mapping[str, str] | None = None) -> str:
    done = subprocess.run(
        command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=500
    )
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}"
    return done.stdout


@dataclass(frozen=True, slots=True)
class User:
    """Somebody who has the SDK, the example projects and an interpreter with jinja2 and numpy."""

    folder: Path

    @property
    def sdk(self) -> Path:
        return self.folder / "opt" / "robcl"

    @property
    def project(self) -> Path:
        return self.folder / "own_project"

    @property
    def env(self) -> dict[str, str]:
        packages = [self.sdk / "lib/robcl/python", self.project / "generated/python"]
        return {
            **os.environ,
            "PATH": f"{self.folder}/env/bin:{os.environ['PATH']}",
            "VIRTUAL_ENV": f"{self.folder}/env",
            "PYTHONPATH": ":".join(map(str, packages)),
        }

    def unseen(self, *command: str | Path) -> Sequence[str | Path]:
        """The command, where the tree is an empty folder."""
        return (*without_tree(self.folder / "packages"), *command)

    def run(self, *command: str | Path) -> str:
        return checked(*self.unseen(*command), env=self.env)

    def build(self, name: str, *options: str, project: str = "own_project") -> None:
        folder = self.folder / name
        words = ["-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.sdk}", *options]
        if shutil.which("ccache"):
            words.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
        self.run("cmake", "-S", self.folder / project, "-B", folder, *words)
        self.run("cmake", "--build", folder)


@pytest.fixture(scope="module")
def user(build: Path) -> Iterator[User]:
    """The SDK was installed by somebody else, into a folder that is no more."""
    with tempfile.TemporaryDirectory(prefix="sdk-") as name:
        user = User(Path(name))
        checked("cmake", "--install", build, "--prefix", user.folder / "installed")
        user.sdk.parent.mkdir()
        (user.folder / "installed").rename(user.sdk)
        for project in PROJECTS:
            shutil.copytree(TREE / "examples" / project, user.folder / project)
        checked(sys.executable, "-m", "venv", "--without-pip", "--symlinks", user.folder / "env")
        (user.folder / "packages").mkdir()
        site = next((user.folder / "env/lib").glob("python3*/site-packages"))
        (site / "borrowed.pth").write_text(f"{user.folder}/packages\n")
        yield user


@pytest.fixture
def meeting(lab: Laboratory, user: User) -> Laboratory:
    """A laboratory whose programs are the user's."""
    lab.env.update(user.env)
    lab.start(*user.unseen(user.sdk / "bin/gecos-broker"), ready="ready")
    return lab


def says(lab: Laboratory, user: User, *client: str | Path) -> list[str]:
    told = lab.run(*user.unseen(*client))
    assert told.finish() == 0, str(told)
    return told.lines


def test_the_user_does_not_see_the_tree(user: User) -> None:
    assert user.run("ls", "-A", TREE) == ""
    assert user.run("python", "-c", "import gecos; print(gecos.__file__)").startswith(str(user.sdk))


def test_nothing_installed_names_the_tree_or_the_folder_of_the_installation(user: User) -> None:
    for file in user.sdk.rglob("*"):
        data = file.read_bytes() if file.is_file() else b""
        if data.startswith((b"\x7fELF", b"!<arch>")):
            continue  # whose debug information names the sources
        for place in (TREE, user.folder / "installed"):
            assert str(place).encode() not in data, file


def test_what_installed_headers_include_is_installed_and_no_inner_header_is(user: User) -> None:
    include = user.sdk / "include"
    headers = {path.relative_to(include).as_posix(): path for path in include.rglob("*.hpp")}
    assert "gecos/gecos.hpp" in headers
    for header, path in headers.items():
        assert set(INCLUDE.findall(path.read_text())) <= headers.keys(), header
    inner = ("gecos/session/", "gecos/broker/", "gecos/crypto/", "gecos/binding.hpp")
    not_of_arms = ("devices/support/", "devices/world/", "devices/gripper/")
    shown_by_an_arm = {"devices/support/lab_clock.hpp"}
    found = {header for header in headers if header.startswith(inner + not_of_arms)}
    assert found == shown_by_an_arm


def test_gecos_up_starts_the_simulated_laboratory(lab: Laboratory, user: User) -> None:
    lab.env.update({name: value for name, value in user.env.items() if name != "PYTHONPATH"})
    lab.env.pop("PYTHONPATH", None)
    lab.start(*user.unseen(user.sdk / "bin/gecos"), "up", ready="WORLD, RX90, GRIPPER, LDS are")
    assert "GRIPPER" in user_lists(lab, user)


def test_an_installed_arm_of_two_files_is_served(user: User, meeting: Laboratory) -> None:
    words = (user.sdk / "bin/robcl-arm", user.sdk / "share/robcl/arms/iiwa14.toml")
    meeting.start(*user.unseen(*words), ready="IIWA14 is ready")
    assert "robcl::ArticulatedArm" in user_lists(meeting, user)


@pytest.mark.timeout(600)
def test_a_project_in_cpp_and_python(user: User, meeting: Laboratory) -> None:
    user.build("plain")
    user.run("sh", "-c", f"cd {user.project} && {user.sdk}/bin/gidl gen")
    client, server = user.folder / "plain/client", user.folder / "plain/server"
    in_cpp = meeting.start(*user.unseen(server), ready="OVEN is ready")
    assert says(meeting, user, client) == SAID
    assert says(meeting, user, "python", user.project / "client.py") == SAID
    assert "OVEN" in user_lists(meeting, user)
    assert in_cpp.terminate() == 0, str(in_cpp)
    meeting.start(*user.unseen("python", user.project / "server.py"), ready="OVEN")
    assert says(meeting, user, client) == SAID


def user_lists(lab: Laboratory, user: User) -> str:
    return "\n".join(says(lab, user, user.sdk / "bin/gecos", "ls"))


@pytest.mark.timeout(600)
def test_a_project_under_asan_and_one_compiled_by_clang(user: User, meeting: Laboratory) -> None:
    clang = checked(TREE / "tools/clang.sh").strip()
    user.build("asan", "-DCMAKE_CXX_FLAGS=-fsanitize=address,undefined -fno-sanitize-recover=all")
    user.build("clang", f"-DCMAKE_CXX_COMPILER={clang}")
    asan, other = user.folder / "asan", user.folder / "clang"
    server = meeting.start(*user.unseen(asan / "server"), ready="OVEN is ready")
    assert says(meeting, user, asan / "client") == SAID
    assert says(meeting, user, other / "client") == SAID
    assert server.terminate() == 0, str(server)
    meeting.start(*user.unseen(other / "server"), ready="OVEN is ready")
    assert says(meeting, user, asan / "client") == SAID


@dataclass(frozen=True, slots=True)
class Drives:
    """The drives of examples/own_arm: what they received, and their emergency stop."""

    folder: Path

    def set_points(self) -> list[list[float]]:
        lines = (self.folder / "set_points.txt").read_text().splitlines(keepends=True)
        return [[float(word) for word in line.split()] for line in lines if line.endswith("\n")]

    @property
    def emergency_stop(self) -> Path:
        return self.folder / "emergency_stop"


@pytest.fixture
def bench(user: User, meeting: Laboratory) -> Drives:
    """The arm of examples/own_arm is served."""
    user.build("own_arm_built", project="own_arm")
    folder = user.folder / "drives"
    folder.mkdir(exist_ok=True)
    words = (folder, user.folder / "own_arm_built/bench-arm", user.folder / "own_arm/bench.toml")
    in_folder = ("sh", "-euc", 'cd "$1"; exec "$2" "$3"', "sh", *words)
    meeting.start(*user.unseen(*in_folder), ready="bench-arm: BENCH is ready")
    return Drives(folder)


@pytest.mark.timeout(600)
def test_an_arm_with_drives_of_its_own_has_no_fast_clock(user: User, meeting: Laboratory) -> None:
    user.build("own_arm_built", project="own_arm")
    program, arm = user.folder / "own_arm_built/bench-arm", user.folder / "own_arm/bench.toml"
    refused = meeting.run(*user.unseen(program, arm, "--clock", "10"))
    assert refused.finish() == 2, str(refused)
    assert refused.lines[0] == (
        "bench-arm: '--clock' is 10, but the joints of BENCH are real; only simulated devices have "
        "another clock than 1"
    )


@pytest.mark.timeout(600)
@pytest.mark.usefixtures("here")
def test_an_arm_with_drives_of_its_own(user: User, meeting: Laboratory, bench: Drives) -> None:
    moved = says(meeting, user, "python", user.folder / "own_arm/move_aside.py")
    assert moved == ["the tool is 100 mm aside"]
    arm = gecos.Lab().create(SixAxis, "BENCH")
    received = bench.set_points()
    assert received[-1] == pytest.approx(list(arm.commanded_joints().result().position), abs=1e-8)
    fastest = [2, 2, 2.5, 4, 4, 6]  # rad/s, in bench.urdf
    for before, after in pairwise(received):
        steps = [abs(one - other) for one, other in zip(before, after, strict=True)]
        assert all(step <= 1.001 * v * 0.004 for step, v in zip(steps, fastest, strict=True))

    with gecos.actor(arm):
        goal = arm.tool().result() * translate(0.0, mm(-200), 0.0)
        moving = arm.move(goal, Trajectory(speed=0.05))
        until(lambda: len(bench.set_points()) > len(received) + 10, "the arm moves")
        bench.emergency_stop.touch()
        fault = "the drives have a fault: the emergency stop is pressed"
        with pytest.raises(gecos.CommandFailed, match=fault):
            moving.result()
        received = bench.set_points()
    reset_and_turn = user.folder / "own_arm_built/reset_and_turn"
    pressed = meeting.run(*user.unseen(reset_and_turn))
    assert pressed.finish() == 1, str(pressed)
    assert "the emergency stop is pressed" in pressed.output()
    bench.emergency_stop.unlink()
    with gecos.actor(arm), pytest.raises(gecos.CommandFailed, match=fault):
        arm.move(goal).result()
    assert bench.set_points() == received

    turned = says(meeting, user, reset_and_turn)
    assert turned == ["joint 1 is at 10 degrees"]
    assert bench.set_points()[-1][0] == pytest.approx(radians(10), abs=1e-8)
    assert "workshop::BenchArm" in user_lists(meeting, user)


def test_the_driver_and_the_program_of_an_arm_are_no_more_than_60_lines() -> None:
    lines = (TREE / "examples/own_arm/bench_arm.cpp").read_text().splitlines()
    assert len([line for line in lines if line.strip() and not line.strip().startswith("//")]) <= 60


def test_the_example_of_an_arm_is_what_the_page_shows() -> None:
    page = (TREE / "docs/adding-an-arm.md").read_text()
    blocks = re.findall(r"^```(\w+)\n(.*?)^```", page, re.MULTILINE | re.DOTALL)

    def text_of(name: str) -> str:
        return (TREE / "examples/own_arm" / name).read_text()

    assert ("toml", text_of("bench.toml")) in blocks
    assert ("xml", text_of("bench.urdf")) in blocks
    assert ("idl", text_of("idl/workshop/bench_arm.gidl")) in blocks
    for language, name in (("cpp", "bench_arm.cpp"), ("cmake", "CMakeLists.txt")):
        shown = [block for kind, block in blocks if kind == language]
        assert shown and all(block in text_of(name) for block in shown)
