"""How the rounds of `make bench-peers` are repeated, counted and judged, without any program."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TREE / "benchmarks" / "peers"))

import measure  # noqa: E402
import report  # noqa: E402
from judge import Measured, judge  # noqa: E402
from measure import Pace, Run  # noqa: E402
from pair import Broken, Candidate  # noqa: E402
from settings import MOST_ROUNDS, Bar, Figure, Line, Setting  # noqa: E402

OURS = Line(Candidate("ours", "", (), ()))
THEIRS = Line(Candidate("theirs", "peer", (), ()))
PACE = Pace(rounds=3, seconds=0.1, rests=1)
SETTING = Setting("a setting", (OURS, THEIRS), ())


def run(monkeypatch: pytest.MonkeyPatch, failing: dict[str, list[int]]) -> Run:
    """Runs with measurements that fail where `failing` names their number, from 1 for each line."""
    asked: dict[str, int] = {}

    def once(setting: Setting, line: Line, *_: object) -> Measured:
        asked[line.label] = asked.get(line.label, 0) + 1
        if asked[line.label] in failing.get(line.label, []):
            raise Broken("the lease was lost")
        return Measured(p50=1.0)

    monkeypatch.setattr(measure, "_once", once)
    return measure.run(SETTING, SETTING.lines, PACE, {})


def test_a_measurement_that_fails_is_repeated_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    done = run(monkeypatch, {"ours": [2, 3]})
    assert len(done.rounds["ours"]) == len(done.rounds["theirs"]) == 3
    assert done.repeated == {"ours": 2}
    assert "failed: ours, 2 times" in report.table(SETTING, done)


def test_a_peer_that_fails_three_times_in_a_round_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done = run(monkeypatch, {"theirs": [2, 3, 4]})
    assert list(done.rounds) == ["ours"]
    assert len(done.rounds["ours"]) == 3


def test_ours_that_fails_three_times_in_a_round_ends_the_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(Broken, match="the lease was lost"):
        run(monkeypatch, {"ours": [1, 2, 3]})


def rounds(**figures: list[float]) -> dict[str, list[Measured]]:
    return {
        label: [Measured(p50=one, rate=one) for one in several]
        for label, several in figures.items()
    }


@pytest.mark.parametrize(("worse", "met"), [(1, True), (2, False)])
def test_a_bar_of_most_rounds_holds_when_one_of_nine_is_worse(worse: int, met: bool) -> None:
    bar = Bar("ours", ("theirs", "others"), 1.0, Figure.P50, MOST_ROUNDS)
    ours = [5.0] * worse + [1.0] * (9 - worse)
    verdict = judge(bar, rounds(ours=ours, theirs=[2.0] * 9, others=[4.0] * 9))
    assert verdict.met is met


def test_fewer_calls_than_the_best_peer_miss_the_bar() -> None:
    bar = Bar("ours", ("theirs", "others"), 1.0, Figure.RATE, MOST_ROUNDS)
    assert not judge(bar, rounds(ours=[3.0], theirs=[2.0], others=[4.0])).met
    assert judge(bar, rounds(ours=[4.0], theirs=[2.0], others=[4.0])).met


def test_beside_a_peer_that_leaves_nothing_any_rest_is_enough() -> None:
    bar = Bar("ours", ("theirs",), 1.0, Figure.RATE, MOST_ROUNDS)
    assert judge(bar, rounds(ours=[0.0, 0.1], theirs=[0.0, 0.0])).ratios == [1.0, math.inf]


def test_a_bar_without_others_is_the_figure_itself() -> None:
    bar = Bar("ours", (), 8.0, Figure.P50)
    assert judge(bar, rounds(ours=[7.0, 8.0, 30.0])).met
    assert not judge(bar, rounds(ours=[7.0, 9.0, 30.0])).met


def test_a_bar_whose_peers_were_not_measured_is_not_met() -> None:
    bar = Bar("ours", ("theirs",), 1.0)
    verdict = judge(bar, rounds(ours=[1.0]))
    assert not verdict.met
    assert not verdict.ratios


def test_the_price_of_the_checks_is_the_ratio_of_calls_with_and_without_them() -> None:
    bar = Bar("ours", (), 1.05, Figure.CHECKS)
    rounds = [Measured(p50=p50, unchecked=1.0) for p50 in (1.02, 1.04, 1.2)]
    verdict = judge(bar, {"ours": rounds})
    assert (verdict.ratios, verdict.met) == ([1.02, 1.04, 1.2], True)
    assert not judge(bar, {"ours": [Measured(p50=1.06, unchecked=1.0)]}).met
    assert "| ours: p50 with all checks / without | ≤ 1.05 | 1.04 |" in report.bars(
        [(SETTING, verdict)]
    )


IMAGES = Setting("images", (OURS, THEIRS), (), figure=Figure.READABLE, images=True)


def test_images_are_judged_by_when_they_are_readable_read_whole_and_sent() -> None:
    ours = Measured(readable=4.0, whole=900.0, sending=30.0)
    theirs = Measured(readable=2.0, whole=1000.0, sending=10.0)
    measured = {"ours": [ours], "theirs": [theirs]}

    def ratio(figure: Figure) -> list[float]:
        return judge(Bar("ours", ("theirs",), 1.0, figure), measured).ratios

    assert ratio(Figure.READABLE) == [2.0]
    assert ratio(Figure.WHOLE) == [0.9]
    assert ratio(Figure.SENDING) == [3.0]
    assert "| ours | 4.00 | 0.00 | 4.00 to 4.00 | 900 | 900 to 900 | 30.00 |" in report.table(
        IMAGES, Run(measured)
    )


def test_other_readers_read_while_the_first_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[tuple[int, str]] = []

    class Client:
        def __init__(self, number: int) -> None:
            self.number = number

        def say(self, question: str) -> None:
            said.append((self.number, question))

        def line(self) -> str:
            said.append((self.number, "answered"))
            return "9 2000.0 3000.0 4000.0 5000.0 6000.0"

    class Pair:
        def __init__(self, *_: object) -> None:
            self.clients = 0

        def client(self, cores: list[int]) -> Client:
            self.clients += 1
            return Client(self.clients)

        def close(self) -> None: ...

    monkeypatch.setattr(measure, "Pair", Pair)
    done = measure.run(IMAGES, (Line(OURS.candidate, other_readers=2),), Pace(1, 0.25, 1), {})
    assert done.rounds["ours"] == [
        Measured(readable=2.0, readable_p99=3.0, whole=4.0, whole_p99=5.0, sending=6.0)
    ]
    numbers = [number for number, _ in said]
    assert numbers == [2, 3, 1, 1, 1, 1, 2, 3]
    assert said[0][1] == "images 0.9"
    assert said[2][1] == "images 0.2"
