"""What `gecos policy test` asks the broker and an object: which user runs the server of the object,
whether the object admits this program, and which status its members need."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from gecos.cli import refusal
from gecos.cli.exit_codes import UsageFailure

if TYPE_CHECKING:
    import gecos
    from gecos.dynamic_client.model import Member

# Longest wait for the broker's list in s. Without the list, the command assumes that this user runs
# the server.
_MOMENT = 1.0


class KnownFrom(StrEnum):
    """How the user of a server is known."""

    OPTION = "option"  # --server-user names it
    BROKER = "broker"  # the broker lists the object
    ASSUMED = "assumed"  # no broker lists the object
    UNKNOWN = "unknown"  # the broker refuses this program


@dataclass(frozen=True, slots=True)
class ServerUser:
    """The user and the host of a server, and how they are known. If `known_from` is ASSUMED or
    UNKNOWN, `user` and `host` are those of this program."""

    user: str
    host: str
    known_from: KnownFrom


@dataclass(frozen=True, slots=True)
class Answer:
    """What an object says when this program connects."""

    admits: bool | None  # None: the object was not reached
    reason: str  # why the object refuses or was not reached; "" if it admits
    reached: gecos.Object | None = None
    error: Exception | None = None  # if the object was not reached, or refuses

    def proxy(self) -> gecos.Object:
        """Returns the proxy of the object. Raises the error of the connection."""
        if self.reached is None:
            raise self.error or RuntimeError(self.reason)
        return self.reached


def server_user(lab: gecos.Lab, name: str) -> ServerUser:
    """Returns the user of the server of an object, as the broker says."""
    from gecos.dynamic_client.connect import entries, silent_objects
    from gecos.errors import CreateError
    from gecos.key_folder import this_user

    how, known = KnownFrom.ASSUMED, []
    try:
        known = [*entries(lab, patience=_MOMENT), *(each.entry for each in silent_objects(lab))]
    except CreateError as error:
        if any(refusal.of_broker(each.reason) for each in error.attempts):
            how = KnownFrom.UNKNOWN
    except (ConnectionError, RuntimeError):
        pass
    for entry in known:
        if entry.name == name:
            return ServerUser(entry.user, entry.hostname, KnownFrom.BROKER)
    return ServerUser(this_user(), socket.gethostname(), how)


def answer(lab: gecos.Lab, name: str) -> Answer:
    """Connects to an object. Returns whether the object admits this program."""
    from gecos.dynamic_client.connect import find
    from gecos.errors import CreateError, Detail

    try:
        return Answer(True, "", find(lab, name))
    except CreateError as error:
        refusals = [
            each.reason
            for each in error.attempts
            if each.detail is Detail.REFUSED or refusal.of_broker(each.reason)
        ]
        if refusals:
            return Answer(False, refusals[0], error=error)
        return Answer(None, "; ".join(each.reason for each in error.attempts), error=error)
    except (ConnectionError, RuntimeError) as error:
        return Answer(None, str(error), error=error)


def member(lab: gecos.Lab, name: str, called: str, answer: Answer | None) -> Member:
    """Returns the operation or attribute `called` of the object `name`. `answer` has the connection
    to the object; if `answer` is None, connects to the object. Raises UsageFailure if there is no
    such member, and the errors of `find`."""
    import gecos
    from gecos.dynamic_client import read_model
    from gecos.dynamic_client.connect import find, served_models, without_model

    found = find(lab, name) if answer is None else answer.proxy()
    interface = gecos.describe(found).result().interface_name
    models = served_models(found)
    if not models:
        raise UsageFailure(without_model(name))
    members = {each.name: each for each in read_model(models, interface).members}
    if called not in members:
        raise UsageFailure(f"{name} has no {called}; its members are {', '.join(members)}")
    return members[called]


def statuses(of: Member) -> tuple[str | None, str | None]:
    """Returns two statuses: the one that a client needs to call or read a member, and the one that
    a client needs to set it or send its samples. A status is None if the member cannot be used in
    this way."""
    from gecos.dynamic_client import Attribute

    if not isinstance(of, Attribute):
        return of.access.name, None
    first = None if of.inward else of.access.name
    return first, of.write_access.name if of.inward or of.can_be_set else None


def needs(of: Member) -> list[str]:
    """Returns the sentences about the status that a member needs."""
    from gecos.dynamic_client import Attribute

    first, second = statuses(of)
    if not isinstance(of, Attribute):
        use, other = of.name, ""
    else:
        use = f"reading {of.name}"
        other = f"{'sending samples of' if of.inward else 'setting'} {of.name}"
    told = ((use, first), (other, second))
    return [f"{what} needs {_words(name)}, for every caller" for what, name in told if name]


def is_open(of: Member) -> bool:
    """Returns whether the interface declares a member as an open stream."""
    from gecos.dynamic_client import Attribute

    return isinstance(of, Attribute) and of.stream is not None and of.stream.open


def about_open_stream(name: str, forbidden_by: str) -> str:
    """Returns the sentence about the open stream `name`. `forbidden_by`: where the lab file forbids
    open streams; "" if it does not."""
    if forbidden_by:
        said = f"{forbidden_by} forbids it: no sample is sent in clear"
        return f"{name} is an open stream, and {said}"
    said = "over lcm, everybody on the network can read its samples, whatever the lists say"
    return f"{name} is an open stream: {said}"


def _words(status: str) -> str:
    return "no status" if status == "SENSOR" else f"{status.lower()} status"
