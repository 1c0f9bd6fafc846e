"""Laboratories of our programs, in folders of their own, as a user whom the speaker admits."""

from __future__ import annotations

import os
import secrets
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from processes import Laboratory, Program
from speaker.noise import Keys, public_of, write_key_folder
from told import command_of

TREE = Path(__file__).resolve().parents[2]


def two_users() -> tuple[Keys, Keys]:
    """The speaker and the laboratory, who admit each other."""
    ours, theirs = secrets.token_bytes(32), secrets.token_bytes(32)
    return Keys(ours, frozenset({public_of(theirs)})), Keys(theirs, frozenset({public_of(ours)}))


@contextmanager
def laboratory_of(theirs: Keys) -> Iterator[Laboratory]:
    build = TREE / os.environ.get("GECOS_BUILD", "build")
    assert (build / "CMakeCache.txt").exists(), f"{build} is empty: run `make build-tests`"
    # Not tmp_path: the name of a Unix socket has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="gecos-") as folder:
        place = Path(folder)
        write_key_folder(place / "keys", theirs)
        (place / "run").mkdir(mode=0o700)
        laboratory = Laboratory(place / "run", build)
        laboratory.env["GECOS_KEY_DIR"] = str(place / "keys")
        try:
            yield laboratory
        finally:
            laboratory.close()


def start_broker(lab: Laboratory) -> None:
    broker = lab.build / "runtime/cpp/gecos/broker/gecos-broker"
    told = lab.start(broker, ready="ready").output()
    assert "is not served over lcm" not in told, f"end the other broker first: {told}"


@dataclass(slots=True)
class Hall:
    """A laboratory for the tests of a module: broker and client programs live through them all."""

    lab: Laboratory
    keys: Keys
    """The speaker's."""
    programs: dict[str, Program]

    def program(self, language: str) -> Program:
        program = self.programs.get(language)
        if program is None or not program.running():
            words = command_of(self.lab, language)
            program = self.lab.start(*words, ready="ready", listens=True)
            self.programs[language] = program
        return program
