"""Each page, followed to the letter in a home directory and a network of its own."""

from __future__ import annotations

import pytest
from hosts import Hosts
from pages import Reader


def test_the_simulated_laboratory(reader: Reader) -> None:
    reader.follow("docs/simulated-laboratory.md")


@pytest.mark.timeout(300)
def test_a_program_of_ones_own(reader: Reader) -> None:
    reader.follow("docs/own-program.md")


def test_two_machines(reader: Reader, hosts: Hosts) -> None:
    hosts.without_route(1)  # of the second machine, which has no default route either
    reader.follow("docs/two-machines.md")
