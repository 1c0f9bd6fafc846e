"""Round trips of this project, of other libraries and of lower limits, in one run.

Prints a table of each setting, and at the end what is promised, met or missed. A peer whose
programs are not there is named, the rest is measured, and the exit status is 3 unless --without
named it too. A missed bar is no failure of the run: speeds are shown, not asserted.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from getpass import getuser
from pathlib import Path

import report
from candidates import candidates
from judge import Verdict, judge
from measure import OTHER_USER, Pace, run
from pair import Broken
from settings import Line, Setting, settings

TREE = Path(__file__).resolve().parents[2]
FULL = Pace(rounds=9, seconds=0.25, rests=5)
QUICK = Pace(rounds=3, seconds=0.15, rests=2)
SMOKE = Pace(rounds=1, seconds=0.02, rests=1)
MISSING = 3
LISTS = """[objects.BROKER.allow]
users = {users}
[objects.EXCHANGE.allow]
users = {users}
"""


@contextlib.contextmanager
def own_laboratory(build: Path) -> Iterator[dict[str, str]]:
    """The environment of programs: a folder of their own to meet in, and the built libraries."""
    # Not below a long path: the name of a Unix socket has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="bench-peers-") as room:
        env = {name: value for name, value in os.environ.items() if name != "GECOS_BROKER"}
        keys = Path(room) / "keys"
        keys.mkdir(mode=0o700)
        env["GECOS_RUNTIME_DIR"] = room
        env["GECOS_KEY_DIR"] = env["GECOS_AUDIT_DIR"] = str(keys)
        admitted = Path(room) / "lab.toml"
        admitted.write_text(LISTS.format(users=json.dumps([getuser(), OTHER_USER])))
        admitted.chmod(0o644)
        Path(room).chmod(0o1777)  # for the sockets that programs of another user need
        env["GECOS_LAB_FILE"] = str(admitted)
        python = build / "benchmarks" / "peers" / "python"
        env["PYTHONPATH"] = os.pathsep.join(filter(None, [str(python), env.get("PYTHONPATH")]))
        yield env


def words() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--build", type=Path, default=TREE / "build", help="folder of the build")
    parser.add_argument("--rounds", type=int, help=f"default {FULL.rounds}")
    pace = parser.add_mutually_exclusive_group()
    pace.add_argument("--quick", action="store_true", help="a look, not a result: few rounds")
    pace.add_argument("--smoke", action="store_true", help="does everything answer? No figures")
    parser.add_argument("--only", default="", help="settings whose title begins so")
    parser.add_argument(
        "--without", action="append", default=[], metavar="PEER",
        help="leave it out and do not complain; all: measure ours and the limits",
    )  # fmt: skip
    given = parser.parse_args()
    if given.rounds is not None and given.rounds < 1:
        parser.error("--rounds: at least one")
    return given


def missing_of(wanted: list[Setting]) -> set[str]:
    """The peers in these settings whose programs are not there."""
    asked = [line.candidate for setting in wanted for line in setting.lines]
    return {one.peer for one in asked if not all(program.exists() for program in one.programs())}


def there_of(setting: Setting, left_out: set[str]) -> tuple[Line, ...]:
    return tuple(line for line in setting.lines if line.candidate.peer not in left_out)


def complain(missing: set[str]) -> None:
    print(
        f"\nbench-peers: NOT MEASURED, not there or broken: {', '.join(sorted(missing))}.\n"
        "bench-peers: above is why; or leave them out: "
        f'make bench-peers BENCH="{" ".join(f"--without {peer}" for peer in sorted(missing))}"',
        file=sys.stderr,
        flush=True,
    )


def main() -> int:
    given = words()
    pace = SMOKE if given.smoke else QUICK if given.quick else FULL
    if given.rounds is not None:
        pace = Pace(given.rounds, pace.seconds, pace.rests)
    if len(os.sched_getaffinity(0)) < 2:
        sys.exit("bench-peers: needs two cores; this program may use one")
    everybody = candidates(given.build.resolve())
    known = {peer.peer for peer in everybody.peers()}
    unknown = set(given.without) - known - {"all"}
    if unknown:
        sys.exit(f"bench-peers: {unknown.pop()} is no peer: all, {', '.join(sorted(known))}")
    without = known if "all" in given.without else set(given.without)
    wanted = [setting for setting in settings(everybody) if setting.title.startswith(given.only)]
    if not wanted:
        sys.exit(f"bench-peers: no setting's title begins with {given.only!r}")
    missing = missing_of(wanted) - without
    if "" in missing:
        sys.exit(f"bench-peers: {given.build} has no programs of ours; run make bench-peers")
    if missing:
        complain(missing)

    print(report.machine(pace), flush=True)
    judged: list[tuple[Setting, Verdict]] = []
    with own_laboratory(given.build.resolve()) as env:
        for setting in wanted:
            there = there_of(setting, without | missing)
            done = run(setting, there, pace, env)
            missing |= {line.candidate.peer for line in there if line.label not in done.rounds}
            print("\n" + report.table(setting, done), flush=True)
            judged += [(setting, judge(bar, done.rounds)) for bar in setting.bars]
    print("\n" + report.bars(judged), flush=True)
    if missing:
        complain(missing)
        return MISSING
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Broken as why:
        sys.exit(f"bench-peers: {why}")
