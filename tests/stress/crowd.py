"""A laboratory of many objects and many idle clients: what they cost, and how fast calls are."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "system"))  # processes.py

from processes import Program  # noqa: E402

CONNECTED_WITHIN_S = 10.0
NAMES_BACK_WITHIN_S = 2.0
CLIENT_KIB_IN_SERVER = 64.0
IDLE_PERCENT = 0.05
TIMES_ALONE = 1.2
CALLS = 400
"""A round trip is the median over the rounds of the median of so many calls."""
ASK = """
import sys, gecos
lab, wanted = gecos.Lab(), int(sys.argv[1])
while True:
    try:
        if len(lab.objects(patience=0.1)) == wanted: break
    except gecos.CreateError: pass
print("all", flush=True)
"""


@dataclass(frozen=True, slots=True)
class Crowd:
    """How many of what. The clients of a process connect to as many different objects."""

    medium: str
    objects: int = 100
    servers: int = 20
    clients: int = 1000
    client_processes: int = 50
    idle_s: float = 10.0
    rounds: int = 300
    gatherings: int = 3
    """How often the crowd gathers; each time, the round trip just before counts as that alone."""


@dataclass(frozen=True, slots=True)
class Costs:
    """What was measured, per client where it says so."""

    connected_s: float
    idle_percent: float
    """Processor time of an idle client in its own process, in % of one core."""
    served_percent: float
    """Processor time of an idle client in the process of its server, in % of one core."""
    server_kib: float
    """Memory of a client in the process of its server."""
    alone_us: float
    """Round trip of the only client, which is pinned to a core, as its server is."""
    beside_us: float
    """Round trip of that client while all others are idle. This and `alone_us` are of the gathering
    whose ratio is the median."""
    names_back_s: float

    def __str__(self) -> str:
        return (
            f"connected in {self.connected_s:.2f} s; an idle client takes {self.idle_percent:.4f} %"
            f" of a core, and {self.served_percent:.4f} % and {self.server_kib:.1f} KiB in its"
            f" server; round trip of pinned programs {self.beside_us:.1f} us beside them,"
            f" {self.alone_us:.1f} us alone"
            f" ({self.beside_us / self.alone_us:.2f} times);"
            f" names back in {self.names_back_s:.2f} s"
        )

    def broken_bounds(self, *, quiet: bool) -> list[str]:
        """The promised bounds that were not kept. Those of processor time and of round trips are
        judged only if the machine was `quiet`: other programs would change both."""
        bounds = [
            ("seconds until all are connected", self.connected_s, CONNECTED_WITHIN_S),
            ("seconds until a new broker has all names", self.names_back_s, NAMES_BACK_WITHIN_S),
            ("KiB of a client in its server", self.server_kib, CLIENT_KIB_IN_SERVER),
        ]
        if quiet:
            bounds += [
                ("% of a core of an idle client", self.idle_percent, IDLE_PERCENT),
                (
                    "a round trip beside idle clients, in those of the only client",
                    self.beside_us / self.alone_us,
                    TIMES_ALONE,
                ),
            ]
        return [f"{what}: {is_:.4g}, at most {most:g}" for what, is_, most in bounds if is_ > most]


def processor_s(programs: Sequence[Program]) -> float:
    """The processor time that the programs have taken so far."""
    ticks = 0
    for program in programs:
        stat = Path(f"/proc/{program.pid}/stat").read_text().rpartition(")")[2].split()
        ticks += int(stat[11]) + int(stat[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def resident_kib(programs: Sequence[Program]) -> float:
    pages = sum(int(Path(f"/proc/{one.pid}/statm").read_text().split()[1]) for one in programs)
    return pages * os.sysconf("SC_PAGE_SIZE") / 1024


class Laboratory:
    """Its programs end with `stack`."""

    def __init__(
        self, crowd: Crowd, build: Path, env: Mapping[str, str], stack: contextlib.ExitStack
    ) -> None:
        self._crowd = crowd
        self._build = build
        self._stack = stack
        place = tempfile.mkdtemp(prefix="gecos-")
        stack.callback(shutil.rmtree, place, ignore_errors=True)
        self.env = {**os.environ, **env, "GECOS_RUNTIME_DIR": place, "GECOS_BROKER": "shm"}
        self.names = [f"BENCH{number}" for number in range(crowd.objects)]

    def start(self, command: Sequence[str | Path], *, listens: bool = False) -> Program:
        program = Program(command, self.env, listens)
        self._stack.callback(_end, program)
        return program

    def broker(self) -> Program:
        broker = self.start([self._build / "runtime/cpp/gecos/broker/gecos-broker"])
        broker.wait_for("ready")
        return broker

    def servers(self) -> list[Program]:
        each = self._crowd.objects // self._crowd.servers
        serving = [
            self._member(
                f"serve={','.join(self.names[first : first + each])}",
                core=None if first else min(os.sched_getaffinity(0)),
            )
            for first in range(0, self._crowd.objects, each)
        ]
        for server in serving:
            server.wait_for("ready")
        return serving

    def clients(self) -> list[Program]:
        """Starts all at once; each begins with another object."""
        each = self._crowd.clients // self._crowd.client_processes
        return [
            self._member(
                f"reach={','.join(self.names[first:] + self.names[:first])}", f"clients={each}"
            )
            for first in (
                number * each % len(self.names) for number in range(self._crowd.client_processes)
            )
        ]

    def one_client(self) -> Program:
        """A client outside the crowd. It and its server are each pinned to a core, which the crowd
        uses, too: without that their round trip over lcm was 1.25 times that without a crowd on two
        cores, because the scheduler moved them."""
        client = self._member(
            f"reach={self.names[0]}", "clients=1", core=max(os.sched_getaffinity(0))
        )
        client.wait_for("ready")
        return client

    def _member(self, *words: str, core: int | None = None) -> Program:
        program = self._build / "tests" / "stress" / "stress_crowd"
        pinned = [] if core is None else ["taskset", "-c", str(core)]
        return self.start([*pinned, program, *words, f"medium={self._crowd.medium}"], listens=True)


def _end(program: Program) -> None:
    if program.running():
        program.kill()
    else:
        program.finish()


@contextlib.contextmanager
def many_files() -> Iterator[None]:
    """Lets programs that start meanwhile open as many files as the machine permits: a process that
    reaches 1,000 objects over lcm opens some 7,000."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (before[1], before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def round_trip_us(client: Program, rounds: int) -> float:
    medians = []
    for _ in range(rounds):
        client.tell(f"call {CALLS}")
        medians.append(float(client.wait_for("median").split()[1]))
    return statistics.median(medians)


def measure(crowd: Crowd, build: Path, env: Mapping[str, str]) -> Costs:
    """Starts the laboratory and measures it; the broker is killed and replaced at the end."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(many_files())
        laboratory = Laboratory(crowd, build, env, stack)
        broker = laboratory.broker()
        servers = laboratory.servers()
        caller = laboratory.one_client()
        round_trip_us(caller, 1)  # the first calls fill caches

        clients: list[Program] = []
        trips: list[tuple[float, float]] = []
        connected_s, kib = 0.0, []
        for _ in range(crowd.gatherings):
            _dismiss(clients)
            alone_us, kib_before = round_trip_us(caller, crowd.rounds), resident_kib(servers)
            clients, took_s = _gather(laboratory)
            connected_s = max(connected_s, took_s)
            kib.append((resident_kib(servers) - kib_before) / crowd.clients)
            trips.append((alone_us, round_trip_us(caller, crowd.rounds)))
        trips.sort(key=lambda trip: trip[1] / trip[0])
        alone_us, beside_us = trips[len(trips) // 2]

        before = processor_s(clients), processor_s(servers)
        time.sleep(crowd.idle_s)  # the time over which processor time is counted
        own_s, served_s = processor_s(clients) - before[0], processor_s(servers) - before[1]
        percent = 100 / crowd.idle_s / crowd.clients

        broker.kill()
        began = time.monotonic()
        laboratory.broker()
        names_back_s = _names_back(laboratory, began)
        return Costs(
            connected_s,
            own_s * percent,
            served_s * percent,
            max(kib),  # those of the first crowd: later ones reuse its memory
            alone_us,
            beside_us,
            names_back_s,
        )


def _gather(laboratory: Laboratory) -> tuple[list[Program], float]:
    """Starts a crowd. Returns its programs when all are connected, and how long that took, in s."""
    began = time.monotonic()
    clients = laboratory.clients()
    for client in clients:
        client.wait_for("ready", patience=10 * CONNECTED_WITHIN_S)
    return clients, time.monotonic() - began


def _dismiss(clients: Sequence[Program]) -> None:
    """Closes the input of all clients, so that each says goodbye to its servers, and waits for
    their ends."""
    for client in clients:
        client.end_of_input()
    for client in clients:
        assert client.finish() == 0


def _names_back(laboratory: Laboratory, began: float) -> float:
    """Asks the broker until it has all names; in a process that has the laboratory's settings."""
    laboratory.start([sys.executable, "-c", ASK, str(len(laboratory.names))]).wait_for("all")
    return time.monotonic() - began
