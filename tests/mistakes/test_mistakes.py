"""Makes each mistake of the tables and compares what the user is told with the golden message."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import gecos
import gidl.cli.main
import pytest
from gecos.cli import main as gecos_main
from mistakes import INSTRUCTION, KINDS, Mistake, all_mistakes, of_kind, settled, write_files


def each(kind: str) -> pytest.MarkDecorator:
    mistakes = of_kind(kind)
    return pytest.mark.parametrize("mistake", mistakes, ids=[m.name for m in mistakes])


def expect(mistake: Mistake, told: str) -> None:
    assert told == mistake.says, f"{mistake.table}.toml, {mistake.name}"


@each("python")
def test_a_mistake_in_python(mistake: Mistake, names: dict[str, Any], tmp_path: Path) -> None:
    """The message is that of the exception; without one, what the code assigned to `said`."""
    try:
        exec(compile(textwrap.dedent(mistake.made_by), "<mistake>", "exec"), names)
    except Exception as error:
        told = f"{type(error).__name__}: {error}"
    else:
        told = str(names["said"])
    expect(mistake, settled(told, tmp_path))


@each("program")
def test_a_mistake_in_a_program_of_its_own(mistake: Mistake, place: Path, tmp_path: Path) -> None:
    """The message is the last line on stderr."""
    ended = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(mistake.made_by)],
        cwd=tmp_path,
        env=os.environ | {"GECOS_RUNTIME_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=60,
    )
    told = ended.stderr.strip().splitlines()[-1]
    expect(mistake, settled(told, tmp_path))


@each("gecos")
def test_a_mistake_with_the_command_gecos(
    mistake: Mistake,
    laboratory: gecos.Lab,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_files(mistake, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["gecos", *words_of(mistake)])
    for _ in range(10):  # on a loaded machine the broker may not answer in time
        assert gecos_main()
        out, err = capsys.readouterr()
        if "no broker answers" not in err:
            break
    expect(mistake, settled(out + err, tmp_path))


@each("gidl")
def test_a_mistake_with_the_command_gidl(
    mistake: Mistake,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_files(mistake, tmp_path)
    monkeypatch.chdir(tmp_path)
    gidl.cli.main.main(words_of(mistake))
    out, err = capsys.readouterr()
    expect(mistake, settled(out + err, tmp_path))


def test_each_part_of_a_grade_stands_in_its_message() -> None:
    for mistake in all_mistakes():
        for part, words in mistake.parts.items():
            assert words in mistake.says, f"{mistake.table}.toml, {mistake.name}: {part}"


def test_what_to_do_is_an_instruction_or_asks_what_was_meant() -> None:
    for mistake in all_mistakes():
        do = mistake.parts["do"]
        assert not do or INSTRUCTION.match(do), f"{mistake.table}.toml, {mistake.name}: {do}"


def test_no_grade_is_below_two_and_nine_of_ten_are_three() -> None:
    """Over all mistakes, and for those of C++ alone."""
    mistakes = all_mistakes()
    poor = [mistake.name for mistake in mistakes if mistake.grade < 2]
    assert not poor
    for some, what in ((mistakes, "all"), ([m for m in mistakes if m.is_cpp], "C++")):
        best = sum(mistake.grade == 3 for mistake in some)
        print(f"{what}: {best} of {len(some)} messages have grade 3")
        assert best >= 0.9 * len(some), what


def test_there_are_sixty_mistakes_of_all_kinds_and_each_has_one_name() -> None:
    mistakes = all_mistakes()
    assert len({mistake.name for mistake in mistakes}) == len(mistakes) >= 60
    assert sum(mistake.is_cpp for mistake in mistakes) >= 25
    assert {mistake.kind for mistake in mistakes} == set(KINDS)


def words_of(mistake: Mistake) -> list[str]:
    """The words of a command; `'…'` holds words together, as in a shell."""
    return shlex.split(mistake.made_by)
