"""A laboratory of our programs, and a speaker of the protocol as a user of its own."""

from __future__ import annotations

import os
import secrets
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from speaker.lcm import Loop
from speaker.noise import Keys, public_of, write_key_folder

TREE = Path(__file__).resolve().parents[2]
sys.path.append(str(TREE / "tests" / "system"))  # processes.py

from processes import Laboratory  # noqa: E402

LAB_SECRETS: dict[bytes, bytes] = {}
"""The laboratory's secret key, by the speaker's public one."""


@pytest.fixture
def loop() -> Iterator[Loop]:
    loop = Loop()
    yield loop
    loop.close()


@pytest.fixture
def keys() -> Keys:
    """The speaker's, who admits the laboratory; and it him (see `lab`)."""
    theirs = secrets.token_bytes(32)
    keys = Keys(secrets.token_bytes(32), frozenset({public_of(theirs)}))
    LAB_SECRETS[keys.public] = theirs
    return keys


@pytest.fixture
def lab(keys: Keys) -> Iterator[Laboratory]:
    """Broker and programs of another user, in a folder of their own, reached over lcm."""
    build = TREE / os.environ.get("GECOS_BUILD", "build")
    assert (build / "CMakeCache.txt").exists(), f"nothing is built in {build}: run `make build`"
    # Not tmp_path: the name of a Unix socket has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        place = Path(folder)
        theirs = Keys(LAB_SECRETS[keys.public], frozenset({keys.public}))
        write_key_folder(place / "keys", theirs)
        (place / "run").mkdir(mode=0o700)
        laboratory = Laboratory(place / "run", build)
        laboratory.env["GECOS_KEY_DIR"] = str(place / "keys")
        try:
            broker = build / "runtime/cpp/gecos/broker/gecos-broker"
            told = laboratory.start(broker, ready="ready").output()
            assert "is not served over lcm" not in told, f"end the other broker first: {told}"
            yield laboratory
        finally:
            laboratory.close()
