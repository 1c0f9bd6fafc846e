"""Checks the records of killed programs: did every command end, once, with the server's answer?

A record is a text file, a line per event, written by one program. Each begins with a time, ns of
CLOCK_BOOTTIME, which all programs share. Of a client:

    client <pid>                                     of its process
    issue <command> <operation> <session> <wanted>   before it is sent; `wanted` is the right answer
    open <session> <pid>                             a session with the server of that pid
    see <command> <STATE> <DETAIL>                   looked at
    end <command> <STATE> <DETAIL> <result>          waited for; "-": no result
    granted <session> <ACTOR|MASTER> [password]      it has a status now; without password: the
                                                     common one
    send <sample> <session>                          before it sends a sample
    released <session>                               it has released its status
    asks <session> <take|give|stop|break>            before it asks for that
    did <session> <take|give|stop|break>             once the server has done it
    done                                             it ended in order, all its commands had

Of a server:

    serve <pid>
    start <command> <operation> <marked>             its handler begins; in the order of lines.
                                                     `marked`: when the server marked its start
    finish <command> <operation> <result>            it returns; "-": it was interrupted
    take <sample> <before>                           it takes a sample; asked for it at `before`
    done

Of the test itself: `kill <pid>`, once the process is gone; `cut <end>`, the begin and end of a cut
of the network between all clients and all servers; `freeze <pid> <end>`, once the process was
suspended, and when it was resumed. Of the watchers of the cores: `late <woken>`, when one should
have woken, and when it did. A command is named by the number of its client (upper half) and its own
(lower half); both rise.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import statuses
import zones
from lateness import WORTH_NOTING_S
from statuses import ACTOR, Act, Grant

BOUND_S = 1.5
"""grace + 0.5 s: when commands of a killed server have ended at the latest."""

LONGEST_INTERRUPTION_NS = 50_000_000
"""A thread may wait this long for a processor without the watcher of the machine being late. The
stamp of a mark may also be one tick of the kernel too early."""
IN_ORDER = ACTOR | {"gauge"}
IDEMPOTENT = frozenset({"look"})
"""Sent again when its session was lost, so it may start once in each server's life."""
LOST = frozenset({"SERVER_CRASHED", "OUTCOME_UNKNOWN", "NO_SERVER", "NOT_STARTED"})
"""Details that say: nobody answered."""
NOT_STARTED = frozenset({"REJECTED", "DENIED", "QUEUE_FULL", "EXPIRED"})
"""Details of COMMAND_FAILED that say: it was not carried out (where it was sent last)."""


@dataclass(slots=True)
class Call:
    """A client's record of one command."""

    command: int
    operation: str
    session: int
    wanted: str
    issued: int
    sent: int | None = None
    """When it had certainly been sent: its program went on."""
    seen: list[tuple[int, str, str]] = field(default_factory=list)
    ended: int | None = None
    result: str = "-"
    waited_out: bool = False

    def terminal(self) -> set[tuple[str, str]]:
        return {(state, detail) for _, state, detail in self.seen if state != "RUNNING"}

    def state(self) -> str:
        return next((state for _, state, _ in self.seen if state != "RUNNING"), "RUNNING")

    def detail(self) -> str:
        return next((detail for _, state, detail in self.seen if state != "RUNNING"), "")

    def told(self) -> int | None:
        """The latest time at which the client knew the end of the command."""
        return next((time for time, state, _ in self.seen if state != "RUNNING"), None)


@dataclass(slots=True)
class Client:
    name: str
    calls: dict[int, Call] = field(default_factory=dict)
    servers: dict[int, int] = field(default_factory=dict)
    samples: dict[int, Call] = field(default_factory=dict)
    grants: list[Grant] = field(default_factory=list)
    acts: list[Act] = field(default_factory=list)
    pid: int = 0
    done: bool = False


class Start(NamedTuple):
    """The start of a handler, as its server recorded it."""

    command: int
    operation: str
    marked: int
    began: int


class Freeze(NamedTuple):
    """The suspension of a process from one time to another."""

    pid: int
    begin: int
    end: int


@dataclass(slots=True)
class Server:
    """One life of a server."""

    name: str
    pid: int = 0
    events: list[tuple[str, int, str, str]] = field(default_factory=list)
    """Event, command, operation and result, in the order in which they happened."""
    starts: list[Start] = field(default_factory=list)
    taken: list[tuple[int, int, int]] = field(default_factory=list)
    """Sample, and the times between which it was judged."""
    returned: dict[int, int] = field(default_factory=dict)
    """When the handler of a command returned."""

    def interrupted(self) -> set[int]:
        return {
            command
            for event, command, _, result in self.events
            if event == "finish" and result == "-"
        }


@dataclass(slots=True)
class History:
    clients: list[Client] = field(default_factory=list)
    servers: list[Server] = field(default_factory=list)
    zones: list[zones.Zone] = field(default_factory=list)
    kills: dict[int, int] = field(default_factory=dict)
    """When the process of that pid was gone."""
    cuts: list[tuple[int, int]] = field(default_factory=list)
    freezes: list[Freeze] = field(default_factory=list)
    late: list[tuple[int, int]] = field(default_factory=list)
    """From when until when a watcher of a core, which only wanted to wake, was not let run."""

    def late_s(self, begin: int, end: int) -> float:
        """Seconds between `begin` and `end` in which one of the cores did not run its watcher."""
        return sum(max(0, min(end, woken) - max(begin, due)) for due, woken in self.late) * 1e-9

    def awake_s(self, pid: int, begin: int, end: int) -> float:
        """Seconds between two times in which the process was not suspended and no core late."""
        frozen = sum(
            max(0, min(end, freeze.end) - max(begin, freeze.begin))
            for freeze in self.freezes
            if freeze.pid == pid
        )
        return (end - begin - frozen) * 1e-9 - self.late_s(begin, end)

    def summary(self) -> str:
        calls = [call for client in self.clients for call in client.calls.values()]
        outcomes = Counter(call.detail() or "client killed" for call in calls)
        told = ", ".join(f"{count} {what}" for what, count in outcomes.most_common())
        again = f", {self.sent_again()} of them by another server" if self.sent_again() else ""
        done = f"{len(self.kills)} kills, {len(self.cuts)} cuts"
        if self.freezes:
            longest = max(freeze.end - freeze.begin for freeze in self.freezes) * 1e-9
            done += f", {len(self.freezes)} freezes of up to {longest:.1f} s"
        worst = max((woken - due for due, woken in self.late), default=0) * 1e-9
        in_all = sum(woken - due for due, woken in self.late) * 1e-9
        late = f", machine up to {worst:.2f} s late, {in_all:.2f} s in all" if worst else ""
        between = sum(1 for _ in self.frozen_before_they_began())
        apart = f", {between} frozen between mark and handler" if between else ""
        status = statuses.figures(self).text()
        return f"{done}, {len(calls)} commands ({told}{again}){status}{apart}{late}"

    def begun_in_vain(self) -> Iterator[tuple[Server, Start, Call]]:
        """Handlers that began after their client had already seen the end of the command."""
        calls = {number: call for client in self.clients for number, call in client.calls.items()}
        for server in self.servers:
            for start in server.starts:
                call = calls.get(start.command)
                if call is not None and start.began > (call.told() or start.began):
                    yield server, start, call

    def frozen_before_they_began(self) -> Iterator[tuple[Freeze, Start]]:
        """Calls whose client got no answer because a freeze came between mark and handler."""
        for server, start, call in self.begun_in_vain():
            freeze = self.freeze_between(server, start)
            if freeze is not None and call.detail() in LOST:
                yield freeze, start

    def freeze_between(self, server: Server, start: Start) -> Freeze | None:
        """The freeze that kept a handler from beginning after its start was marked."""
        return next(
            (
                freeze
                for freeze in self.freezes
                if freeze.pid == server.pid
                and start.marked <= freeze.begin
                and freeze.end <= start.began
            ),
            None,
        )

    def was_held_up(self, server: Server, start: Start) -> bool:
        """Whether the handler could not begin when its start was marked."""
        late_ns = self.late_s(start.marked, start.began) * 1e9
        interrupted = start.began - start.marked - late_ns <= LONGEST_INTERRUPTION_NS
        return interrupted or self.freeze_between(server, start) is not None

    def sent_again(self) -> int:
        """How many commands were carried out by another server than that of their session."""
        carried_out = {
            command: server.pid
            for server in self.servers
            for event, command, _, _ in server.events
            if event == "finish"
        }
        return sum(
            carried_out.get(call.command, here) != here
            for client in self.clients
            for call in client.calls.values()
            for here in (client.servers.get(call.session),)
            if call.state() == "FINISHED" and here is not None
        )


def lines_of(path: Path) -> Iterator[list[str]]:
    """Lines of a record, without a last line that its writer's death cut off."""
    for line in path.read_text().splitlines(keepends=True):
        if line.endswith("\n"):
            yield line.split()


def note_status(client: Client, time: int, event: str, rest: list[str]) -> bool:
    """Reads a line about a status. False: it is none."""
    match event, rest:
        case "client", [pid]:
            client.pid = int(pid)
        case "granted", [session, status, *password]:
            client.grants.append(Grant(time, int(session), status, *password))
        case "released", [session]:
            client.grants.append(Grant(time, int(session), ""))
        case "asks", [session, what]:
            client.acts.append(Act(what, int(session), time))
        case "did", [_, _]:
            client.acts[-1].end = time
        case _:
            return False
    return True


def read_client(name: str, lines: Iterable[list[str]]) -> Client:
    client = Client(name)
    last: Call | None = None
    for time, event, *rest in lines:
        if last is not None and event not in ("see", "end"):  # these are of other threads
            last.sent, last = int(time), None
        match event, rest:
            case "issue", [command, operation, session, wanted]:
                number = int(command)
                last = Call(number, operation, int(session), wanted, int(time))
                client.calls[number] = last
            case "send", [sample, session]:
                last = Call(int(sample), "push", int(session), "", int(time))
                client.samples[last.command] = last
            case "open", [session, pid]:
                client.servers[int(session)] = int(pid)
            case "see", [command, state, detail]:
                client.calls[int(command)].seen.append((int(time), state, detail))
            case "end", [command, state, detail, result]:
                call = client.calls[int(command)]
                call.seen.append((int(time), state, detail))
                call.ended, call.result = int(time), result
                call.waited_out = state != "RUNNING"
            case "done", []:
                client.done = True
            case _ if not note_status(client, int(time), event, rest):
                raise ValueError(f"{name}: no line of a client: {event} {rest}")
    return client


def read_server(name: str, lines: Iterable[list[str]]) -> Server:
    server = Server(name)
    for time, event, *rest in lines:
        match event, rest:
            case "start", [command, operation, marked]:
                server.events.append(("start", int(command), operation, ""))
                server.starts.append(Start(int(command), operation, int(marked), int(time)))
            case "finish", [command, operation, result]:
                server.events.append(("finish", int(command), operation, result))
                server.returned[int(command)] = int(time)
            case "take", [sample, before]:
                server.taken.append((int(sample), int(before), int(time)))
            case "serve", [pid]:
                server.pid = int(pid)
            case "done", []:
                pass
            case _:
                raise ValueError(f"{name}: no line of a server: {event} {rest}")
    return server


def read(directory: Path) -> History:
    """client.*.log, server.*.log, zone.*.log, kills.log and machine.log of one run."""
    history = History()
    for path in sorted(directory.glob("client.*.log")):
        history.clients.append(read_client(path.name, lines_of(path)))
    for path in sorted(directory.glob("server.*.log")):
        history.servers.append(read_server(path.name, lines_of(path)))
    for path in sorted(directory.glob("zone.*.log")):
        history.zones.append(zones.read_zone(path.name, lines_of(path)))
    kills = directory / "kills.log"
    for time, event, *rest in lines_of(kills) if kills.exists() else ():
        match event, rest:
            case "kill", [pid]:
                history.kills[int(pid)] = int(time)
            case "cut", [end]:
                history.cuts.append((int(time), int(end)))
            case "freeze", [pid, end]:
                history.freezes.append(Freeze(int(pid), int(time), int(end)))
            case _:
                raise ValueError(f"kills.log: no line of who kills: {event} {rest}")
    machine = directory / "machine.log"
    for due, _, woken in lines_of(machine) if machine.exists() else ():
        history.late.append((int(due), int(woken)))
    return history


def check(history: History, bound_s: float = BOUND_S) -> list[str]:
    """The errors of a history, one sentence each; empty if it is right."""
    calls = {number: call for client in history.clients for number, call in client.calls.items()}
    return [
        *executed_at_most_once(history),
        *ended_once(history),
        *nothing_lost(history, bound_s),
        *nothing_invented(history, calls),
        *in_order(history, calls),
        *one_at_a_time(history),
        *begun_for_a_live_caller(history),
        *statuses.check(history, bound_s),
        *zones.check(history),
    ]


def executed_at_most_once(history: History) -> Iterator[str]:
    for event in "start", "finish":
        times = Counter(
            (command, server.name if operation in IDEMPOTENT else "")
            for server in history.servers
            for what, command, operation, _ in server.events
            if what == event
        )
        for (command, server_name), count in times.items():
            if count > 1:
                where = f" in {server_name}" if server_name else ""
                yield f"command {command}: {count} times '{event}'{where}"


def ended_once(history: History) -> Iterator[str]:
    for client in history.clients:
        for call in client.calls.values():
            over = False
            for _, state, _detail in call.seen:
                if over and state == "RUNNING":
                    yield f"command {call.command} of {client.name} runs again after its end"
                over = over or state != "RUNNING"
            if len(call.terminal()) > 1:
                ends = ", ".join(f"{state}/{detail}" for state, detail in sorted(call.terminal()))
                yield f"command {call.command} of {client.name} ended as {ends}"


def nothing_lost(history: History, bound_s: float) -> Iterator[str]:
    for client in history.clients:
        for call in client.calls.values():
            if call.ended is None:
                if client.done:
                    yield f"command {call.command} of {client.name} has no end"
                continue
            if not call.waited_out:
                yield f"command {call.command} of {client.name} was waited for and still runs"
            for lost, what in losses(history, client, call, bound_s):
                begin = max(lost, call.issued)
                took = (call.ended - begin) * 1e-9
                still = history.late_s(begin, call.ended)
                # A wake-up that was less late than is worth noting is in no record.
                if took - still > bound_s + WORTH_NOTING_S:
                    yield (
                        f"command {call.command} of {client.name} ended as {call.detail()}"
                        f" {took:.3f} s after its {what}; promised are {bound_s} s"
                        + (f"; the machine stood still for {still:.3f} s of them" if still else "")
                    )


def losses(
    history: History, client: Client, call: Call, bound_s: float
) -> Iterator[tuple[int, str]]:
    """The events, with their times, that must have ended `call` unless it ended before."""
    if call.operation in IDEMPOTENT:
        # A call goes from server to server. If the last one has answered, there is no such bound.
        killed = max(
            (
                history.kills[server.pid]
                for server in history.servers
                if history.kills.get(server.pid, call.ended or 0) < (call.ended or 0)
            ),
            default=None,
        )
        if killed is not None and call.detail() in LOST:
            lived = last_life_of_a_frozen_server(history, call)
            if lived > killed:
                yield lived, "last server stood still"
            else:
                yield killed, "last server was killed"
    else:
        killed = history.kills.get(client.servers.get(call.session, 0))
        if killed is not None:
            yield killed, "server was killed"
    for begin, end in history.cuts:
        lasts = (end - begin) * 1e-9 > bound_s
        if lasts and call.issued < end and (call.ended is None or call.ended > begin):
            yield begin, "line was cut"


def last_life_of_a_frozen_server(history: History, call: Call) -> int:
    """When a server that was suspended while the call was open, and not killed, ran for the last
    time before the call ended: the call may have been sent to it. 0 if there is none."""
    ended = call.ended or 0
    alive = [each.pid for each in history.servers if history.kills.get(each.pid, ended) >= ended]
    times = (time for each in history.freezes if each.pid in alive for time in each[1:])
    return max((time for time in times if call.issued < time <= ended), default=0)


def nothing_invented(history: History, calls: dict[int, Call]) -> Iterator[str]:
    started: set[int] = set()
    finished: dict[int, str] = {}
    for server in history.servers:
        for event, command, operation, result in server.events:
            call = calls.get(command)
            if call is None:
                yield f"{server.name}: command {command} was never issued"
                continue
            if call.operation != operation:
                yield f"{server.name}: command {command} was {call.operation}, not {operation}"
            if event == "start":
                started.add(command)
            elif command not in started:
                yield f"{server.name}: command {command} finished and had not started"
            else:
                finished[command] = result
    for call in calls.values():
        state, detail = call.state(), call.detail()
        if state == "FINISHED":
            if finished.get(call.command, "-") == "-":
                yield f"command {call.command} is FINISHED, its handler did not finish"
            elif call.ended is not None and call.result != call.wanted:
                yield f"command {call.command} was given {call.result} in place of {call.wanted}"
        elif call.result != "-":
            yield f"command {call.command} is {state}/{detail} and has a result"
        elif call.command in started and (
            state == "CONNECTION_FAILED"
            or (detail in NOT_STARTED and call.operation not in IDEMPOTENT)
        ):
            yield f"command {call.command} is {state}/{detail}, and was started"
        if finished.get(call.command, "-") not in ("-", call.wanted):
            yield f"command {call.command} reached its handler with other arguments"


def in_order(history: History, calls: dict[int, Call]) -> Iterator[str]:
    """What one session issues for an object's queue starts in that order, and no reading that keeps
    its place starts before a command that was issued before it."""
    for server in history.servers:
        last: dict[tuple[int, int], int] = defaultdict(int)
        for event, command, operation, _ in server.events:
            if event != "start" or operation not in IN_ORDER or command not in calls:
                continue
            session = (command >> 32, calls[command].session)
            if operation in ACTOR and command < last[session]:
                yield f"{server.name}: command {command} started after {last[session]}"
            last[session] = max(last[session], command)


def one_at_a_time(history: History) -> Iterator[str]:
    for server in history.servers:
        running: int | None = None
        for event, command, operation, _ in server.events:
            if operation not in ACTOR:
                continue
            if event == "start":
                if running is not None:
                    yield f"{server.name}: command {command} started while {running} ran"
                running = command
            elif running == command:
                running = None


def begun_for_a_live_caller(history: History) -> Iterator[str]:
    """No command may be marked as started after its client saw its end.

    A mark cannot be withdrawn: if a freeze falls between the mark and the handler, or the kernel
    takes the core from the thread there, the handler begins for a client that got no answer and
    gave up. That may be one command of those that run one at a time; of those that run in parallel,
    only the ones already marked.
    """
    for server, start, call in history.begun_in_vain():
        told = call.told() or 0
        what = f"{server.name}: command {start.command} ({call.state()}/{call.detail()})"
        if start.marked > told:
            yield f"{what} was marked {(start.marked - told) * 1e-9:.6f} s after its end was told"
        elif call.detail() in LOST and not history.was_held_up(server, start):
            yield (
                f"{what} began {(start.began - told) * 1e-9:.6f} s after its end was told, and no"
                " freeze fell between its mark and its handler"
            )
    of_one: dict[Freeze, list[int]] = defaultdict(list)
    for freeze, start in history.frozen_before_they_began():
        if start.operation in ACTOR:
            of_one[freeze].append(start.command)
    for freeze, commands in of_one.items():
        if len(commands) > 1:
            yield f"process {freeze.pid}: commands {commands} began in vain after one freeze"
