"""`gidl breaking` is right: random edits, and old and new programs that really talk.

For each edit the generated Python of both versions sends requests and replies to the other. Where
every value arrives as it was meant, `breaking` may find nothing under WIRE; where one does not, or
the hashes make the two refuse each other, it must. More edits: GIDL_EVOLUTION_EDITS=5000.
"""

import os
from pathlib import Path
from random import Random

import pytest
from evolving import Lab, Side, Slot, categories, edited, random_lab, understand_each_other

EDITS = int(os.environ.get("GIDL_EVOLUTION_EDITS", "160"))
CHUNKS = 8


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_the_verdict_is_right_for_random_edits(chunk: int, tmp_path: Path) -> None:
    compatible = broken = 0
    for number in range(chunk, EDITS, CHUNKS):
        random = Random(number)
        before = random_lab(random)
        after, how = edited(before, random)
        old, new = Side(before, tmp_path, "old_lab"), Side(after, tmp_path, "new_lab")
        agree = understand_each_other(old, new, random)
        said = categories(old, new)
        assert agree == ("WIRE" not in said), (
            f"edit {number}, {how}: they {'agree' if agree else 'do not agree'}, "
            f"breaking says {said or 'nothing'}\n{before.text()}\n{after.text()}"
        )
        compatible += agree
        broken += not agree
    assert compatible >= EDITS / CHUNKS / 10, "random edits that break nothing are too few"
    assert broken >= EDITS / CHUNKS / 10, "random edits that break something are too few"


def test_two_sides_that_do_not_agree_are_noticed(tmp_path: Path) -> None:
    """The judge itself: what has the same hash and other bytes does not pass."""
    goal = Slot("to", "Goal")
    before = Lab([Slot("a", "long"), Slot("b", "long", "default")], [goal], {"L0": 0}, "L0")
    after = Lab([Slot("a", "long"), Slot("b", "double", "default")], [goal], {"L0": 0}, "L0")
    old, new = Side(before, tmp_path, "old_lab"), Side(after, tmp_path, "new_lab")
    assert not understand_each_other(old, new, Random(1))
    assert understand_each_other(old, old, Random(1))
