"""A server: one object at a place, its sessions, its queue, its streams."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from . import builtin_operations
from .broker import Entry
from .frames import BEAT_S
from .lcm import Loop
from .listener import Listener, Visitor
from .noise import Keys
from .packets import Detail, Failure, Kind, Packet, Reader, Status, Welcome, string
from .served import Session
from .streams import StreamWriter
from .tasks import Operation, Task

UNANSWERED = 256
SENT_AGAIN = 1
STATUS_SILENT_S = 0.5


class Served:
    """Takes part in a loop by its listener. `about` is what its Welcome says."""

    def __init__(
        self,
        loop: Loop,
        keys: Keys,
        about: Welcome,
        operations: Iterable[Operation],
        place: str = "",
    ) -> None:
        self.loop = loop
        self.about = about
        self.operations = {operation.code: operation for operation in operations}
        self.streams: dict[int, StreamWriter] = {}
        self.sessions: list[Session] = []
        self.tasks: list[Task] = []
        """All that were ever judged good, in their order."""
        self.mouth: Callable[[Session, Packet], Iterable[Packet]] = lambda session, packet: [packet]
        """What is sent in place of a packet."""
        self.ear: Callable[[Session, Packet], Iterable[Packet]] = lambda session, packet: [packet]
        """What is taken in place of a packet that came."""
        self.listener = Listener(loop, keys, place)
        self.listener.on_visitor = self._come
        self.listener.on_tick = self._tick
        self.status_silent_s = STATUS_SILENT_S
        self.epochs = iter(range(1, 1 << 62))
        self._queue: list[Task] = []  # the first runs
        self._beat = 0.0

    def _come(self, visitor: Visitor) -> None:
        self.sessions.append(Session(self, visitor))

    def _tick(self, now: float) -> None:
        beat = now - self._beat >= BEAT_S
        self._beat = now if beat else self._beat
        for session in self.sessions:
            if not session.over:
                session.tick(now)
            if beat and not session.over:
                session.beat()

    def entry(self, user: str, host: str, pid: int) -> Entry:
        about = self.about
        what = about.name, about.interface, about.bases, about.hash, about.boot
        return Entry(*what, pid, user, host, host, [self.listener.address], True)

    def judge(self, session: Session, call: Packet, age_ns: float) -> None:
        """A call that has arrived."""
        if call.detail == SENT_AGAIN:
            before = Reader(call.body)
            lost, counter = before.u64(), before.u64()
            call = replace(call, detail=0, body=before.rest())
            if self._answer_again(session, call, lost, counter):
                return
        if call.code < 256:
            session.answer(call, builtin_operations.answer(session, call))
            return
        operation = self.operations.get(call.code)
        refusal = self._refusal(session, operation, call)
        if operation is None or refusal is not None:
            detail = refusal or Detail.UNKNOWN_OPERATION
            body = Failure(f"{self.about.name} does not do this").pack()
            session.answer(call, Packet(Kind.REPLY, detail, body=body))
            return
        task = session.task_of(operation, call, age_ns)
        self.tasks.append(task)
        if operation.queued:
            task.before, task.on_end = self._before, self._ended
            self._queue.append(task)
            self._start_next()
            if task.waits:
                task.tell()
        else:
            task.start()

    def _answer_again(self, session: Session, call: Packet, lost: int, counter: int) -> bool:
        """As the lost session's call was, or will be; if it was not, it is not any more."""
        before = next((one for one in self.sessions if one.id == lost and one.over), None)
        if before is None:
            return False
        task, reply = before.tasks.get(counter), before.replies.get(counter)
        if reply is not None:
            session.answer(call, reply)
        elif task is not None and not task.over:
            session.resume_in(task, call)
        elif not before.arrivals.has(counter) and not before.arrivals.beyond(counter):
            before.arrivals.take(counter)
        return reply is not None or (task is not None and not task.over)

    def _refusal(
        self, session: Session, operation: Operation | None, call: Packet
    ) -> Detail | None:
        if operation is None:
            return Detail.UNKNOWN_OPERATION
        if sum(not task.over for task in session.tasks.values()) >= UNANSWERED:
            return Detail.QUEUE_FULL
        if operation.status == Status.SENSOR:
            return None
        if session.status < operation.status or call.epoch != session.epoch:
            if call.epoch in (0, session.epoch):
                return Detail.DENIED
            return session.epochs.get(call.epoch, Detail.DENIED)
        return None

    def _before(self, task: Task) -> int:
        return self._queue.index(task) if task in self._queue else 0

    def _ended(self, task: Task) -> None:
        self._queue.remove(task)
        self._start_next()

    def _start_next(self) -> None:
        if self._queue and self._queue[0].waits:
            self._queue[0].start()

    def holders(self) -> list[Session]:
        return [session for session in self.sessions if session.holds]

    def stop(self, by: Session) -> None:
        """Ends every status but the caller's, which goes on under a new epoch."""
        for task in reversed(list(self._queue)):  # so that none starts
            task.fail(Detail.STOPPED, "stopped")
        for session in self.holders():
            if session is by:
                session.epochs[session.epoch] = Detail.STOPPED
                session.epoch = next(self.epochs)
                session.epochs[session.epoch] = Detail.LEASE_LOST
            else:
                session.lose_status(Detail.STOPPED, "stopped")

    def ended(self, session: Session) -> None:
        """Its session is over: in order its commands go on, else its status is lost."""
        if not session.goodbyes and not session.visitor.bye:
            session.lose_status(Detail.LEASE_LOST, "its session is lost")

    @property
    def session(self) -> Session:
        """The newest."""
        return self.sessions[-1]

    def withdraw(self, why: str) -> None:
        """Says Goodbye to everybody."""
        for session in self.sessions:
            if not session.over:
                session.send(Packet(Kind.GOODBYE, body=string(why)))
                session.over = True

    def close(self) -> None:
        self.listener.close()
