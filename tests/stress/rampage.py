"""A laboratory whose programs are killed at random instants, and the checks of its history."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import history
from hosts import Hosts
from lateness import Lateness, now_ns

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "system"))  # processes.py

from processes import Program, await_ends, until  # noqa: E402

SHORTEST_FREEZE_S = 0.05
MOST_LATE = 0.5
"""Part of a run. Time in which the machine was late counts towards no bound: of a machine that is
late for longer, too little is judged."""
ROLES_FROZEN = {"server": 4, "client": 2, "server client": 3, "broker": 1}


@dataclass(frozen=True, slots=True)
class Plan:
    """The disturbances of one laboratory."""

    medium: str
    seed: int
    kills: int = 0
    victims: Mapping[str, int] = field(default_factory=dict)
    """Role to weight, of those that are killed; all others live to the end."""
    pause_s: float = 0.05
    """Between two kills, or freezes, on average."""
    rest_ms: int = 10
    """A client's longest rest between the calls that it issues."""
    freezes: int = 0
    """How often programs stand still for a while, by SIGSTOP and SIGCONT."""
    frozen: Mapping[str, int] = field(default_factory=dict)
    """Roles that stand still together, "server client", to weight."""
    longest_freeze_s: float = 2.0
    clients: int = 3
    waiters: int = 0
    """Clients in C++, and as many in Python, that are blocked in wait() without time-out."""
    children: bool = False
    """Each server has forked a child that outlives it, with all its descriptors."""
    python_clients: int = 0
    python_server: bool = False
    cuts: int = 0
    """How often the line between the host of the server and that of all clients is cut."""
    longest_cut_s: float = 2.0
    faults: str = ""
    zone: bool = False
    """The server is in a zone in which a person comes and leaves."""
    pretends: str = ""
    """A request that clients note as done and do not send, for a test of the judge: take, master,
    password or break."""
    change: str = ""
    """The only change of status that clients make, and they make it often: take, master, password
    or break. If empty, they make all four, rarely; but `pretends` is made often, too."""
    preload: Path | None = None


class Role:
    """One place in the laboratory, and the program that fills it now."""

    def __init__(
        self, name: str, command: Callable[[], Sequence[str]], env: Mapping[str, str]
    ) -> None:
        self.name = name
        self._command = command
        self._env = dict(env)
        self.start()

    def start(self) -> None:
        self.program = Program(self._command(), self._env)
        self._ready = False

    def wait_ready(self) -> None:
        if not self._ready:
            self.program.wait_for("ready")
        self._ready = True

    def kill(self) -> int:
        """Kills the program and returns the time in ns when it was gone."""
        assert self.program.running(), f"it ended by itself: {self.program}"
        return self.program.kill()

    def end(self) -> None:
        """Ends the program in order, with SIGTERM."""
        self.program.signal(signal.SIGTERM)
        self.finish()

    def finish(self) -> None:
        """Waits for the end of the program, which was asked to end, and checks its status."""
        status = self.program.finish()
        assert status == 0, f"it ended with {status}: {self.program}"


class Rampage:
    """Starts a laboratory, does what the plan says, and ends it in order."""

    def __init__(
        self,
        plan: Plan,
        build: Path,
        records: Path,
        env: Mapping[str, str],
        hosts: Hosts | None = None,
    ) -> None:
        self.plan = plan
        self.records = records
        self._hosts = hosts
        self.roles: list[Role] = []
        self._random = random.Random(plan.seed)
        self._programs = build / "tests" / "stress"
        self._broker = build / "runtime" / "cpp" / "gecos" / "broker" / "gecos-broker"
        # A Unix socket's name has at most 107 characters, so the socket is not below `records`.
        self.place = Path(tempfile.mkdtemp(prefix="gecos-"))
        # Its own broker only, however long that stands still: others run beside it.
        here = {"GECOS_RUNTIME_DIR": str(self.place), "GECOS_BROKER": "shm"}
        self._env = {**os.environ, **env, **here}
        if plan.preload is not None:
            self._env["LD_PRELOAD"] = str(plan.preload)
        self._orphaned: list[int] = []
        """Groups of killed servers in which a child lives on; nobody else gets their numbers."""
        self._clients = 0
        self._servers = 0
        self._zones = 0
        if plan.zone:
            lab_file = self.place / "lab.toml"
            lab_file.write_text('[objects.BENCH]\nzone = "CELL"\n')
            self._env["GECOS_LAB_FILE"] = str(lab_file)

    # What the roles are played by

    def _client(self, program: Sequence[str]) -> list[str]:
        self._clients += 1
        return [
            *program,
            f"number={self._clients}",
            f"record={self.records / f'client.{self._clients}.log'}",
            f"medium={self.plan.medium}",
            f"faults={self.plan.faults}",
            f"rest_ms={self.plan.rest_ms}",
            f"pretends={self.plan.pretends}",
            f"change={self.plan.change or self.plan.pretends}",
            f"seed={self._random.randrange(1 << 30)}",
        ]

    def _whole(self) -> list[str]:
        """The command of a client that also serves."""
        self._servers += 1
        program = [sys.executable, str(HERE / "programs" / "client.py")]
        if not self.plan.python_server:
            program = [str(self._programs / "stress_client")]
        return [*self._client(program), f"serve={self.records / f'server.{self._servers}.log'}"]

    def _server(self) -> list[str]:
        self._servers += 1
        in_python = [sys.executable, str(HERE / "programs" / "server.py")]
        return [
            *(
                ["setsid"] if self.plan.children else []
            ),  # a process group of its own, which its child stays in
            *(in_python if self.plan.python_server else [str(self._programs / "stress_server")]),
            f"record={self.records / f'server.{self._servers}.log'}",
            f"medium={self.plan.medium}",
            f"faults={self.plan.faults}",
            *(["child=yes"] if self.plan.children else []),
        ]

    def _zone(self) -> list[str]:
        self._zones += 1
        return [
            sys.executable,
            str(HERE / "programs" / "zone.py"),
            f"record={self.records / f'zone.{self._zones}.log'}",
            f"medium={self.plan.medium}",
            f"seed={self._random.randrange(1 << 30)}",
        ]

    def add(self, name: str, command: Callable[[], Sequence[str]]) -> Role:
        env = self._env
        if self._hosts is not None:
            host = 0 if name in ("broker", "server") else 1
            before = self._hosts.on(host)
            on_this_host, command = command, lambda: [*before, *on_this_host()]
            place = self.place / str(host)
            place.mkdir(exist_ok=True, mode=0o700)
            env = {**env, "GECOS_RUNTIME_DIR": str(place), "GECOS_LCM_TTL": "1"}
            env["GECOS_BROKER"] = "lcm"
        role = Role(name, command, env)
        self.roles.append(role)
        return role

    def add_broker(self) -> None:
        self.add("broker", lambda: [str(self._broker)]).wait_ready()

    def start(self) -> None:
        cpp = [str(self._programs / "stress_client")]
        python = [sys.executable, str(HERE / "programs" / "client.py")]
        self.add_broker()
        if self.plan.medium == "inproc":
            self.add("whole", self._whole).wait_ready()
            return
        if self.plan.zone:
            self.add("zone", self._zone).wait_ready()
        self.add("server", self._server).wait_ready()
        if not self.plan.waiters:
            self.add("witness", lambda: self._client(cpp)).wait_ready()
        for _ in range(self.plan.clients):
            self.add("client", lambda: self._client(cpp))
        for _ in range(self.plan.python_clients):
            self.add("client", lambda: self._client(python))
        waiting = [sys.executable, str(HERE / "programs" / "waiter.py")]
        for _ in range(self.plan.waiters):
            self.add("waiter", lambda: self._client([str(self._programs / "stress_waiter")]))
            self.add("waiter", lambda: self._client(waiting))
        if self.plan.waiters:
            self._await_ready("waiter")

    # What is done to them

    def _pause(self) -> None:
        """Sleeps for a random time, so that the next disturbance comes at a random instant."""
        time.sleep(self._random.expovariate(1 / self.plan.pause_s))

    def _victim(self) -> Role:
        weights = [
            self.plan.victims.get(role.name, 0) / self._count(role.name) for role in self.roles
        ]
        return self._random.choices(self.roles, weights)[0]

    def _count(self, name: str) -> int:
        return sum(role.name == name for role in self.roles)

    def kill(self) -> None:
        waits = 0
        for _ in range(self.plan.kills):
            if self.plan.waiters:
                waits = self._await_more_waits(waits)
            self._pause()
            self._kill(self._victim())

    def _await_more_waits(self, before: int) -> int:
        """Returns, once a waiter waits for the present server, how often one has waited so far."""
        self._await_ready("server")

        def waits() -> int:
            records = self.records.glob("client.*.log")
            return sum(record.read_text().count(" issue ") for record in records)

        until(lambda: waits() > before, "a waiter waits for the server")
        return waits()

    def _kill(self, victim: Role) -> None:
        pid = victim.program.pid
        with (self.records / "kills.log").open("a") as kills:
            kills.write(f"{victim.kill()} kill {pid}\n")
        self._note_orphan(pid)
        victim.start()

    def _note_orphan(self, killed: int) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(killed, 0)
            self._orphaned.append(killed)

    def _record_of(self, pid: int) -> str:
        """What the client with that pid has noted; empty before it has begun."""
        texts = (path.read_text() for path in self.records.glob("client.*.log"))
        return next((text for text in texts if f" client {pid}\n" in text), "")

    def kill_in_motion(self) -> None:
        """Kills each client while the server runs the motion of its take-over."""
        for client in self._filling("client"):
            until(functools.partial(self._dies_in_motion, client), "a client is killed in motion")

    def _dies_in_motion(self, client: Role) -> bool:
        """Kills the client if it moves now. Returns whether it saw no end of its motion."""
        pid = client.program.pid
        motion = self._motion(self._record_of(pid))
        if motion is None:
            return False
        self._kill(client)
        return f" end {motion} " not in self._record_of(pid)

    def _motion(self, record: str) -> str | None:
        """The motion that the server runs now for a client that has taken over."""
        before, _, last_issued = record.rpartition(" issue ")
        last = re.match(r"(\d+) file ", last_issued)
        if last is None or re.search(r" did \d+ take\n\d+\Z", before) is None:
            return None
        motion = last[1]
        served = "".join(log.read_text() for log in self.records.glob("server.*.log"))
        runs = f" start {motion} " in served and f" finish {motion} " not in served
        return motion if runs else None

    def _await_ready(self, name: str) -> None:
        for role in self.roles:
            if role.name == name:
                role.wait_ready()

    def freeze(self) -> None:
        """Freezes programs at random instants, for the lengths of the plan."""
        sets = list(self.plan.frozen)
        for length in self._lengths():
            self._pause()
            roles = self._random.choices(sets, list(self.plan.frozen.values()))[0].split()
            self._freeze([self._random.choice(self._filling(name)) for name in roles], length)

    def _lengths(self) -> list[float]:
        """Lengths of freezes in s: equally distributed in the logarithm, one near the longest."""
        steps = [
            (step + self._random.random()) / self.plan.freezes for step in range(self.plan.freezes)
        ]
        self._random.shuffle(steps)
        ratio = self.plan.longest_freeze_s / SHORTEST_FREEZE_S
        return [SHORTEST_FREEZE_S * ratio**step for step in steps]

    def _freeze(self, victims: Sequence[Role], length: float) -> None:
        pids = [victim.program.pid for victim in victims]
        for victim in victims:
            victim.program.signal(signal.SIGSTOP)
        until(lambda: all(stands_still(pid) for pid in pids), f"{pids} stand still")
        began = now_ns()
        time.sleep(length)
        ends = now_ns()
        for victim in self._random.sample(victims, len(victims)):
            victim.program.signal(signal.SIGCONT)
        with (self.records / "kills.log").open("a") as freezes:
            freezes.writelines(f"{began} freeze {pid} {ends}\n" for pid in pids)

    def cut(self) -> None:
        """Cuts the network at random instants, each time for a random duration."""
        for _ in range(self.plan.cuts if self._hosts is not None else 0):
            assert self._hosts is not None
            self._pause()
            begin = self._hosts.cut()
            time.sleep(self._random.uniform(0.05, self.plan.longest_cut_s))
            with (self.records / "kills.log").open("a") as cuts:
                cuts.write(f"{begin} cut {self._hosts.mend()}\n")

    # How it ends

    def end(self) -> None:
        """Ends all programs, in order, and checks that they leave no files or resources behind."""
        self._end_children()
        self._end_waiters()
        for name in "client", "witness", "whole", "server", "zone", "broker":
            self._await_ready(name)
            for role in self.roles:
                if role.name == name:
                    role.end()
                    leftover(role)
        # The broker leaves the names of its host's servers to the broker after it.
        left = [
            str(path)
            for path in self.place.rglob("*")
            if not path.is_dir() and path.name not in ("BROKER.names", "lab.toml")
        ]
        assert not left, f"left behind: {left}"

    def _end_children(self) -> None:
        """Ends children of servers; a server started afterwards clears the resources they held."""
        if not self.plan.children:
            return
        self.plan = dataclasses.replace(self.plan, children=False)
        for server in self._filling("server"):
            self._kill(server)  # the last one with a child
        self._kill_orphaned()
        for server in self._filling("server"):
            self._kill(server)

    def _filling(self, name: str) -> list[Role]:
        return [role for role in self.roles if role.name == name]

    def _kill_orphaned(self) -> None:
        """Kills orphaned children and waits for their end: until then they keep their resources."""
        for group in self._orphaned:
            those = members(group)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(group, signal.SIGKILL)
            await_ends(those)
        self._orphaned = []

    def _end_waiters(self) -> None:
        """Ends the waiters. A waiter ends with its command, so its server must end first."""
        waiters = [role for role in self.roles if role.name == "waiter"]
        for role in waiters:
            role.program.signal(signal.SIGTERM)
        for server in self._filling("server") if waiters else ():
            server.wait_ready()
            self._kill(server)
        for role in waiters:
            role.finish()
            leftover(role)

    def give_up(self) -> None:
        """Leaves nothing running, whatever happened."""
        for role in self.roles:
            if role.program.running():
                role.kill()
                self._note_orphan(role.program.pid)
            role.program.finish()
        self._kill_orphaned()
        shutil.rmtree(self.place, ignore_errors=True)


def members(group: int) -> list[int]:
    """The processes of that process group."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has gone meanwhile
            _state, _parent, of = stat.read_text().rpartition(")")[2].split()[:3]
            if int(of) == group:
                found.append(int(stat.parent.name))
    return found


def stands_still(pid: int) -> bool:
    """Whether every thread of the process is suspended."""
    stats = [stat.read_text() for stat in Path(f"/proc/{pid}/task").glob("[0-9]*/stat")]
    return all(stat.rpartition(")")[2].split()[0] == "T" for stat in stats)


def leftover(role: Role) -> None:
    """Compares what a program had open at its beginning with what it has open at its end."""
    census = {
        line.split()[0]: [int(count) for count in line.split()[1:]]
        for line in role.program.lines
        if line.startswith(("before ", "after "))
    }
    if role.name == "broker":
        return
    before, after = census["before"], census["after"]
    for what, had, has in zip(("descriptors", "threads", "memfds"), before, after, strict=True):
        assert has <= had, (
            f"{role.name} began with {had} {what} and ends with {has}: {role.program}"
        )


@contextlib.contextmanager
def rampage(plan: Plan, build: Path, records: Path, env: Mapping[str, str]) -> Iterator[Rampage]:
    with contextlib.ExitStack() as stack:
        hosts = stack.enter_context(Hosts()) if plan.cuts else None
        lab = Rampage(plan, build, records, env, hosts)
        stack.callback(lab.give_up)
        lab.start()
        yield lab
        lab.end()


def run(plan: Plan, build: Path, records: Path, env: Mapping[str, str]) -> history.History:
    """Carries out the plan; returns the history after checking it."""
    began = now_ns()
    with Lateness(records / "machine.log"), rampage(plan, build, records, env) as lab:
        lab.kill()
        lab.freeze()
        lab.cut()
    told, ended = history.read(records), now_ns()
    late = told.late_s(began, ended) / ((ended - began) * 1e-9)
    assert late < MOST_LATE, f"not judged: a core did not run for {late:.0%} of the time; {plan}"
    findings = history.check(told)
    # The first line stands in the summary of pytest.
    assert not findings, "\n".join([*findings[:20], f"{plan}: {told.summary()}"])
    kinds = Counter(call.state() for client in told.clients for call in client.calls.values())
    assert plan.waiters or kinds["FINISHED"] > 0, f"nothing was carried out: {told.summary()}"
    return told


def run_beside_each_other(
    plans: Sequence[Plan], build: Path, records: Path, env: Mapping[str, str]
) -> list[history.History]:
    """Runs the plans in parallel, each in a laboratory of its own."""
    with ThreadPoolExecutor(len(plans)) as pool:
        running = []
        for number, plan in enumerate(plans):
            here = records / str(number)
            here.mkdir()
            running.append(pool.submit(run, plan, build, here, env))
        return [told.result() for told in running]


def freezing(freezes: int, longest_s: float, seeds: random.Random) -> list[Plan]:
    """Plans for laboratories of all kinds in which programs are suspended, alone and together."""

    def plan(medium: str, **more: Any) -> Plan:
        return Plan(
            medium,
            seeds.randrange(1 << 30),
            freezes=freezes,
            frozen={"whole": 1} if medium == "inproc" else ROLES_FROZEN,
            longest_freeze_s=longest_s,
            pause_s=0.3,
            rest_ms=50,
            **more,
        )

    in_python: dict[str, Any] = {"clients": 0, "python_clients": 1, "python_server": True}
    one_medium, other_medium = seeds.sample(("shm", "lcm"), 2)
    return [
        plan("shm", clients=2),
        plan("lcm", clients=2),
        plan("inproc"),
        plan("shm", **in_python),
        plan("lcm", **in_python),
        plan("inproc", **in_python),
        plan(one_medium, clients=2, python_server=True),
        plan(other_medium, clients=0, python_clients=1),
    ]


def around_a_zone(medium: str, seed: int, kills: int, freezes: int) -> Plan:
    """A laboratory with a zone whose person comes and goes. Programs are killed and suspended, the
    zone most of all."""
    return Plan(
        medium,
        seed,
        kills=kills,
        victims={"zone": 3, "server": 1, "client": 1, "broker": 1},
        freezes=freezes,
        frozen={"zone": 3, "server": 2, "server zone": 2, "client": 1, "broker": 1},
        longest_freeze_s=2.5,
        pause_s=0.6,
        clients=2,
        zone=True,
    )


WORKBENCH = HERE / "idl" / "stress" / "workbench.gidl"


def generate_python(out: Path, interface: Path = WORKBENCH) -> None:
    """Makes the Python of an interface of the tests importable by programs that are started."""
    words = ["-m", "gidl", "gen", "--lang", "python", "-I", HERE / "idl", "--out", out]
    subprocess.run(
        [sys.executable, *words, interface],
        check=True,
        stdout=subprocess.DEVNULL,
    )
