"""The built-in operations of every object. They are functions and not methods, so that an interface
may have operations of the same names."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gecos.command import Command
from gecos.errors import Detail, State
from gecos.interface import Method
from gecos.proxy import Object, demand_proxy
from gecos.record import replace
from gecos.wire import Decoder

if TYPE_CHECKING:
    from gecos_idl.object import GecosObject
    from gecos_idl.object_types import (
        Description,
        FeedReport,
        Holder,
        ObjectStats,
        Roster,
        WaitingRequest,
    )

    from gecos import _core


def stop(robot: Object) -> Command[None]:
    """Stops the device for all clients: ends leases, drops the queue, interrupts the handlers."""
    return _answers_of(robot, "stop").stop()


def take_over(robot: Object) -> Command[None]:
    """Takes sole command of a status that other clients share with this program, by its password.
    The running and queued commands of the other clients end as PREEMPTED. Until `give_back`, or
    until the status of this program ends, new commands of the other clients end as DENIED, and
    their samples have no effect. The commands of this program go on.

    The returned command fails with StatusRefused if this program has no status of the device, or if
    another client has taken over.
    """
    return _answers_of(robot, "take_over").take_over()


def give_back(robot: Object) -> Command[None]:
    """Ends the take-over of this program, so that the other clients may issue commands again. The
    commands that the take-over ended are not started again. Does nothing if this program has not
    taken over."""
    return _answers_of(robot, "give_back").give_back()


def requests(
    robot: Object, after: int = 0, timeout: float | None = 0.0
) -> Command[list[WaitingRequest]]:
    """Asks which requests for a status of the device wait in line, in the order of their arrival. A
    request waits if the `timeout` of `gecos.actor` permits it.

    The command ends as soon as there is a request whose id is larger than `after`, at the latest
    after `timeout` s; None waits without limit. In this way, a holder is told of each new request.
    To grant a request, release the lease: the first request in line gets the status when the last
    command under the lease has ended.
    """
    return _answers_of(robot, "requests").requests(after, math.inf if timeout is None else timeout)


def deny(robot: Object, request: int, why: str = "") -> Command[bool]:
    """Refuses the waiting request with the id `request`. The program that made the request gets
    LeaseRefused, which names this program and says `why`. The result is False when the request no
    longer waits. The command fails with StatusRefused if this program does not hold the status."""
    return _answers_of(robot, "deny", "{}(robot, …)").deny(request, why)


def break_status(robot: Object, why: str) -> Command[None]:
    """Ends every status of the device. Only an administrator may do this: the user of the server,
    root, or a user in `[admin]` of the lab file.

    The commands of the holders end as LEASE_LOST, with `why` and the name of this program. The
    first waiting request gets the status. A person should decide this, as by `gecos break`; a
    program must not do it automatically. The command fails with StatusRefused for users who are not
    administrators.
    """
    return _answers_of(robot, "break_status", "{}(robot, …)").break_status(why)


def ping(robot: Object) -> Command[None]:
    """Checks that the object's server answers. The command finishes when the answer arrives."""
    return _answers_of(robot, "ping").ping()


def describe(robot: Object) -> Command[Description]:
    """Asks for the object's type and state."""
    return _answers_of(robot, "describe").describe()


def holders(robot: Object) -> Command[list[Holder]]:
    """Asks for the clients that hold actor or master status."""
    return _answers_of(robot, "holders").holders()


def roster(robot: Object, after: int = 0, timeout: float | None = 0.0) -> Command[Roster]:
    """Asks which clients hold actor or master status, and for the changes of these holders whose
    numbers are larger than `after`.

    The command ends as soon as there is such a change, at the latest after `timeout` s; None waits
    without limit. To be told each change once, call `roster` again and again, each time with the
    `newest` of the previous result. Pass 0 in the first call: the object then answers at once with
    all changes that it keeps, at most 256. The object answers in the same way if `after` comes from
    an earlier server of the object. Numbers are consecutive, so a gap shows that changes were lost
    because the program asked too late. A server that was built before this operation existed
    answers UNKNOWN_OPERATION.
    """
    return _answers_of(robot, "roster").roster(after, math.inf if timeout is None else timeout)


def stats(robot: Object) -> Command[ObjectStats]:
    """Asks what the object has counted since its server began to serve it: the calls of each
    operation and of each open session by outcome, the times of handlers, and the samples of each
    stream.

    The counts are those of the server. They do not include the samples that a reader of a stream
    has lost, which are in `stream.counts`; the latency of a connection is in `gecos.line_state`. A
    server that was built before this operation existed answers UNKNOWN_OPERATION.
    """
    return _answers_of(robot, "stats").stats()


def model(robot: Object) -> Command[list[str]]:
    """Asks for the JSON of the object's interface and of each of its bases, which `lab.dynamic`
    reads."""
    return _answers_of(robot, "model").model()


def feed_report(session: _core.Session, stream: int) -> Command[FeedReport]:
    """Asks what became of the samples that the session has sent on an inward stream. `stream` is
    the function code of the stream."""
    from gecos_idl.object import _GECOS_OBJECT_FEED_REPORT

    asked: Method[FeedReport, None] = _GECOS_OBJECT_FEED_REPORT
    arguments = b"".join(asked.request(stream))
    return Command(session.call(asked.operation.code, arguments, None), asked)


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a command, or its present state."""

    detail: Detail
    text: str  # the reason of the failure; empty if the command is DONE

    @property
    def state(self) -> State:
        return self.detail.state


def outcome(robot: Object, command: str) -> Command[Outcome]:
    """Asks the server for the outcome of an actor command that ended in this process as
    OUTCOME_UNKNOWN.

    `robot` must be a new proxy, and `command` the id of the command. The state of the command
    itself does not change. NOT_STARTED guarantees that the command has not arrived and will never
    start. SENT means that the command has not arrived and may still start; ask again.
    OUTCOME_UNKNOWN means that the server has restarted since then, or no longer keeps the outcome
    (a server keeps the last 1024 outcomes of each object). Raises ValueError if `command` is not an
    id.
    """
    from gecos_idl.object import _GECOS_OBJECT_OUTCOME

    demand_proxy(robot, "outcome", "{}(robot, …)")
    asked: Method[Any, None] = _GECOS_OBJECT_OUTCOME
    core = robot._gecos_session.outcome(command)

    def told(source: Decoder) -> Outcome:
        record = asked.result(source)
        return Outcome(Detail(record.detail), record.text)

    return Command(core, replace(asked, result=told))


def _answers_of(robot: Object, function: str, use: str = "{}(robot)") -> GecosObject:
    """Returns a proxy of the object with the interface of the built-in operations. `function` and
    `use`: see `demand_proxy`."""
    from gecos_idl.object import GecosObject

    demand_proxy(robot, function, use)
    return GecosObject(robot._gecos_session)
