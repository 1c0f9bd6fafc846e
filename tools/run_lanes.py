"""Runs every lane of `make test`, and prints a summary line of each lane at the end.

A lane is one runner (ctest, pytest, mypy, …). Lanes that use the network wait most of the time: if
each can have a network of its own, they run beside each other. All other lanes run in turn. The
lane `compiler` runs beside all of them and uses the processor time that they leave. All lanes run
even when one fails; the exit status is 0 exactly when all of them passed. A lane that cannot run on
this machine fails: nothing is skipped.
"""

import argparse
import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
LONGEST_LANE = 20 * 60.0  # s
LONGEST_LOW_PRIORITY = 40 * 60.0  # s; the lane `compiler` lasts as long as all others together
LONGEST_LIST = 20  # the last failures of a lane, which the summary repeats
# A network of its own, in which multicast stays: `unshare -n` needs to be root.
OWN_NETWORK = (
    "unshare",
    "-n",
    "sh",
    "-euc",
    'ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo; exec "$@"',
    "sh",
)
# Each lane is a session, and Linux may share the processor between sessions: then nice(1) counts
# only within the lane, and the value in /proc/self/autogroup against other lanes (sched(7)).
LOW_PRIORITY = (
    "sh",
    "-c",
    '{ echo 19 >/proc/self/autogroup; } 2>/dev/null; exec nice -n 19 "$@"',
    "sh",
)


@dataclass(frozen=True, slots=True)
class Lane:
    """One runner. `closing` is a pattern for the line of its output that sums up the run, `failure`
    one for a line that names a test that failed."""

    name: str
    command: tuple[str, ...]
    closing: str
    failure: str | None = None
    shares_network: bool = False
    alone: bool = False  # no lane of normal priority runs beside it
    beside: bool = False  # may run beside the lanes that share the network
    low_priority: bool = False  # runs beside all others, in the time that they leave


@dataclass(frozen=True, slots=True)
class Verdict:
    lane: Lane
    passed: bool
    closing_line: str
    seconds: float
    processor_seconds: float = 0.0
    """Of the lane and of all the processes that it started and waited for."""
    failures: tuple[str, ...] = ()


def all_lanes(build: str, jobs: int) -> list[Lane]:
    python = sys.executable
    compiling = ("tests/gidl", "tests/generated", "tests/fuzz", "tests/tools")
    sdk, peers = "tests/system/test_sdk.py", "tests/system/test_bench_peers.py"
    robots = tuple(
        f"tests/system/test_{name}.py"
        for name in ("arm_file", "arm_pause", "demo", "examples", "follow", "hand_over", "plot")
    )
    documented = ("tests/docs", sdk)
    of_python = (*compiling, "tests/docs", "tests/system", "tests/stress")
    pytest_lines = (
        r"^=+ .*(passed|failed|error|no tests).* =+$",
        r"^(FAILED|ERROR) tests/",
    )
    return [
        Lane("host", (python, "tools/check_host.py"), r"^check_host: "),
        Lane("layers", (python, "tools/check_layers.py"), r"^check_layers: "),
        Lane("includes", (python, "tools/check_includes.py"), r"^check_includes: "),
        Lane("class-sizes", (python, "tools/check_class_sizes.py"), r"^check_class_sizes: "),
        Lane("generated", (python, "-m", "gidl", "gen", "--check"), r"\S"),
        Lane("gidl-fmt", (python, "-m", "gidl", "fmt", "--check"), r"^gidl: "),
        Lane("gidl-lint", (python, "-m", "gidl", "lint"), r"^gidl: "),
        Lane("ruff", (python, "-m", "ruff", "check", "."), r"^(All checks passed|Found )"),
        Lane("clang-format", (python, "tools/check_format.py"), r"^check_format: "),
        # The steps of `make wheels`, with the files that the build has compiled already.
        Lane("wheels", ("tools/wheels.sh", "--of-build"), r"^wheels: "),
        Lane(
            "thread-safety",
            (python, "tools/check_thread_safety.py", "--build", build),
            r"^check_thread_safety: ",
        ),
        Lane("mypy", (python, "-m", "mypy"), r"^(Success|Found )"),
        Lane(
            "ctest",
            (
                *("ctest", "--test-dir", build, "--output-on-failure", "--no-tests=error"),
                f"-j{2 * jobs}",
            ),
            r"^\d+% tests passed",
            r"^\d+ - .*\((?!Skipped|Disabled)[^()]+\)$|: Failure$",
        ),
        # No test in this lane measures time, so all others may delay it.
        Lane(
            "compiler",
            (
                *(python, "-m", "pytest", f"-n{jobs}", "--dist=worksteal"),
                *("--timeout=1800", "--durations=12", *compiling),
            ),
            *pytest_lines,
            low_priority=True,
        ),
        # This lane compiles, too. At low priority it would run for long beside the other lanes.
        Lane("docs", (python, "-m", "pytest", *documented), *pytest_lines, beside=True),
        # Busy loops on every core would keep the programs of other lanes from running.
        Lane(
            "bench-peers",
            (python, "-m", "pytest", peers),
            *pytest_lines,
            shares_network=True,
            alone=True,
        ),
        Lane(
            "systems",
            (
                *(python, "-m", "pytest", "tests/system"),
                *(f"--ignore={file}" for file in (sdk, peers, *robots)),
            ),
            *pytest_lines,
            shares_network=True,
        ),
        Lane(
            "stress", (python, "-m", "pytest", "tests/stress"), *pytest_lines, shares_network=True
        ),
        Lane(
            "pytest",
            (python, "-m", "pytest", *(f"--ignore={f}" for f in of_python)),
            *pytest_lines,
            shares_network=True,
        ),
        Lane("robots", (python, "-m", "pytest", *robots), *pytest_lines, shares_network=True),
    ]


def shown(text: str) -> None:
    print(text, end="", flush=True)


_interrupted = threading.Event()
_groups: set[int] = set()  # process groups of the lanes that run


def end_lanes(number: int, _frame: object) -> None:
    """Kills all lanes that run; no other begins. A signal of the terminal does not reach them."""
    _interrupted.set()
    for group in tuple(_groups):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
    raise SystemExit(128 + number)


def run(lane: Lane, limit: float = LONGEST_LANE, show: Callable[[str], object] = shown) -> Verdict:
    """Runs `lane` and passes its output to `show` as it comes. After `limit` seconds, kills the
    lane with all its processes."""
    if _interrupted.is_set():
        return Verdict(lane, False, "not begun", 0.0)
    show(f"\n──── {lane.name}: {' '.join(lane.command)}\n")
    started = time.monotonic()
    try:
        process = subprocess.Popen(
            lane.command,
            cwd=TREE,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )
    except OSError as error:
        return Verdict(lane, False, f"could not be started: {error}", 0.0)

    _groups.add(process.pid)
    if _interrupted.is_set():
        os.killpg(process.pid, signal.SIGKILL)
    late = threading.Event()

    def end() -> None:
        late.set()
        os.killpg(process.pid, signal.SIGKILL)

    watch = threading.Timer(limit, end)
    watch.start()
    closing = last = ""
    failures = []
    with process:
        assert process.stdout is not None
        for line in process.stdout:
            show(line)
            text = line.strip()
            last = text or last
            if re.search(lane.closing, text):
                closing = text
            if lane.failure is not None and re.search(lane.failure, text):
                failures.append(text)
        status, used = wait_for(process)
    _groups.discard(process.pid)
    watch.cancel()

    if late.is_set():
        closing = f"killed: not done after {limit:.0f} s"
    elif status < 0:
        closing = f"died of {signal.Signals(-status).name}"
    seconds = time.monotonic() - started
    return Verdict(
        lane, status == 0, closing or last, seconds, used, tuple(dict.fromkeys(failures))
    )


def wait_for(process: subprocess.Popen[str]) -> tuple[int, float]:
    """Returns the exit status of the process, and the processor time in seconds that it took."""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_utime + usage.ru_stime


def run_together(lanes: Sequence[Lane], at_a_time: int) -> list[Verdict]:
    """Runs at most `at_a_time` of the lanes at a time. The output of the first lane is shown as it
    comes, that of each other lane when it and all lanes before it have ended."""
    held: list[list[str]] = [[] for _ in lanes]
    with ThreadPoolExecutor(at_a_time) as pool:
        running = [
            pool.submit(run, lane, show=lines.append if number else shown)
            for number, (lane, lines) in enumerate(zip(lanes, held, strict=True))
        ]
        verdicts = []
        for lane, lines in zip(running, held, strict=True):
            verdicts.append(lane.result())
            shown("".join(lines))
    return verdicts


def has_own_networks() -> bool:
    try:
        return subprocess.run([*OWN_NETWORK, "true"], capture_output=True).returncode == 0
    except OSError:
        return False


def in_steps(lanes: Sequence[Lane]) -> list[list[Lane]]:
    """Groups lanes into steps. Lanes that share the network form one step, if each can have a
    network of its own; lanes that may run beside them are in the same step."""
    sharing = [lane for lane in lanes if lane.shares_network]
    if len(sharing) < 2 or not has_own_networks():
        return [[lane] for lane in lanes]
    apart = [replace(lane, command=(*OWN_NETWORK, *lane.command)) for lane in sharing]
    rest = [lane for lane in lanes if not lane.shares_network and not lane.beside]
    steps = [[lane] for lane in (*rest, *(lane for lane in apart if lane.alone))]
    beside = [lane for lane in lanes if lane.beside]
    return [*steps, [*beside, *(lane for lane in apart if not lane.alone)]]


def at_a_time(cores: int) -> int:
    """Returns how many lanes of a step run at a time: most of them wait most of the time."""
    return cores + 1 if cores > 1 else 1


def run_all(lanes: Sequence[Lane], cores: int) -> list[Verdict]:
    """Runs the lanes of low priority in turn, beside all others, which run step by step. Their
    output is shown at the end, after that of the others."""
    low = [
        replace(lane, command=(*LOW_PRIORITY, *lane.command)) for lane in lanes if lane.low_priority
    ]
    steps = in_steps([lane for lane in lanes if not lane.low_priority])
    held: list[str] = []
    show = held.append if steps else shown
    with ThreadPoolExecutor(1) as pool:
        beside = pool.submit(lambda: [run(lane, LONGEST_LOW_PRIORITY, show) for lane in low])
        try:
            verdicts = [each for step in steps for each in run_together(step, at_a_time(cores))]
            if steps and low:
                shown(f"\n──── waiting for: {', '.join(lane.name for lane in low)}\n")
            return [*verdicts, *beside.result()]
        finally:
            shown("".join(held))


def summary(verdicts: Sequence[Verdict]) -> str:
    width = max(len(verdict.lane.name) for verdict in verdicts)
    lines = []
    for verdict in verdicts:
        lines.append(
            f"{'passed' if verdict.passed else 'FAILED'}  {verdict.lane.name:<{width}}  "
            f"{verdict.seconds:6.1f} s  cpu {verdict.processor_seconds:6.1f} s  "
            f"{verdict.closing_line}"
        )
        if not verdict.passed:
            lines += [f"        {failure}" for failure in verdict.failures[-LONGEST_LIST:]]
    failed = [verdict.lane.name for verdict in verdicts if not verdict.passed]
    lines.append(f"FAILED: {', '.join(failed)}" if failed else f"all {len(verdicts)} lanes passed")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--build", default="build", help="folder that CMake built in")
    parser.add_argument(
        "--jobs", type=int, default=os.cpu_count() or 1, help="number of cores to use"
    )
    parser.add_argument("lanes", nargs="*", help="only these lanes (all, when none is named)")
    asked = parser.parse_args()

    lanes = all_lanes(asked.build, asked.jobs)
    unknown = set(asked.lanes) - {lane.name for lane in lanes}
    if unknown:
        known = ", ".join(lane.name for lane in lanes)
        parser.error(f"no lane {', '.join(sorted(unknown))}; there are {known}")
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end_lanes)
    os.environ["GECOS_BUILD"] = asked.build  # where pytest finds the programs
    wanted = [lane for lane in lanes if not asked.lanes or lane.name in asked.lanes]
    verdicts = run_all(wanted, asked.jobs)
    print("\n" + summary(verdicts), flush=True)
    return 0 if all(verdict.passed for verdict in verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
