"""`make test` must say what each runner said last, and must not call a failure a pass."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from run_lanes import (
    OWN_NETWORK,
    Lane,
    Verdict,
    all_lanes,
    in_steps,
    run,
    run_all,
    run_together,
    summary,
)

TESTS = Path(__file__).resolve().parents[1]


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


@pytest.mark.parametrize(
    ("runner", "line"),
    [
        ("ctest", "\t1128 - ring_test.Ring.Holds (Failed)"),
        ("ctest", "\t12 - ring_test.Ring.Holds (Timeout)"),
        ("ctest", "/tests/cpp/media/ring_test.cpp:170: Failure"),
        ("systems", "FAILED tests/system/test_up.py::test_a_lab[rx90] - assert 1 == 2"),
        ("stress", "ERROR tests/stress/test_keys.py - ImportError"),
    ],
)
def test_a_failure_is_in_the_summary(runner: str, line: str) -> None:
    (found,) = (each for each in all_lanes("build", 1) if each.name == runner)
    others = (
        "\t7 - a.B/lcm  # GetParam() = lcm (Skipped)",
        "ERROR    root:server.py:12 no answer",
        line,
    )
    program = f"print({line!r}, *{others!r}, sep='\\n'); raise SystemExit(1)"
    verdict = run(replace(found, command=(sys.executable, "-c", program)))
    assert verdict.failures == (line.strip(),)
    assert f"\n        {line.strip()}\n" in summary([verdict])


def test_the_processor_time_of_a_lane_includes_that_of_its_programs() -> None:
    work = "import time\nwhile time.process_time() < 0.2: pass"
    verdict = run(lane(f"import subprocess, sys; subprocess.run([sys.executable, '-c', {work!r}])"))
    assert verdict.passed
    assert 0.2 <= verdict.processor_seconds < verdict.seconds + 0.2


def test_an_interruption_ends_the_lanes_that_run_and_begins_no_other() -> None:
    program = (
        "import os, signal, sys\n"
        "import run_lanes\n"
        "from run_lanes import Lane\n"
        "hang = Lane('hang', (sys.executable, '-c', 'import signal; print(1, flush=True); "
        "signal.pause()'), 'x')\n"
        "def show(text):\n"
        "    if text == '1\\n': os.kill(os.getpid(), signal.SIGINT)\n"
        "run_lanes.shown = show\n"
        "signal.signal(signal.SIGINT, run_lanes.end_lanes)\n"
        "run_lanes.run_together([hang, hang, hang], 2)\n"
    )
    env = {**os.environ, "PYTHONPATH": str(TESTS.parent / "tools")}
    ended = subprocess.run([sys.executable, "-c", program], env=env, timeout=30)
    assert ended.returncode == 128 + signal.SIGINT


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


def test_two_lanes_of_a_step_run_at_a_time_and_all_are_shown_in_turn(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(tmp_path / "pipe")  # opens for neither of them until both are there
    first = lane(f"print('A'); open({str(tmp_path / 'pipe')!r}).read(); print('1 passed')")
    second = lane(f"print('B'); open({str(tmp_path / 'pipe')!r}, 'w').close(); print('2 passed')")
    third = lane("print('C'); print('3 passed')")
    verdicts = run_together([first, second, third], 2)
    assert [v.closing_line for v in verdicts] == ["1 passed", "2 passed", "3 passed"]
    said = [line for line in capfd.readouterr().out.splitlines() if len(line) == 1]
    assert said == ["A", "B", "C"]


@pytest.mark.parametrize("may", [True, False])
def test_lanes_that_share_the_network_run_together_where_each_may_have_its_own(
    may: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("run_lanes.has_own_networks", lambda: may)
    low = [lane.name for lane in all_lanes("build", 2) if lane.low_priority]
    assert low == ["compiler"]
    lanes = [lane for lane in all_lanes("build", 2) if not lane.low_priority]
    steps = in_steps(lanes)
    together = [lane.name for step in steps if len(step) > 1 for lane in step]
    sharing = ["systems", "stress", "pytest", "robots"]
    assert together == (["docs", *sharing] if may else [])
    apart = [lane.name for lane in steps[-1] if lane.command[: len(OWN_NETWORK)] == OWN_NETWORK]
    assert apart == (sharing if may else [])
    assert len([lane for step in steps for lane in step]) == len(lanes)


def test_a_lane_of_low_priority_runs_beside_all_others_and_is_shown_last(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(tmp_path / "pipe")  # opens for neither of them until both are there
    low = lane(f"print('A'); open({str(tmp_path / 'pipe')!r}).read(); print('1 passed')")
    first = lane("print('B'); print('2 passed')")
    second = lane(f"print('C'); open({str(tmp_path / 'pipe')!r}, 'w').close(); print('3 passed')")
    verdicts = run_all([replace(low, low_priority=True), first, second], 2)
    assert [v.closing_line for v in verdicts] == ["2 passed", "3 passed", "1 passed"]
    said = [line for line in capfd.readouterr().out.splitlines() if len(line) == 1]
    assert said == ["B", "C", "A"]


def test_a_lane_of_low_priority_has_one() -> None:
    told = lane("import os; print('nice', os.nice(0))", "^nice")
    (verdict,) = run_all([replace(told, low_priority=True)], 2)
    assert verdict.closing_line == "nice 19"


def test_a_lane_of_low_priority_alone_is_shown_as_it_comes(
    capfd: pytest.CaptureFixture[str],
) -> None:
    (verdict,) = run_all([replace(lane("print('1 passed')"), low_priority=True)], 2)
    assert verdict.passed
    assert "1 passed" in capfd.readouterr().out


def test_every_test_of_python_belongs_to_one_lane() -> None:
    commands = [lane.command for lane in all_lanes("build", 2) if "pytest" in lane.command]
    for file in TESTS.rglob("test_*.py"):
        taken = [c for c in commands if takes(c, file.relative_to(TESTS.parent))]
        assert len(taken) == 1, (file, taken)


def takes(command: Sequence[str], file: Path) -> bool:
    words = command[command.index("pytest") + 1 :]
    left_out = [word.removeprefix("--ignore=") for word in words if word.startswith("--ignore=")]
    named = [word for word in words if not word.startswith("-")] or ["."]
    return any(file.is_relative_to(n) for n in named) and not any(
        file.is_relative_to(name) for name in left_out
    )
