"""Each page, followed to the letter in a home directory and a network of its own."""

from __future__ import annotations

import pytest
from pages import TREE, Reader


def test_the_simulated_laboratory(reader: Reader) -> None:
    reader.follow("docs/simulated-laboratory.md")


@pytest.mark.timeout(300)
def test_a_program_of_ones_own(reader: Reader) -> None:
    reader.follow("docs/own-program.md")


@pytest.mark.timeout(300)
def test_a_server_in_cpp(reader: Reader) -> None:
    reader.follow("docs/cpp-server.md")


@pytest.mark.timeout(300)
def test_sanitizers(reader: Reader) -> None:
    reader.follow("docs/sanitizers.md")


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "lesson", [path.name for path in sorted((TREE / "docs/tutorial").glob("[1-9]-*.md"))]
)
def test_a_lesson(lesson: str, student: Reader) -> None:
    student.follow(f"docs/tutorial/{lesson}")
