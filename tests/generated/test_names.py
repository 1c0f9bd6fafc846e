"""No name of an interface breaks generated Python: a type, a parameter or a member may have the
name of an import, a builtin or a local variable of the generated module."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gecos import wire
from gecos.wire import Decoder
from generating import TREE, generate
from names_in_use import members_file, names_in_use, types_file

ROOTS = [TREE / "runtime" / "python", TREE / "generated" / "python"]


# Capitals alone, or an underscore, tell these apart; constants of a module are all capitals.
ALIKE = """
module alike {
  @final struct fooBar { double x; };
  @final struct foo_bar { string s; long n; };
  interface Arm_c { double d(in fooBar x); };
  interface Arm {
    double c(in foo_bar x);
    double c_d(in double x);
    @sensor @stream(rate="1Hz") readonly attribute double at;
    @sensor double at_stream();
  };
};
"""

# What no other interface of the tests asks for.
TERMS = """
@version("1.0") @qos(class=SOFT_REALTIME, latency="5ms", media="shm|lcm")
interface Terms {
  @cancelable @on_new("preempt") @on_loss("finish") void turn(in double by);
};
"""


@pytest.fixture(scope="module")
def groups(everything: Path, tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    more = tmp_path_factory.mktemp("more")
    (more / "terms.gidl").write_text(TERMS)
    generate(more, TREE / "tests" / "idl" / "workshop" / "workshop.gidl", more / "terms.gidl")
    roots = (everything, more, TREE / "generated")
    return names_in_use(file for root in roots for file in (root / "python").rglob("*.py"))


@pytest.fixture(scope="module")
def shadowing(groups: list[list[str]], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Output folder of interfaces with all those names; its Python can be imported."""
    out = tmp_path_factory.mktemp("shadowing")
    files = []
    for i, names in enumerate(groups):
        for module, text in ((f"zt{i}", types_file), (f"zm{i}", members_file)):
            (out / f"{module}.gidl").write_text(text(module, names))
            files.append(out / f"{module}.gidl")
    generate(out, *files)
    sys.path.insert(0, str(out / "python"))
    yield out
    sys.path.remove(str(out / "python"))


def test_the_names_are_those_that_modules_use(groups: list[list[str]]) -> None:
    """What hid an import, broke a body or a class before there was this test."""
    found = {name for names in groups for name in names}
    known = "Kind Access Quality Operation Method Media OnNew Servant StreamAttribute wire layout "
    known += "method values getter interface property list dataclass np typing value"
    assert set(known.split()) - found == set()


class Answers:
    """What a proxy sends is read as a server reads it, and its answer as the proxy reads that."""

    def __init__(self, module: Any, interface: str) -> None:
        proxy, servant = getattr(module, interface), getattr(module, f"{interface}Servant")
        self.given: tuple[Any, ...] = ()
        self.result: Any = None
        own = self

        class Client(proxy):  # type: ignore[misc]
            def __init__(self) -> None:
                pass

            def _gecos_call(self, method: Any, parts: list[bytes]) -> Any:
                handler = servant._gecos_handlers[method.operation.code]
                assert callable(getattr(servant, handler.method))
                own.given = handler.arguments(Decoder(b"".join(parts)))
                source = Decoder(b"".join(handler.result(own.result)))
                return method.result(source)

        class Server(servant):  # type: ignore[misc]
            def _gecos_publish(self, code: int, parts: list[bytes], stamp: float | None) -> None:
                own.given = (b"".join(parts), stamp)

        Server.__abstractmethods__ = frozenset()
        self.client, self.server = Client(), Server()

    def operations(self, start: str) -> Iterator[tuple[str, Any]]:
        """The operations of the interface whose names are `start` and a number."""
        for name in vars(type(self.client).__mro__[1]):
            if name.startswith(start) and name[len(start) :].isdigit():
                yield name, getattr(self.client, name)


def groups_of(shadowing: Path, start: str) -> Iterator[tuple[Any, Any]]:
    """Modules with the calls, and those with the types."""
    for file in sorted(shadowing.glob(f"{start}?.gidl")):
        yield import_module(file.stem), import_module(f"{file.stem}_types")


def alike(one: Any, other: Any) -> bool:
    return repr(one) == repr(other)  # arrays are equal element by element


def test_types_of_these_names_go_through_calls_and_streams(shadowing: Path) -> None:
    for module, _ in groups_of(shadowing, "zt"):
        answers = Answers(module, "Zall")
        for name, call in answers.operations("f"):
            hint = call.__func__.__annotations__["z"]
            if hint == "float":
                assert call(1.5) is None
                assert answers.given == (1.5,)
                continue
            kind = getattr(module, hint)
            answers.result = value = sample(kind)
            assert alike(call(value, [value, value]), value), hint
            assert alike(answers.given, (value, [value, value])), hint
            number = name.removeprefix("f")
            assert alike(getattr(answers.client, f"g{number}")(), value)
            getattr(answers.server, f"publish_g{number}")(value, 2.0)
            assert answers.given[1] == 2.0


def sample(kind: Any) -> Any:
    if hasattr(kind, "make_x"):
        return kind.make_x(1.5)
    if hasattr(kind, "pack"):
        return kind(low=3, high=-4)
    if hasattr(kind, "decode"):
        return kind(1.5, ["a", "b"])
    return kind(1)


def test_parameters_of_these_names_go_through_calls(shadowing: Path) -> None:
    for module, types in groups_of(shadowing, "zm"):
        answers = Answers(module, "Zparameters")
        p, q = types.Zp(x=1.0, s="a", hue=types.Zhue.ZB), types.Zq(x=2.0, y=types.Zhue.ZB)
        for name, call in answers.operations("f"):
            given = (1.5, "t", [p, p], np.array([1.0, 2.0]), {"k": p}, types.Zhue.ZB, q, 7)
            answers.result = None
            assert call(*given) is None, name
            assert alike(answers.given, given), name
        for name, call in answers.operations("g"):
            answers.result = result = call.__func__.__globals__[f"Zparameters_{name}_result"](
                [p], {"b": 2.0}, 4
            )
            assert call([p, p], {"a": 1.0}) == result, name
            assert answers.given == ([p, p], {"a": 1.0}), name
        answers.result = None
        for name, call in answers.operations("h"):
            assert call({types.Zhue.ZB: q}) is None, name
            assert answers.given == ({types.Zhue.ZB: q},), name


def test_values_with_members_of_these_names_are_read_as_written(shadowing: Path) -> None:
    for _, types in groups_of(shadowing, "zm"):
        value = types.Zmembers()
        assert wire.from_bytes(types.Zmembers, wire.to_bytes(value)) == value
        failed = wire.from_bytes(types.Zfailed, wire.to_bytes(types.Zfailed()))
        assert str(failed) == str(types.Zfailed())
        arms = [word for word in dir(types.Zarms) if word.startswith("make_")]
        assert len(arms) == len(types.Zarms._gecos_layout.arms)


def test_operations_of_these_names_can_be_called(shadowing: Path) -> None:
    for module, types in groups_of(shadowing, "zm"):
        answers = Answers(module, "Zmethods")
        answers.result = [types.Zp(x=1.0)]
        for name in (h.method for h in type(answers.server)._gecos_handlers.values()):
            if name[0] == "z" and name[1:].isdigit():
                continue
            given = ({"a": 1}, types.Zq(x=1.0))
            assert getattr(answers.client, name)(*given) == answers.result, name
            assert answers.given == given, name


def test_mypy_has_nothing_to_say(shadowing: Path, tmp_path: Path) -> None:
    judged = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases",
         "--config-file", os.devnull, "--cache-dir", str(tmp_path), str(shadowing / "python")],
        env={**os.environ, "MYPYPATH": os.pathsep.join(map(str, ROOTS))},
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert judged.returncode == 0, judged.stdout[-4000:] + judged.stderr


def test_names_that_capitals_make_alike_are_kept_apart(tmp_path: Path) -> None:
    (tmp_path / "alike.gidl").write_text(ALIKE)
    generate(tmp_path, tmp_path / "alike.gidl")
    module = (tmp_path / "python" / "alike.py").read_text()
    assigned = re.findall(r"^(_[A-Z_]+)(?:: .*)? = ", module, re.MULTILINE)
    assert len(assigned) > 1
    assert len(assigned) == len(set(assigned))
