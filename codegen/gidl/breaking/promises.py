"""Compares the promises of interfaces: reports weaker quality and changed protection."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from gidl.breaking.report import Report
from gidl.breaking.sides import Call
from gidl.model import Attribute, Facts, Interface, Operation
from gidl.model.policy import Access, OnDegraded, OnLoss, Qos, Reliability, Stream

_RELIES = "programs that rely on the old promise may fail"
_KEEP = "keep the promise"
_AVAILABLE = ("inproc", "shm", "lcm")  # the media of this version; an interface may name others
_ASK = "keep the old declaration, or ask the person responsible for the laboratory's safety"


def interface(old: Interface, new: Interface, report: Report) -> frozenset[str]:
    """Reports the quality terms that became weaker for the whole interface. Returns the reported
    texts. The function `call` does not report these texts again for each member."""
    weaker = (*_weaker(old.qos, new.qos), *_calls_less_reliable(old.qos, new.qos))
    for text in weaker:
        _qos(report, old.name, f"'{old.name}' {text}", new.facts, old.facts)
    return frozenset(weaker)


def call(old: Call, new: Call, told: frozenset[str], report: Report) -> None:
    subject, places = old.scoped_name, (new.facts, old.facts)
    changes: list[tuple[str, str]] = []
    for text in (*_weaker(old.qos, new.qos), *_less_reliable(old, new)):
        if text not in told:
            _qos(report, subject, f"'{subject}' {text}", *places)
    if isinstance(old, Operation) and isinstance(new, Operation):
        for text in _behaviour(old, new):
            _qos(report, subject, f"'{subject}' {text}", *places)
        changes = list(_operation_security(old, new))
    elif isinstance(old, Attribute) and isinstance(new, Attribute):
        for text in _stream(old.stream, new.stream):
            _qos(report, subject, f"'{subject}' {text}", *places)
        changes = list(_attribute_security(old, new))
    for message, why in changes:
        report.add("G1301", subject, f"'{subject}' {message}", why, _ASK,
                   new=places[0], old=places[1])  # fmt: skip
    for message, why in _secrets(old, new):
        report.add("G1302", subject, f"'{subject}' {message}", why, "keep @secret",
                   new=places[0], old=places[1])  # fmt: skip


def _qos(report: Report, subject: str, message: str, new: Facts, old: Facts) -> None:
    report.add("G1201", subject, message, _RELIES, _KEEP, new=new, old=old)


def _weaker(old: Qos, new: Qos) -> Iterator[str]:
    """Yields a text for each quality term of `old` that is weaker in `new`."""
    for what, was, is_now in (
        ("class", old.quality_class, new.quality_class),
        ("liveliness", old.liveliness, new.liveliness),
    ):
        if was is not None and (is_now is None or is_now < was):
            now = "none" if is_now is None else is_now.name
            yield f"promised {what} {was.name} and now promises {now}"
    for what, longest, limit in (
        ("deadline", old.deadline_ns, new.deadline_ns),
        ("start_by", old.start_by_ns, new.start_by_ns),
        ("latency", old.latency_ns, new.latency_ns),
        ("lifespan", old.lifespan_ns, new.lifespan_ns),
    ):
        if longest is not None and (limit is None or limit > longest):
            yield f"promised a {what} of {duration(longest)} and now promises {duration(limit)}"
    before, after = (each.on_degraded or OnDegraded.EVENT for each in (old, new))
    if before is not after and old.latency_ns is not None:
        yield (
            f'promised on_degraded="{before.value}" and now promises on_degraded="{after.value}", '
            "so something else happens when a connection is too slow"
        )
    if old.depth is not None and (new.depth is None or new.depth < old.depth):
        yield f"kept {old.depth} samples and now keeps {new.depth or 'an undeclared number'}"
    if new.media is not None:
        lost = sorted((_reached(old.media or _AVAILABLE) - _reached(new.media)) & set(_AVAILABLE))
        if lost:
            yield f"cannot be reached over {', '.join(lost)} any more"


def _reached(media: Iterable[str]) -> set[str]:
    """Returns `media`, with inproc if shm is one of them: a session over shm is one over inproc if
    client and server are one process."""
    allowed = set(media)
    return allowed | {"inproc"} if "shm" in allowed else allowed


_UNRELIABLE = "promised reliability RELIABLE and now promises BEST_EFFORT"


def _calls_less_reliable(old: Qos, new: Qos) -> Iterator[str]:
    """Yields a text if calls are BEST_EFFORT now. Calls are RELIABLE unless BEST_EFFORT is
    written."""
    best_effort = Reliability.BEST_EFFORT
    if old.reliability is not best_effort and new.reliability is best_effort:
        yield _UNRELIABLE


def _less_reliable(old: Call, new: Call) -> Iterator[str]:
    """Yields a text if the reliability of a member has changed so that clients may lose calls or
    samples, or cannot use the stream over lcm any more. Samples are BEST_EFFORT unless RELIABLE is
    written. The medium lcm loses samples, so RELIABLE samples are refused there."""
    if not (old.sends_samples and new.sends_samples):
        yield from _calls_less_reliable(old.qos_of_calls, new.qos_of_calls)
        return
    was, is_now = (each.qos.reliability is Reliability.RELIABLE for each in (old, new))
    if was and not is_now:
        yield f"{_UNRELIABLE}: its samples may be lost over lcm"
    lcm = all(each.qos.media is None or "lcm" in each.qos.media for each in (old, new))
    if is_now and not was and lcm:
        inward = isinstance(new, Attribute) and new.streams_in
        use = "send samples on it" if inward else "subscribe to it"
        yield f"is RELIABLE now: clients cannot {use} over lcm any more (QOS_UNAVAILABLE)"


def duration(nanoseconds: int | None) -> str:
    if nanoseconds is None:
        return "none"
    for unit, size in (("s", 10**9), ("ms", 10**6), ("us", 10**3)):
        if nanoseconds % size == 0:
            return f"{nanoseconds // size}{unit}"
    return f"{nanoseconds}ns"


def _stream(old: Stream | None, new: Stream | None) -> Iterator[str]:
    if old is None or new is None:
        return  # calls.py reports an added or removed stream, as WIRE
    if old.rate_hz is not None and (new.rate_hz is None or new.rate_hz < old.rate_hz):
        now = "at an undeclared rate" if new.rate_hz is None else f"at {new.rate_hz:g} Hz"
        yield f"was sent at {old.rate_hz:g} Hz and is now sent {now}"
    if old.watchdog_ns is not None and (
        new.watchdog_ns is None or new.watchdog_ns > old.watchdog_ns
    ):
        yield (
            f"had the watchdog time {duration(old.watchdog_ns)} "
            f"and now has {duration(new.watchdog_ns)}"
        )


def _behaviour(old: Operation, new: Operation) -> Iterator[str]:
    if old.idempotent and not new.idempotent:
        yield "is not @idempotent any more: calls are not sent again when the server is lost"
    if old.cancelable and not new.cancelable:
        yield "cannot be cancelled any more"
    if old.ordered and not new.ordered:
        yield (
            "is not @ordered any more: a call may start before earlier actor commands of the "
            "same caller"
        )
    if old.parallel != new.parallel:
        yield "is @parallel now" if new.parallel else "is not @parallel any more"
    if old.on_new != new.on_new:
        yield f'had @on_new("{old.on_new.value}") and now has @on_new("{new.on_new.value}")'
    if old.on_loss is OnLoss.FINISH and new.on_loss is OnLoss.STOP:
        yield "is now stopped when the holder of the lease is lost"


def _operation_security(old: Operation, new: Operation) -> Iterator[tuple[str, str]]:
    yield from _access("", old.access, new.access)
    if old.access == new.access:
        yield from _presence(old.needs_presence, new.needs_presence)
    if old.safety != new.safety:
        if new.safety:
            yield (
                "is @safety now",
                "safety operations are never refused, and they do not wait in any queue",
            )
        else:
            yield (
                "is not @safety any more",
                "calls of this operation can be refused, and they wait in the queue after other "
                "calls",
            )
    if old.on_loss is OnLoss.STOP and new.on_loss is OnLoss.FINISH:
        yield (
            "is not stopped any more when the holder of the lease is lost",
            "the robot may move without a holder",
        )


def _attribute_security(old: Attribute, new: Attribute) -> Iterator[tuple[str, str]]:
    if old.has_getter and new.has_getter:
        yield from _access("reading ", old.read_access, new.read_access)
    if (old.has_setter and new.has_setter) or (old.streams_in and new.streams_in):
        yield from _access("writing ", old.write_access, new.write_access)
        if old.write_access == new.write_access:
            yield from _presence(old.write_needs_presence, new.write_needs_presence)
    was_open = old.stream is not None and old.stream.is_open
    is_open = new.stream is not None and new.stream.is_open
    if is_open and not was_open:
        yield (
            "is an @open_stream now",
            "everybody on the network can read the samples, without authentication",
        )
    if was_open and not is_open:
        yield (
            "is not @open_stream any more",
            "programs that read the samples as bare LCM messages get no messages any more",
        )


def _access(what: str, old: Access, new: Access) -> Iterator[tuple[str, str]]:
    text = (
        f"needed {old.name.lower()} status for {what or 'calling '}and now needs {new.name.lower()}"
    )
    if new < old:
        yield text, "more clients than before have access"
    elif new > old:
        yield text, f"clients that have only {old.name.lower()} status are refused"


def _presence(old: bool, new: bool) -> Iterator[tuple[str, str]]:
    if old and not new:
        yield (
            "does not need presence any more",
            "the device may move while no person is present to stop it by hand",
        )
    elif new and not old:
        yield "needs presence now", "clients that work while nobody is present are refused"


def _secrets(old: Call, new: Call) -> Iterator[tuple[str, str]]:
    was = old.secret if isinstance(old, Attribute) else old.result_secret
    is_now = new.secret if isinstance(new, Attribute) else new.result_secret
    if was and not is_now:
        yield "is not @secret any more", "the value is now printed, logged and recorded"
