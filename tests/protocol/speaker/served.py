"""One session of a server: calls arrive once, and are answered as often as they are asked for."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from . import packets
from .arrivals import Arrivals, Replies
from .frames import Frame, Inner
from .listener import Visitor
from .packets import Detail, Failure, Hello, Kind, Packet, Status
from .tasks import Operation, Task

if TYPE_CHECKING:
    from .server import Served
    from .streams import StreamWriter

CREDITS = 256


class Session:
    def __init__(self, served: Served, visitor: Visitor) -> None:
        self.served = served
        self.visitor = visitor
        self.id = 0
        self.hello: Hello | None = None
        self.status = Status.SENSOR
        self.epoch = 0
        self.epochs: dict[int, Detail] = {}  # of each status that it had: what later calls end as
        """All that its status ever had."""
        self.arrivals = Arrivals()
        self.replies = Replies()
        self.tasks: dict[int, Task] = {}
        self.shares: dict[int, tuple[StreamWriter, bool]] = {}
        """Stream by id, and whether it was opened."""
        self.passes_share: Callable[[int, bytes], bool] = lambda number, body: True
        """Whether a Share is sent."""
        self.frames: list[Frame] = []
        self.received: list[Packet] = []
        self.goodbyes = 0
        self.over = False
        self._held: dict[int, tuple[Packet, float]] = {}  # come before an earlier one
        visitor.on_frame = self._frame
        visitor.on_gone = self.end

    @property
    def holds(self) -> bool:
        """Whether it has a status, which goes on as long as what it ordered."""
        busy = any(task.operation.queued and not task.over for task in self.tasks.values())
        return self.status != Status.SENSOR and (busy or not self.over)

    def send(self, packet: Packet) -> None:
        if self.over:
            return
        for goes in self.served.mouth(self, replace(packet, session=packet.session or self.id)):
            self.visitor.sealed.send_packet(goes.pack())

    def share(self, stream: StreamWriter) -> int:
        known = next((i for i, (shared, _) in self.shares.items() if shared is stream), None)
        number = known if known is not None else len(self.shares) + 1
        if known is None:
            self.shares[number] = (stream, False)
        self._send_share(number, stream)
        return number

    def _send_share(self, number: int, stream: StreamWriter) -> None:
        body = stream.share(number).pack()
        if self.passes_share(number, body):
            self.visitor.sealed.send(Inner.SHARE, number, body)

    def tick(self, now: float) -> None:
        if self.visitor.silence(now) > self.served.status_silent_s and self.status != Status.SENSOR:
            self.lose_status(Detail.LEASE_LOST, "its holder is silent")
        for task in list(self.tasks.values()):
            task.look_at_clock(now)

    def beat(self) -> None:
        """With each beat what was not opened is shared again."""
        for number, (stream, opened) in self.shares.items():
            if not opened:
                self._send_share(number, stream)

    def _frame(self, frame: Frame, age_ns: float) -> None:
        self.frames.append(frame)
        if frame.kind == Inner.OPENED and frame.number in self.shares:
            stream, opened = self.shares[frame.number]
            self.shares[frame.number] = (stream, True)
            if not opened:
                stream.again()
        if frame.kind != Inner.PACKET:
            return
        try:
            packet = Packet.of(frame.body)
        except packets.Malformed:
            return
        for come in self.served.ear(self, packet):
            self.received.append(come)
            if come.kind == Kind.HELLO:
                self._greet(come)
            elif come.version == packets.VERSION:
                self._take(come, age_ns)

    def _greet(self, packet: Packet) -> None:
        try:
            hello = Hello.of(packet.body)
        except (packets.Malformed, UnicodeDecodeError) as error:
            self._refuse(f"this Hello is none: {error}")
            return
        if packet.version != packets.VERSION:
            self._refuse(f"packets of version {packet.version} are not spoken here")
            return
        about = self.served.about
        if hello.interface not in (about.interface, *about.bases):
            self._refuse(f"{about.name} is a {about.interface}, not a {hello.interface}")
            return
        if self.hello is None:
            self.hello, self.id = hello, secrets.randbits(63) + 1
        known = hello.hash == about.hash
        welcome = replace(about, operations={} if known else about.operations, credits=CREDITS)
        self.send(Packet(Kind.WELCOME, body=welcome.pack()))

    def _refuse(self, why: str) -> None:
        body = Failure(why).pack()
        self.visitor.sealed.send_packet(Packet(Kind.REFUSED, Detail.REFUSED, body=body).pack())

    def _take(self, packet: Packet, age_ns: float) -> None:
        if self.over or packet.session != self.id or self.id == 0:
            self._say_goodbye(packet.session)
            return
        if packet.kind == Kind.GOODBYE:
            self.goodbyes += 1
            self._say_goodbye(self.id)
            self.end()
            return
        self._acknowledge(packet.acknowledged)
        if packet.counter == 0:
            return
        if packet.kind == Kind.CALL:
            self._call(packet, age_ns)
        elif packet.kind == Kind.QUERY:
            self._query(packet.counter)
        elif packet.kind == Kind.CANCEL:
            self._cancel(packet.counter)

    def _say_goodbye(self, session: int) -> None:
        self.visitor.sealed.send_packet(Packet(Kind.GOODBYE, session=session).pack())

    def _call(self, call: Packet, age_ns: float) -> None:
        assert self.hello is not None
        if self.hello.oldest_ns and age_ns > self.hello.oldest_ns:
            return
        if self.arrivals.has(call.counter):
            self._query(call.counter)
        elif self.arrivals.beyond(call.counter):
            return  # the client sends it again
        elif self._must_wait(call):
            if call.code != packets.RELEASE:
                self._held.setdefault(call.counter, (call, age_ns))
        else:
            self._arrive(call, age_ns)

    def _must_wait(self, call: Packet) -> bool:
        operation = self.served.operations.get(call.code)
        in_order = call.code == packets.RELEASE or (operation is not None and operation.queued)
        return in_order and self.arrivals.whole + 1 < call.counter

    def _acknowledge(self, upto: int) -> None:
        self.replies.acknowledge(upto)
        self.arrivals.abandon_up_to(upto)
        self._held = {counter: held for counter, held in self._held.items() if counter > upto}
        self._arrive_next()

    def _arrive(self, call: Packet, age_ns: float) -> None:
        self.arrivals.take(call.counter)
        self.served.judge(self, call, age_ns)
        self._arrive_next()

    def _arrive_next(self) -> None:
        ready = [counter for counter, (held, _) in self._held.items() if not self._must_wait(held)]
        if ready:
            self._arrive(*self._held.pop(min(ready)))

    def _query(self, counter: int) -> None:
        task, reply = self.tasks.get(counter), self.replies.get(counter)
        if task is not None and not task.over:
            self.send(replace(task.standing(), counter=counter))
        elif reply is not None:
            self.send(reply)
        elif self.arrivals.has(counter) and counter > self.replies.acknowledged:
            body = Failure("its answer is not kept any more").pack()
            self.send(Packet(Kind.REPLY, Detail.OUTCOME_UNKNOWN, counter=counter, body=body))

    def _cancel(self, counter: int) -> None:
        if counter in self._held:
            call, age_ns = self._held.pop(counter)
            self.arrivals.take(counter)
            operation = self.served.operations[call.code]
            self.tasks[counter] = Task(self, operation, call, age_ns)
        if counter in self.tasks:
            later = [t for c, t in self.tasks.items() if c > counter and t.waits]
            ran = not self.tasks[counter].waits
            self.tasks[counter].cancel()
            for task in later if ran and self.tasks[counter].canceled else []:
                task.cancel()

    def answer(self, call: Packet, reply: Packet) -> None:
        """At once, without a task."""
        reply = replace(reply, counter=call.counter)
        self.replies.keep(reply)
        self.send(reply)

    def resume_in(self, task: Task, call: Packet) -> None:
        """It still runs for another session, and is answered here too."""
        self.tasks[call.counter] = task
        task.resumed_in.append((self, call))

    def task_of(self, operation: Operation, call: Packet, age_ns: float) -> Task:
        task = self.tasks[call.counter] = Task(self, operation, call, age_ns)
        return task

    def lose_status(self, detail: Detail, why: str) -> None:
        self.epochs[self.epoch] = detail
        self.status, self.epoch = Status.SENSOR, 0
        for task in reversed(list(self.tasks.values())):  # so that none starts
            if task.operation.queued and not task.over:
                task.fail(detail, why)

    def end(self) -> None:
        """Goodbye, Bye or silence."""
        if not self.over:
            self.over = True
            self.served.ended(self)
