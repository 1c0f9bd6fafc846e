"""Connects to objects of any interface, with a proxy that has only the built-in operations, or all
members."""

from __future__ import annotations

import contextlib
import os
import time
from functools import cache
from typing import TYPE_CHECKING

from gecos import _core
from gecos.builtin_operations import model
from gecos.dynamic_client.model import ModelError
from gecos.dynamic_client.proxy import DynamicObject, proxy_class
from gecos.dynamic_client.silence import silent_since, told
from gecos.errors import (
    Attempt,
    CommandFailed,
    ConnectionFailed,
    CreateError,
    Detail,
    may_pass,
)
from gecos.interface import Interface
from gecos.proxy import Object

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from pathlib import Path

    from gecos_idl.broker_types import Entry, SilentObject

    from gecos.lab import Lab
    from gecos.object_watch import ObjectWatch

BROKER = "BROKER"
"""The name of the broker itself, which no broker lists."""

_ASK_ANYWAY = 1.0  # time in s after which a server that did not answer is asked again
_LEAST_PATIENCE = 0.2  # s; the last attempt of a wait gets this patience if less time is left


def entries(lab: Lab, *, patience: float = 2.0) -> list[Entry]:
    """Returns the objects that the broker knows, sorted by name. Raises CreateError without a
    broker."""
    from gecos_idl.broker import Broker

    return sorted(lab.broker(Broker, patience=patience).list().result(), key=lambda e: e.name)


def silent_objects(lab: Lab, *, patience: float = 2.0) -> list[SilentObject]:
    """Returns the objects whose servers the broker no longer hears, sorted by name. A broker of an
    older version reports no such objects. Raises CreateError without a broker."""
    from gecos_idl.broker import Broker

    try:
        return lab.broker(Broker, patience=patience).silent().result()
    except CommandFailed as error:
        if error.detail is Detail.UNKNOWN_OPERATION:
            return []
        raise


def find(
    lab: Lab, name: str, *, medium: str | None = None, patience: float = 2.0, wait: float = 0.0
) -> Object:
    """Connects to the object called `name`, whatever its interface, or to the broker itself, which
    is called BROKER. The proxy has only the built-in operations. While the object is not online, no
    broker answers, or the broker refuses this program, tries again for `wait` s. (A server that
    starts may make this user a visitor of the broker; then the broker no longer refuses.) Each
    attempt makes up to three calls, and waits up to `patience` s for each reply. Raises
    CreateError, which says since when the object is silent, proposes a similar name, or lists the
    objects online. Raises CommandFailed or ConnectionFailed if the broker dies before it has
    answered."""
    end = time.monotonic() + wait
    given = patience
    # The error to raise when no attempt succeeds.
    told: CreateError | CommandFailed | ConnectionFailed | None = None
    with contextlib.ExitStack() as opened:
        changes: ObjectWatch | None = None
        while True:
            began = time.monotonic()
            try:
                return _find_now(lab, name, medium, patience)
            except (CreateError, CommandFailed, ConnectionFailed) as error:
                now = time.monotonic()
                cut_short = patience < given and now >= began + patience
                if told is None or not cut_short or not may_pass(error):
                    told = error
                if now >= end or not may_pass(error):
                    raise told from None
            changes = changes or opened.enter_context(lab.watch())
            _await_change(changes, name, min(end, time.monotonic() + _ASK_ANYWAY))
            left = end - time.monotonic()
            patience = min(given, max(_LEAST_PATIENCE, left))


def _find_now(lab: Lab, name: str, medium: str | None, patience: float) -> Object:
    if name == BROKER and medium is None:
        from gecos_idl.broker import Broker

        return lab.broker(Broker, patience=patience)
    known = {entry.name: entry for entry in entries(lab, patience=patience)}
    entry = known.get(name)
    if entry is None:
        raise _silence(lab, name, patience) or not_online(name, list(known))
    try:
        return connect_to(lab, entry, medium=medium, patience=patience)
    except CreateError:
        silence = _silence(lab, name, patience)
        if silence is None:
            raise
        raise silence from None


def _await_change(changes: ObjectWatch, name: str, until: float) -> None:
    """Waits until the broker reports a change of the object called `name`."""
    try:
        while changes.next(max(0.0, until - time.monotonic())).entry.name != name:
            pass
    except TimeoutError:
        return
    except EOFError:
        reason = "this Lab is closed; make a new one"
        raise CreateError([Attempt(name, Detail.NO_SERVER, reason)]) from None


def not_online(name: str, known: Sequence[str]) -> CreateError:
    """Returns an error that proposes one of the names in `known`, or lists them."""
    reason = f"no such object is online; {_instead_of(name, known)}"
    return CreateError([Attempt(name, Detail.NO_SERVER, reason)])


def connect_to(
    lab: Lab, entry: Entry, *, medium: str | None = None, patience: float = 2.0
) -> Object:
    """Connects to the object that the broker lists as `entry`. The proxy has only the built-in
    operations. Raises CreateError."""
    anything = _without_members(entry.interface_name, entry.interface_hash)
    return lab.create(anything, entry.name, medium=medium, patience=patience)


def sockets_here() -> list[Path]:
    """Returns the sockets of the objects in the runtime directory of this user. The name of a
    socket begins with the first 32 characters of the name of its object, and a dot."""
    from pathlib import Path

    sockets = sorted(Path(_core.runtime_directory()).glob("*.sock"))
    return [socket for socket in sockets if socket.name != "BROKER.sock"]


def connect_here(lab: Lab, socket: Path, *, patience: float = 2.0) -> Object | str | None:
    """Connects to the object of a socket without a broker. The proxy has only the built-in
    operations. Returns the reason if the object does not answer although its server seems to live.
    Returns None if no server listens: a killed server has left the socket over."""
    anything = _without_members("gecos::GecosObject", 0)
    answer = lab._at(anything, f"shm:{socket}", patience)
    return None if isinstance(answer, str) and "no server listens" in answer else answer


def _silence(lab: Lab, name: str, patience: float) -> CreateError | None:
    """Returns an error that says since when the broker has not heard the server of `name`, or None
    if the broker hears the server."""
    found = (one for one in silent_objects(lab, patience=patience) if one.entry.name == name)
    return next(map(silence_of, found), None)


def silence_of(one: SilentObject) -> CreateError:
    """Returns an error that says since when the broker has not heard the server of an object."""
    since, of = silent_since(one.silent_for), one.entry
    reason = f"its server, {of.user}@{of.hostname} pid {of.pid}, is {told(since)}"
    return CreateError([Attempt(of.name, Detail.NO_SERVER, reason, since)])


def connect(
    lab: Lab,
    name: str,
    *,
    medium: str | None = None,
    patience: float = 2.0,
    wait: float = 0.0,
    only: Collection[str] | None = None,
) -> DynamicObject:
    """Connects to the object called `name`, with a proxy that is made from the model that the
    object serves. The proxy has all members of the interface, or only the members named in `only`,
    which takes less time."""
    found = find(lab, name, medium=medium, patience=patience, wait=wait)
    interface = interface_of(found, only)
    if name == BROKER:
        return lab.broker(interface, patience=patience)
    return lab.create(interface, name, medium=medium, patience=patience)


def interface_of(found: Object, only: Collection[str] | None = None) -> type[DynamicObject]:
    """Returns the class of proxies for the object `found`, from the model that it serves. `only`:
    see `connect`. Raises ModelError."""
    interface = found._gecos_interface.name
    texts = served_models(found)
    if not texts:
        raise ModelError(interface, without_model(found._gecos_session.object_name))
    return _class_of(interface, tuple(texts), None if only is None else frozenset(only))


def dynamic(
    name: str,
    lab: Lab | None = None,
    *,
    medium: str | None = None,
    patience: float = 2.0,
    wait: float = 0.0,
) -> DynamicObject:
    """Does the same as `lab.dynamic(name)`. Without `lab`, uses a Lab that this process keeps until
    it ends."""
    return connect(lab or _lab_of_process(), name, medium=medium, patience=patience, wait=wait)


@cache
def _lab_of_process() -> Lab:
    from gecos.lab import Lab

    return Lab()


# A forked child cannot use the Lab of its parent.
os.register_at_fork(after_in_child=_lab_of_process.cache_clear)


def without_model(name: str) -> str:
    """Returns the error text for an object that serves no model, so that its members are
    unknown."""
    return (
        f"{name} serves no model; generate the code of its server again, with this version of gidl"
    )


def served_models(robot: Object) -> list[str]:
    """Returns the models that an object serves. The list is empty for a server of an older
    version."""
    try:
        return model(robot).result()
    except CommandFailed as error:
        if error.detail is Detail.UNKNOWN_OPERATION:
            return []
        raise


@cache
def _without_members(name: str, hash: int) -> type[Object]:
    table = Interface(name=name, hash=hash)
    return type("ObjectWithoutMembers", (Object,), {"_gecos_interface": table})


@cache
def _class_of(
    name: str, texts: tuple[str, ...], only: frozenset[str] | None
) -> type[DynamicObject]:
    return proxy_class(texts, name, only)


def _instead_of(name: str, known: Sequence[str]) -> str:
    from difflib import get_close_matches

    by_lower = {one.lower(): one for one in known}
    near = get_close_matches(name.lower(), by_lower, n=1)
    if near:
        return f"did you mean {by_lower[near[0]]}?"
    if not known:
        return "start the object's server: the broker knows no object"
    return f"start the object's server, or choose a name that the broker knows: {', '.join(known)}"
