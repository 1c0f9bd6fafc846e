"""What `gecos policy test` asks the broker and an object: whose server the object has, whether the
object admits this program, and which status its members need."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from gecos.cli.exit_codes import UsageFailure

if TYPE_CHECKING:
    import gecos
    from gecos.dynamic_client.model import Member

_MOMENT = 1.0  # s for which the broker is asked; the lab file is read without it, too

_AT_BROKER = "the broker refuses this program: "
"""With this begins the reason where the broker refuses this program, whose detail is NO_SERVER."""


@dataclass(frozen=True, slots=True)
class ServerUser:
    """The user and the host of a server, and how they are known."""

    user: str
    host: str
    known_from: str  # "option", "broker" or "assumed"


class Answer(NamedTuple):
    """What an object says when this program connects."""

    admits: bool
    reason: str  # why it refuses; "" if it admits


def server_user(lab: gecos.Lab, name: str) -> ServerUser:
    """Returns the user of the server of an object, as the broker says. Assumes the user of this
    program if the broker does not know the object, or cannot be asked."""
    from gecos.dynamic_client.connect import entries, silent_objects
    from gecos.key_folder import this_user

    try:
        known = [*entries(lab, patience=_MOMENT), *(each.entry for each in silent_objects(lab))]
    except (ConnectionError, RuntimeError):
        known = []
    for entry in known:
        if entry.name == name:
            return ServerUser(entry.user, entry.hostname, "broker")
    return ServerUser(this_user(), socket.gethostname(), "assumed")


def answer(lab: gecos.Lab, name: str) -> Answer | None:
    """Connects to an object. Returns whether the object admits this program; None if that is not
    known, for example because the object is not online."""
    from gecos.cli.find import find
    from gecos.errors import CreateError, Detail

    try:
        find(lab, name)
    except CreateError as error:
        refusals = [
            each.reason
            for each in error.attempts
            if each.detail is Detail.REFUSED or each.reason.startswith(_AT_BROKER)
        ]
        return Answer(False, refusals[0]) if refusals else None
    except (ConnectionError, RuntimeError):
        return None
    return Answer(True, "")


def member(lab: gecos.Lab, name: str, called: str) -> Member:
    """Returns the operation or attribute of an object that is called `called`. Raises UsageFailure
    if there is none, and the errors of `find`."""
    import gecos
    from gecos.cli.find import find
    from gecos.dynamic_client import read_model
    from gecos.dynamic_client.connect import served_models, without_model

    found = find(lab, name)
    interface = gecos.describe(found).result().interface_name
    models = served_models(found)
    if not models:
        raise UsageFailure(without_model(name))
    members = {each.name: each for each in read_model(models, interface).members}
    if called not in members:
        raise UsageFailure(f"{name} has no {called}; its members are {', '.join(members)}")
    return members[called]


def statuses(of: Member) -> tuple[str | None, str | None]:
    """Returns the status that calling or reading needs, and the status that setting or sending
    needs. One of them is None if the member has no such use."""
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


def _words(status: str) -> str:
    return "no status" if status == "SENSOR" else f"{status.lower()} status"
