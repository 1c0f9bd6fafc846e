"""What every object answers: codes 1 to 255."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from .packets import (
    ACQUIRE,
    DESCRIBE,
    HOLDERS,
    OUTCOME,
    PING,
    RELEASE,
    STOP,
    SUBSCRIBE,
    UNSUBSCRIBE,
    Detail,
    Failure,
    Kind,
    Packet,
    Reader,
    Status,
    block,
    boolean,
    f64,
    sequence,
    string,
    u32,
    u64,
)

if TYPE_CHECKING:
    from .served import Session


def answer(session: Session, call: Packet) -> Packet:
    """The reply to a call that has arrived."""
    known = {
        HOLDERS: _holders,
        STOP: _stop,
        PING: lambda session, body: done(),
        DESCRIBE: _describe,
        ACQUIRE: _acquire,
        RELEASE: _release,
        SUBSCRIBE: _subscribe,
        UNSUBSCRIBE: _unsubscribe,
        OUTCOME: _outcome,
    }
    if call.code not in known:
        return failed(Detail.UNKNOWN_OPERATION, f"there is no operation {call.code}")
    try:
        return known[call.code](session, Reader(call.body))
    except ValueError as error:  # Malformed, or no such status
        return failed(Detail.BAD_PARAMETER, str(error))


def done(body: bytes = b"", epoch: int = 0) -> Packet:
    return Packet(Kind.REPLY, Detail.DONE, epoch=epoch, body=body)


def failed(detail: Detail, text: str, exception: str = "", value: bytes = b"") -> Packet:
    return Packet(Kind.REPLY, detail, body=Failure(text, exception, value).pack())


def _roster(session: Session) -> bytes:
    def holder(of: Session) -> bytes:
        assert of.hello is not None
        who = string(of.hello.user) + string(of.hello.host) + string(of.hello.program)
        who = u32(of.status) + who + u32(of.hello.pid)
        return block(who + f64(0.0) + f64(0.5) + boolean(False))

    return sequence(holder(of) for of in session.served.holders())


def _holders(session: Session, body: Reader) -> Packet:
    return done(_roster(session))


def _stop(session: Session, body: Reader) -> Packet:
    session.served.stop(session)
    return done(epoch=session.epoch)


def _describe(session: Session, body: Reader) -> Packet:
    about = session.served.about
    what = string(about.name) + string(about.interface) + string("1.0") + u64(about.hash)
    what += boolean(True) + string("not required") + string("none") + u64(session.epoch)
    running = [task for task in session.served.tasks if task.operation.queued and not task.over]
    names = [task.operation.name for task in running if not task.waits]
    what += u32(sum(task.waits for task in running)) + string(names[0] if names else "")
    return done(block(what + u32(0) + string("confirmed") + u32(0)))


def _acquire(session: Session, body: Reader) -> Packet:
    wanted = Status(body.u32())
    if wanted == Status.SENSOR:
        return failed(Detail.BAD_PARAMETER, "everybody has sensor status")
    others = [other for other in session.served.holders() if other is not session]
    if others:
        reason = f"{session.served.about.name} is held"
        value = string(reason) + _roster(session)
        return failed(Detail.FAULT, reason, "gecos::StatusRefused", value)
    session.status = wanted
    session.epoch = next(session.served.epochs)
    session.epochs[session.epoch] = Detail.LEASE_LOST
    return done(block(u32(wanted) + u64(session.epoch)))


def _release(session: Session, body: Reader) -> Packet:
    epoch, now = body.u64(), body.boolean()
    if epoch == session.epoch:
        if now:
            session.lose_status(Detail.STOPPED, "released")
        session.status, session.epoch = Status.SENSOR, 0
    return done()


def _subscribe(session: Session, body: Reader) -> Packet:
    stream = session.served.streams.get(body.u32())
    if stream is None:
        return failed(Detail.UNKNOWN_OPERATION, "there is no such stream")
    return done(u32(session.share(stream)) + u64(stream.newest))


def _unsubscribe(session: Session, body: Reader) -> Packet:
    stream = session.served.streams.get(body.u32())
    session.shares = {i: s for i, s in session.shares.items() if s[0] is not stream}
    return done()


def _outcome(session: Session, body: Reader) -> Packet:
    boot, number, counter = body.u64(), body.u64(), body.u64()
    detail = Detail.OUTCOME_UNKNOWN
    for other in session.served.sessions:
        if boot == session.served.about.boot and other.id == number:
            task = other.tasks.get(counter)
            if task is None and not other.arrivals.has(counter):
                other.arrivals.take(counter)
                detail = Detail.NOT_STARTED
                late = failed(detail, "it was asked for before it arrived")
                other.replies.keep(replace(late, counter=counter))
            elif task is not None and task.operation.queued:
                detail = task.detail
    return done(block(bytes([detail]) + string("")))
