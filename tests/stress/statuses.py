"""Checks who commanded: each actor command that started had a live status, a taker, a master and
the holders of one password were alone, and what a take-over ended did not go on.

Clients note a request before it is sent and after its answer. So what a server did lies between
the two, and a check uses that one of them with which no right history can fail. A server marks a
start under the mutex under which it grants and ends statuses. The time of the mark may be one
kernel tick old, and the server may have lost its core since: it checked the status between that
time and the beginning of the handler.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from history import Call, Client, History, Server

ACTOR = frozenset({"tap", "file"})
"""Operations that need a status, and run one at a time."""
COMMANDS = ACTOR | {"push"}
"""What needs a status: also the samples of this stream."""
ENDS = {"stop": "a stop", "break": "a break", "take": "a take-over"}
SILENCE_S = 1.0
"""When a silent client has lost its status: lease_ttl, and as long again to notice it."""

Session = tuple[str, int]
"""Client and number of its session."""


class Grant(NamedTuple):
    """What a session knew of its status from that time on; status "": it was released."""

    time: int
    session: int
    status: str
    password: str = ""


@dataclass(slots=True)
class Act:
    """A request that changes the statuses of all: take, give, stop or break."""

    what: str
    session: int
    begin: int
    end: int | None = None
    """When its client knew that it was done."""


class Begun(NamedTuple):
    """A command that a server started, or a sample that it took."""

    marked: int
    who: Session
    call: Call
    until: int
    """The server checked the status between `marked` and this time."""

    def named(self) -> str:
        return f"{'sample' if self.call.operation == 'push' else 'command'} {self.call.command}"


class Done(NamedTuple):
    """An act that was done, of a session."""

    begin: int
    end: int
    what: str
    who: Session


class Held(NamedTuple):
    """The session had a status from `begin` on, until the last mark of a command of its own."""

    begin: int
    end: int
    who: Session
    status: str
    """ACTOR, MASTER, or TAKER: alone by a take-over."""
    password: str = ""


@dataclass(slots=True)
class OneServer:
    """What happened at one life of a server."""

    server: Server
    begun: list[Begun] = field(default_factory=list)
    done: list[Done] = field(default_factory=list)
    held: list[Held] = field(default_factory=list)


def by_server(history: History) -> Iterator[OneServer]:
    callers = {
        number: (client, call)
        for client in history.clients
        for number, call in client.calls.items()
    }
    senders = {
        number: (client, call)
        for client in history.clients
        for number, call in client.samples.items()
    }
    for server in history.servers:
        one = OneServer(server)
        for start in server.starts:
            if start.command in callers:
                client, call = callers[start.command]
                who = (client.name, call.session)
                one.begun.append(Begun(start.marked, who, call, start.began))
        for sample, before, took in server.taken:
            if sample in senders:
                client, call = senders[sample]
                one.begun.append(Begun(before, (client.name, call.session), call, took))
        one.begun.sort(key=lambda begun: begun.marked)
        for client in history.clients:
            one.done += [
                Done(act.begin, act.end, act.what, (client.name, act.session))
                for act in client.acts
                if act.end is not None and client.servers.get(act.session) == server.pid
            ]
        one.done.sort()
        one.held = [*held_at(one, history.clients)]
        yield one


def held_at(one: OneServer, clients: Iterable[Client]) -> Iterator[Held]:
    """The times in which a session certainly had its status: it lost the status neither before nor
    between, because a command that it issued under the status started at the end."""
    marks: dict[Session, list[Begun]] = defaultdict(list)
    for begun in one.begun:
        if begun.call.operation in ACTOR:
            marks[begun.who].append(begun)
    for client in clients:
        changes = sorted(
            [(grant.time, grant.session) for grant in client.grants]
            + [(act.begin, act.session) for act in client.acts]
        )
        begins = [
            Grant(done.end, done.who[1], "TAKER")
            for done in one.done
            if done.what == "take" and done.who[0] == client.name
        ]
        begins += [
            grant
            for grant in client.grants
            if grant.status and client.servers.get(grant.session) == one.server.pid
        ]
        for begin, session, status, password in begins:
            later = (time for time, other in changes if other == session and time > begin)
            until = next(later, None)
            who = (client.name, session)
            own = [
                begun.marked
                for begun in marks[who]
                if begin < begun.call.issued and (until is None or begun.call.issued < until)
            ]
            if own:
                yield Held(begin, max(own), who, status, password)


def grant_of(client: Client, call: Call) -> Grant | None:
    """What the session of a call knew last of its status when it issued the call."""
    grants = [grant for grant in client.grants if grant.session == call.session]
    at = bisect_right(grants, call.issued, key=lambda grant: grant.time)
    return grants[at - 1] if at else None


def check(history: History, bound_s: float) -> Iterator[str]:
    yield from took_what_was_sent(history)
    for one in by_server(history):
        yield from had_a_live_status(history, one)
        yield from none_of_a_silent_client(history, one)
        yield from nobody_beside(history, one)
        yield from ended_by_a_take_over(one)
        yield from preempted_by_somebody(history, one)
        yield from stopped_with_its_client(history, one, bound_s)


def took_what_was_sent(history: History) -> Iterator[str]:
    sent = {sample for client in history.clients for sample in client.samples}
    taken = Counter(sample for server in history.servers for sample, _, _ in server.taken)
    for sample, count in taken.items():
        if sample not in sent:
            yield f"sample {sample} was taken and never sent"
        elif count > 1:
            yield f"sample {sample} was taken {count} times"


def had_a_live_status(history: History, one: OneServer) -> Iterator[str]:
    """No actor command starts without a grant, nor after an act that ended its status, or that
    fenced it: a stop fences the commands of all, a take-over those of all others."""
    clients = {client.name: client for client in history.clients}
    begins = [done.begin for done in one.done]
    for begun in one.begun:
        marked, who, call, _ = begun
        if call.operation not in COMMANDS:
            continue
        where = f"{one.server.name}: {begun.named()}"
        grant = grant_of(clients[who[0]], call)
        if grant is None or not grant.status:
            yield f"{where} was issued without a status, and started"
            continue
        sent = marked if call.sent is None else call.sent
        for act in one.done[bisect_left(begins, grant.time) : bisect_left(begins, marked)]:
            own = act.who == who
            if act.end >= marked or act.what == "give" or (own and act.what == "take"):
                continue
            keeps = act.what == "take" or (own and act.what == "stop")
            if not keeps or sent <= act.begin:
                yield f"{where} started after {ENDS[act.what]} by {act.who[0]} had ended it"


def none_of_a_silent_client(history: History, one: OneServer) -> Iterator[str]:
    """A client that stood still for longer than a status lives without it has lost the status: none
    of the commands and samples that it issued before starts any more. A server that stood still
    too watched nothing meanwhile."""
    pids = {client.name: client.pid for client in history.clients}
    for freeze in history.freezes:
        if (freeze.end - freeze.begin) * 1e-9 <= SILENCE_S or freeze.pid == one.server.pid:
            continue
        for begun in one.begun:
            if begun.call.operation not in COMMANDS or pids[begun.who[0]] != freeze.pid:
                continue
            watched = history.awake_s(one.server.pid, freeze.begin, begun.marked)
            if begun.call.issued < freeze.begin and watched > SILENCE_S:
                silent = (begun.marked - freeze.begin) * 1e-9
                yield (
                    f"{one.server.name}: {begun.named()} started {silent:.3f} s after"
                    f" {begun.who[0]} had fallen silent"
                )


def nobody_beside(history: History, one: OneServer) -> Iterator[str]:
    clients = {client.name: client for client in history.clients}
    marks = [begun.marked for begun in one.begun]
    for held in one.held:
        for begun in one.begun[bisect_right(marks, held.begin) : bisect_left(marks, held.end)]:
            if begun.who == held.who or begun.until >= held.end:
                continue
            why = excludes(held, begun, grant_of(clients[begun.who[0]], begun.call))
            if why:
                yield f"{one.server.name}: {begun.named()} started while {held.who[0]} {why}"


def excludes(held: Held, begun: Begun, grant: Grant | None) -> str:
    """Why a call that was issued under `grant` may not begin while another session has a status;
    empty: it may."""
    if held.status == "MASTER":
        return "was master"
    if begun.call.operation not in COMMANDS:
        return ""
    if held.status == "TAKER":
        return "had taken over"
    if grant is not None and grant.status == "ACTOR" and grant.password != held.password:
        return "had a status with another password"
    return ""


def ended_by_a_take_over(one: OneServer) -> Iterator[str]:
    """What ran at a take-over by another, and returned after it, has not finished."""
    actors = [begun for begun in one.begun if begun.call.operation in ACTOR]
    actors.sort(key=lambda begun: begun.until)
    untils = [begun.until for begun in actors]
    for done in one.done:
        at = bisect_left(untils, done.begin)
        if done.what != "take" or at == 0:
            continue
        running = actors[at - 1]  # they run one at a time
        returned = one.server.returned.get(running.call.command, 0)
        if running.who != done.who and returned > done.end and running.call.state() == "FINISHED":
            yield (
                f"{one.server.name}: command {running.call.command} is FINISHED, and was running"
                f" when {done.who[0]} took over"
            )


def preempted_by_somebody(history: History, one: OneServer) -> Iterator[str]:
    takes = [
        (act.begin, (client.name, act.session))
        for client in history.clients
        for act in client.acts
        if act.what == "take" and client.servers.get(act.session) == one.server.pid
    ]
    for client in history.clients:
        for call in client.calls.values():
            if call.detail() != "PREEMPTED" or client.servers.get(call.session) != one.server.pid:
                continue
            who, told = (client.name, call.session), call.told() or 0
            if not any(begin < told and by != who for begin, by in takes):
                yield f"command {call.command} is PREEMPTED, and nobody had taken over"


def stopped_with_its_client(history: History, one: OneServer, bound_s: float) -> Iterator[str]:
    """The motion of a client that was killed ends."""
    for client in history.clients:
        killed = history.kills.get(client.pid)
        if killed is None:
            continue
        for begun in one.begun:
            returned = one.server.returned.get(begun.call.command, 0)
            if begun.who[0] != client.name or begun.call.operation not in ACTOR:
                continue
            took = (returned - killed) * 1e-9 - history.late_s(killed, returned)
            if took > bound_s:
                yield (
                    f"{one.server.name}: command {begun.call.command} ran on {took:.3f} s after its"
                    f" client was killed; promised are {bound_s} s"
                )


class Figures(NamedTuple):
    """How much there was to check."""

    samples: int
    """That were taken."""
    takes: int
    masters: int
    passwords: int
    """Statuses with a password other than the common one."""
    breaks: int
    dead_movers: int
    """Killed clients whose motion was interrupted, and who saw no end of it."""

    def text(self) -> str:
        counts = {
            "samples": self.samples,
            "take-overs": self.takes,
            "masters": self.masters,
            "other passwords": self.passwords,
            "breaks": self.breaks,
            "killed in motion": self.dead_movers,
        }
        return "".join(f", {count} {what}" for what, count in counts.items() if count)


def figures(history: History) -> Figures:
    servers = [*by_server(history)]
    killed = {client.name for client in history.clients if client.pid in history.kills}
    movers = {
        begun.who[0]
        for one in servers
        for interrupted in (one.server.interrupted(),)
        for begun in one.begun
        if begun.who[0] in killed and begun.call.ended is None and begun.call.command in interrupted
    }
    return Figures(
        sum(len(one.server.taken) for one in servers),
        sum(held.status == "TAKER" for one in servers for held in one.held),
        sum(held.status == "MASTER" for one in servers for held in one.held),
        sum(held.password != "" for one in servers for held in one.held),
        sum(done.what == "break" for one in servers for done in one.done),
        len(movers),
    )
