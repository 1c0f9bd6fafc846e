"""Lists that are added to the lab.toml of `gecos up` while its programs run."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from gecos.laboratory import UnreadLists, read_laboratory

PROGRAM = '[programs.A]\nrun = ["a"]\n'


def edit(file: Path, text: str, at: int) -> None:
    file.write_text(text)
    os.utime(file, (at, at))


@pytest.mark.parametrize(
    ("tables", "named"),
    [
        ("[media.shm]\nreal_time = false\n", "[media]"),
        ("[streams]\nopen = false\n[media.lcm]\nreal_time = true\n", "[media], [streams]"),
    ],
)
def test_other_tables_that_programs_read_are_told_of(
    tmp_path: Path, tables: str, named: str
) -> None:
    file = tmp_path / "lab.toml"
    edit(file, PROGRAM, 1)
    lists = UnreadLists(read_laboratory(file))
    assert lists.appeared() == ""
    edit(file, PROGRAM + tables, 2)
    assert lists.appeared().startswith(f"{file} now has {named}. The running programs do not read")


@pytest.mark.parametrize("table", ["allow", "admin", "objects.LDS.allow"])
def test_the_first_list_of_a_file_is_told_of_once(tmp_path: Path, table: str) -> None:
    file = tmp_path / "lab.toml"
    edit(file, PROGRAM, 1)
    lists = UnreadLists(read_laboratory(file))
    assert lists.appeared() == ""
    edit(file, PROGRAM + f'[{table}]\nuser = ["anna"]\n', 2)
    assert lists.appeared() == "", "it has an error"
    edit(file, PROGRAM + f'[{table}]\nusers = ["anna"]\n', 3)
    assert lists.appeared().startswith(f"{file} now has [{table.split('.')[0]}]. ")
    edit(file, PROGRAM + f'[{table}]\nusers = ["ben"]\n', 4)
    assert lists.appeared() == ""


def test_a_list_that_was_added_while_the_programs_started_is_told_of(tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    edit(file, PROGRAM, 1)
    laboratory = read_laboratory(file)
    edit(file, PROGRAM + '[allow]\nusers = ["anna"]\n', 2)
    assert UnreadLists(laboratory).appeared() != ""


def test_a_file_that_the_programs_read_is_not_told_of(tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    edit(file, PROGRAM + '[allow]\nusers = ["anna"]\n', 1)
    lists = UnreadLists(read_laboratory(file))
    edit(file, PROGRAM + '[allow]\nusers = ["ben"]\n', 2)
    assert lists.appeared() == ""


def test_a_file_that_is_removed_is_not_told_of(tmp_path: Path) -> None:
    file = tmp_path / "lab.toml"
    edit(file, PROGRAM, 1)
    lists = UnreadLists(read_laboratory(file))
    file.unlink()
    assert lists.appeared() == ""
    edit(file, PROGRAM + '[allow]\nusers = ["anna"]\n', 2)
    assert lists.appeared() != ""
