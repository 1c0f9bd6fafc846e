"""The reading test hands out bare folders, and docs/architecture.md says what is in each."""

import sys

import pytest
import reading_test
from reading_test import Found

SHEET = {"line": [Found("devices/arm/a.hpp:1", "double speed;")], "comment": [], "text": []}


def test_architecture_has_one_sentence_for_every_folder_with_sources() -> None:
    said = reading_test.contents_of_folders(
        (reading_test.TREE / "docs/architecture.md").read_text("utf-8")
    )
    assert [folder for folder in reading_test.folders() if folder not in said] == []
    assert [folder for folder in said if not (reading_test.TREE / folder).exists()] == []


def test_the_strict_form_lists_folders_without_a_word_about_them(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading_test, "drawn", lambda seed: SHEET)

    def printed(*arguments: str) -> list[str]:
        monkeypatch.setattr(sys, "argv", ["reading_test.py", "1", *arguments])
        reading_test.main()
        return capsys.readouterr().out.splitlines()

    bare = [f"  {folder}" for folder in reading_test.folders()]
    line = ["", "line 1:", "    double speed;"]
    assert printed() == ["Folders:", *bare, *line]
    told = printed("--contents")
    assert told[0] == "Folders:"
    assert told[-3:] == line
    assert [each.partition(": ")[0] for each in told[1:-3]] == bare
