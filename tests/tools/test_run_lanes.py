"""`make test` must say what each runner said last, and must not call a failure a pass."""

import sys

from run_lanes import Lane, Verdict, run, summary


def lane(program: str, closing: str = r"passed|failed") -> Lane:
    return Lane("planted", (sys.executable, "-c", program), closing)


def test_a_lane_that_exits_0_passes_with_its_closing_line() -> None:
    verdict = run(lane("print('3 passed'); print('bye')"))
    assert verdict.passed
    assert verdict.closing_line == "3 passed"


def test_a_lane_that_exits_non_zero_fails_whatever_it_prints() -> None:
    verdict = run(lane("print('3 passed'); raise SystemExit(7)"))
    assert not verdict.passed


def test_without_a_closing_line_the_last_one_is_shown() -> None:
    verdict = run(lane("import sys; sys.exit('no such module')"))
    assert not verdict.passed
    assert verdict.closing_line == "no such module"


def test_a_lane_that_dies_of_a_signal_is_named() -> None:
    verdict = run(lane("import os; os.abort()"))
    assert not verdict.passed
    assert verdict.closing_line == "died of SIGABRT"


def test_a_lane_that_hangs_is_killed_with_what_it_started() -> None:
    hang = (
        "import subprocess, sys; print('started', flush=True); "
        "subprocess.run([sys.executable, '-c', 'import signal; signal.pause()'])"
    )
    verdict = run(lane(hang), limit=1.0)
    assert not verdict.passed
    assert verdict.closing_line == "killed: not done after 1 s"


def test_a_runner_that_is_not_there_fails() -> None:
    verdict = run(Lane("planted", ("/nonexistent/runner",), "x"))
    assert not verdict.passed
    assert verdict.closing_line.startswith("could not be started")


def test_the_summary_names_what_failed() -> None:
    good = Verdict(lane(""), True, "3 passed", 1.0)
    bad = Verdict(Lane("mypy", (), ""), False, "Found 1 error", 2.0)
    text = summary([good, bad])
    assert "3 passed" in text
    assert text.endswith("FAILED: mypy")
    assert summary([good]).endswith("all 1 lanes passed")
