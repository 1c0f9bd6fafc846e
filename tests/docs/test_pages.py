"""Each page, followed to the letter in a home directory and a network of its own."""

from __future__ import annotations

import pytest
from pages import Reader


def test_the_simulated_laboratory(reader: Reader) -> None:
    reader.follow("docs/simulated-laboratory.md")


@pytest.mark.timeout(300)
def test_a_program_of_ones_own(reader: Reader) -> None:
    reader.follow("docs/own-program.md")


@pytest.mark.timeout(300)
def test_a_server_in_cpp(reader: Reader) -> None:
    reader.follow("docs/cpp-server.md")
