"""The glossary leads to folders and files that exist, and explains each word once."""

import re
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
SHORT = {"session/": "runtime/cpp/gecos/session/", "gecos/": "runtime/cpp/gecos/"}


def rows() -> list[list[str]]:
    """The cells of each word's row."""
    lines = (TREE / "docs/glossary.md").read_text(encoding="utf-8").splitlines()
    rows = [
        [cell.strip() for cell in line.strip("|").split(" | ")] for line in lines if "|" in line
    ]
    return [row for row in rows if row[0] != "word" and not set(row[0]) <= set("-|")]


def whole(place: str) -> str:
    for short, long in SHORT.items():
        if place.startswith(short):
            return place.replace(short, long, 1)
    return place


def test_every_word_has_one_row_of_four_cells_and_one_sentence() -> None:
    words = [row[0] for row in rows()]
    assert len(words) >= 60
    assert sorted(words) == sorted(set(words))
    assert [row[0] for row in rows() if len(row) != 4 or not row[2].endswith(".")] == []
    assert [row[0] for row in rows() if re.search(r"\. [A-Z]", row[2])] == []


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_every_place_exists(row: list[str]) -> None:
    places = re.findall(r"`([^`]+)`", row[3])
    assert places, row
    assert [place for place in places if not any(TREE.glob(whole(place).rstrip("/")))] == []
