"""A laboratory of its own for each test: a broker, a server with a lamp and a client."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import gecos
import pytest
from command_output import Run
from gecos.cli import main
from lamp import Lamp, PlainLamp


@pytest.fixture(scope="session")
def place() -> Iterator[Path]:
    """A folder to meet in, so that nobody else's broker is found. One for the process's life."""
    with (
        tempfile.TemporaryDirectory(prefix="gecos-") as folder,  # whose path is short enough
        pytest.MonkeyPatch.context() as environment,
    ):
        environment.setenv("GECOS_RUNTIME_DIR", folder)
        environment.delenv("GECOS_BROKER", raising=False)
        yield Path(folder)


@pytest.fixture
def lab(place: Path) -> Iterator[gecos.Lab]:
    with gecos.Lab() as lab, gecos.Broker(lab):
        yield lab


@pytest.fixture
def servant() -> PlainLamp:
    return PlainLamp()


@pytest.fixture
def server(lab: gecos.Lab, servant: PlainLamp) -> Iterator[gecos.Server]:
    with gecos.Server(lab) as server:
        server.add("LAMP", servant, simulated=True)
        yield server


@pytest.fixture
def lamp(lab: gecos.Lab, server: gecos.Server) -> Lamp:
    """A proxy without status."""
    return lab.create(Lamp, "LAMP")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    def said(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["gecos", *words])
        code = main()
        out, err = capsys.readouterr()
        return code, out, err

    return said


@pytest.fixture
def held(lamp: Lamp) -> Iterator[Lamp]:
    """A proxy that holds actor status."""
    with gecos.actor(lamp):
        yield lamp
