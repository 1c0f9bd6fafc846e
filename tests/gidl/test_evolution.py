"""`gidl breaking` is right: random edits, and old and new programs that really talk.

For each edit, generated Python of both versions serves an object each and calls the other's. Where
every value arrives as it was meant, `breaking` may find nothing under WIRE; where one does not, or
the hashes tell the two apart, it must. More edits: GIDL_EVOLUTION_EDITS=5000.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from random import Random

import gecos
import pytest
from evolving import Lab, Slot, edited, random_lab
from gidl.breaking import category_of, compare
from gidl.compile import compile_files
from talking import Side, categories, conversation

EDITS = int(os.environ.get("GIDL_EVOLUTION_EDITS", "96"))
CHUNKS = 8
MEDIA = ("inproc", "shm")
GEARS = {"LOW": 0, "HIGH": 1}
CARTS = Path(__file__).resolve().parents[1] / "idl" / "evolution"


@pytest.fixture(autouse=True, scope="module")
def broker() -> Iterator[None]:
    with (
        tempfile.TemporaryDirectory(prefix="gecos-") as folder,  # whose path is short enough
        pytest.MonkeyPatch.context() as environment,
    ):
        environment.setenv("GECOS_RUNTIME_DIR", folder)
        environment.delenv("GECOS_BROKER", raising=False)
        with gecos.Lab() as lab, gecos.Broker(lab):
            yield


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_the_verdict_is_right_for_random_edits(chunk: int, tmp_path: Path) -> None:
    compatible = broken = 0
    for number in range(chunk, EDITS, CHUNKS):
        random = Random(number)
        before = random_lab(random)
        after, how = edited(before, random)
        old, new = Side(before, tmp_path, "old_lab"), Side(after, tmp_path, "new_lab")
        with conversation(old, new, random.choice(MEDIA)) as talk:
            agree = old.hashes == new.hashes and talk.agree(random)
            assert talk.only_new_operations_are_unknown()
        said = categories(old, new)
        assert agree == ("WIRE" not in said), (
            f"edit {number}, {how}: they {'agree' if agree else 'do not agree'}, "
            f"breaking says {said or 'nothing'}\n{before.text()}\n{after.text()}"
        )
        compatible += agree
        broken += not agree
    assert compatible >= EDITS / CHUNKS / 10, "random edits that break nothing are too few"
    assert broken >= EDITS / CHUNKS / 10, "random edits that break something are too few"


def lab(tail: Slot, literals: dict[str, int]) -> Lab:
    return Lab([Slot("a", "long"), tail], [Slot("to", "Goal")], literals, "LOW")


@pytest.mark.parametrize(
    "after",
    [
        lab(Slot("b", "double", "default"), GEARS),
        lab(Slot("c", "string", "default"), GEARS),
        lab(Slot("b", "long", "default"), {"LOW": 1, "HIGH": 0}),
    ],
    ids=["another type at the end", "another member at the end", "other numbers"],
)
def test_what_the_hashes_leave_out_is_broken_all_the_same(after: Lab, tmp_path: Path) -> None:
    """Ends that may grow and literals that may become more are in no hash of an operation."""
    before = lab(Slot("b", "long", "default"), GEARS)
    old, new = Side(before, tmp_path, "old_lab"), Side(after, tmp_path, "new_lab")
    assert old.hashes == new.hashes
    assert "WIRE" in categories(old, new)
    with conversation(old, new, "inproc") as talk:
        assert not talk.agree(Random(1))


def test_a_version_agrees_with_itself(tmp_path: Path) -> None:
    one = lab(Slot("b", "long", "default"), GEARS)
    old, new = Side(one, tmp_path, "old_lab"), Side(one, tmp_path, "new_lab")
    for medium in MEDIA:
        with conversation(old, new, medium) as talk:
            assert talk.agree(Random(1))
    assert not categories(old, new)


@pytest.mark.parametrize(("version", "agree"), [(2, True), (3, False)])
def test_the_verdict_is_right_for_the_versions_that_talk_in_cpp(version: int, agree: bool) -> None:
    """The pairs of tests/cpp/generated/evolution_test.cpp."""
    old, new = (
        compile_files([str(CARTS / f"cart_v{each}.gidl")], [str(CARTS)]) for each in (1, version)
    )
    assert not old.has_errors and not new.has_errors
    said = {category_of(finding.code) for finding in compare(old.model, new.model)}
    assert ("WIRE" not in said) == agree
