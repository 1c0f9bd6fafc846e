"""A laboratory of our programs, and a speaker of the protocol as a user of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from speaker.lcm import Loop
from speaker.noise import Keys

HERE = Path(__file__).resolve().parent
TREE = HERE.parents[1]
sys.path.append(str(TREE / "tests" / "system"))  # processes.py

from hall import Hall, laboratory_of, start_broker, two_users  # noqa: E402
from partner import Partner  # noqa: E402
from processes import Laboratory  # noqa: E402
from told import LANGUAGES, Client  # noqa: E402


def _generate(out: Path) -> None:
    """The partner's Python, for our client; its model, for the hashes that the speaker tells."""
    words = ["--lang", "python,model", "-I", HERE / "idl", "-I", TREE / "idl", "--out", out]
    subprocess.run(
        [sys.executable, "-m", "gidl", "gen", *words, HERE / "idl" / "speaking" / "partner.gidl"],
        check=True,
        stdout=subprocess.DEVNULL,
    )


@pytest.fixture
def loop() -> Iterator[Loop]:
    loop = Loop()
    yield loop
    loop.close()


@pytest.fixture
def users() -> tuple[Keys, Keys]:
    return two_users()


@pytest.fixture
def keys(users: tuple[Keys, Keys]) -> Keys:
    """The speaker's, who admits the laboratory; and it him (see `lab`)."""
    return users[0]


@pytest.fixture
def lab(users: tuple[Keys, Keys]) -> Iterator[Laboratory]:
    """Broker and programs of another user, in a folder of their own, reached over lcm."""
    with laboratory_of(users[1]) as laboratory:
        start_broker(laboratory)
        yield laboratory


@pytest.fixture(scope="session")
def model() -> Iterator[Path]:
    """The partner's, and the Python that our client imports."""
    with tempfile.TemporaryDirectory(prefix="partner-") as out:
        _generate(Path(out))
        yield Path(out)


@pytest.fixture(scope="module")
def hall(model: Path) -> Iterator[Hall]:
    ours, theirs = two_users()
    with laboratory_of(theirs) as lab:
        paths = str(model / "python"), lab.env.get("PYTHONPATH")
        lab.env["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        start_broker(lab)
        hall = Hall(lab, ours, {})
        yield hall
        for program in hall.programs.values():
            program.end_of_input()
            program.wait_for("done")
            assert program.finish() == 0, str(program)


@pytest.fixture(params=LANGUAGES)
def client(hall: Hall, loop: Loop, request: pytest.FixtureRequest) -> Iterator[Client]:
    """Our program: it opens what it is told, and must still be alive when the test is over."""
    client = Client(hall.program(request.param), loop)
    yield client
    assert client.program.running(), f"it crashed: {client.program}"
    client.tell("close")
    client.says("closed")


@pytest.fixture
def partner(hall: Hall, model: Path, loop: Loop, client: Client) -> Iterator[Partner]:
    """What the speaker serves, on the broker's list."""
    partner = Partner(loop, hall.keys, model / "model" / "speaking" / "partner.json")
    partner.enlist()
    yield partner
    partner.close()
