"""The laboratory as this process sees it: the class that finds objects and connects to them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from enum import IntEnum
from numbers import Real
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypedDict, TypeVar

from gecos import _core, shutdown
from gecos.errors import Attempt, CreateError, Detail
from gecos.interface import Interface, QualityClass, Reliability
from gecos.program import check_environment, program_name
from gecos.proxy import Object

if TYPE_CHECKING:
    from gecos_idl.broker_types import Entry
    from gecos_idl.object_ref_types import ObjectRef

    from gecos.dynamic_client import DynamicObject
    from gecos.explanation import Explanation, Violation
    from gecos.object_watch import ObjectWatch

P = TypeVar("P", bound=Object)
# The lab file is read when the broker is searched, not when a Lab is made or printed.
_BY_DEFAULT = "of the lab file, else of this host"
_SHORTEST = 1e-9  # s; the extension takes a shorter time as no limit


class CreateOptions(TypedDict, total=False):
    """The keyword arguments of `Lab.create` that functions which call it pass on."""

    medium: str | None
    in_: str | None
    out: str | None
    latency: float | None
    class_: str | None
    reliability: str | None
    deadline: float | None
    lifespan: float | None
    liveliness: str | None
    patience: float


class Lab:
    """Finds objects through a broker, and connects to them. The broker is at the address `broker`
    ("shm:…", "lcm:…"), or else at `GECOS_BROKER`, or else at `[broker] address` of the lab file, or
    else on this host. A Lab is thread-safe. Use it as a context manager to close it early;
    otherwise it is closed at the end of the program, after all leases and servers."""

    def __init__(self, broker: str | None = None) -> None:
        check_environment()
        self._core = _core.Lab(broker or "", program_name())
        self._broker = broker or os.environ.get("GECOS_BROKER") or _BY_DEFAULT
        self._closed = False
        shutdown.at_exit(self, shutdown.Turn.LABS)

    def create(
        self,
        interface: type[P],
        names: str | Sequence[str] | ObjectRef,
        *,
        medium: str | None = None,
        in_: str | None = None,
        out: str | None = None,
        latency: float | None = None,
        class_: str | None = None,
        reliability: str | None = None,
        deadline: float | None = None,
        lifespan: float | None = None,
        liveliness: str | None = None,
        patience: float = 2.0,
        wait: float = 0.0,
    ) -> P:
        """Connects to the first of `names` that is online and of the right type.

        `medium` names the medium to use ("inproc", "shm", "lcm"). The default is the best one that
        fulfils the interface's quality. `in_` and `out` name a medium for one direction: samples
        and events of the object come in over `in_`; calls and inward samples go out over `out`, and
        results come back over it. If a named medium is not available, `create` fails even if other
        media are available. `latency` is the longest round trip in s that the program accepts, also
        from a simulated device; the interface may demand a shorter one. If there is a limit, each
        medium is measured by a few pings before it is used. `patience` is the longest wait in s for
        an answer of the broker and of each server. If `create` reaches no object, and at least one
        of the objects is not online or no broker answers, `create` tries again for `wait` s;
        `math.inf` means without limit. `create` does not try again if all objects are online and
        none can be used, for example because of its type. Raises CreateError with a reason for each
        name.

        `class_`, `reliability`, `deadline`, `lifespan` and `liveliness` request quality in addition
        to the `@qos` of the interface: each operation and each stream of the object has the
        stricter of the declared and the requested value of each term. A looser request changes
        nothing.

        * `class_` ("SOFT_REALTIME", "HARD_REALTIME"): if no medium meets the class, `create` fails,
          also for a simulated device. Each `latency` that the interface declares then limits the
          round trip.
        * `reliability` ("RELIABLE"): a subscription or writer fails over a medium that may lose
          samples. Calls are reliable anyway.
        * `deadline`: the longest time in s of a call from sending to completion, unless
          `with_deadline` gives the call another one, and the longest gap in s between two samples
          of a stream or event.
        * `lifespan`: the age in s above which a sample of a stream or event is not returned.
        * `liveliness` ("MANUAL"): a stream or event that has a deadline is not `alive` from a
          missed deadline to its next sample.

        `start_by` and `depth` cannot be requested, because the server applies them.

        Instead of names, a reference may be given (`lab.create(Tool, changer.current().result())`).
        A reference is valid only while the server process that it refers to serves the object,
        because a restarted process may have another state. A nil reference is refused.
        """
        if isinstance(names, type) and issubclass(names, Object):
            raise TypeError(
                "the arguments are exchanged: the class comes first; write "
                f"`lab.create({names.__name__}, {interface!r})`"
            )
        table = table_of(interface)
        wanted, incarnation = _wanted(names)
        created = self._core.create(
            table,
            wanted,
            (medium, in_, out),
            _longest("latency", latency),
            (
                _number_of(QualityClass, "class", class_),
                _number_of(Reliability, "reliability", reliability),
                _longest("deadline", deadline),
                _longest("lifespan", lifespan),
                _number_of(_Liveliness, "liveliness", liveliness) == _Liveliness.MANUAL,
            ),
            patience,
            incarnation,
            wait,
        )
        if isinstance(created, list):
            raise CreateError([Attempt(name, Detail(d), reason) for name, d, reason in created])
        return interface(created)

    def dynamic(
        self,
        name: str,
        *,
        medium: str | None = None,
        patience: float = 2.0,
        wait: float = 0.0,
    ) -> DynamicObject:
        """Connects to the object called `name` without generated code, by the model that the object
        serves. The proxy has the members of a generated one; values are plain data, as in JSON:

            gripper = lab.dynamic("GRIPPER")
            gripper.max_width().result()  # 0.08
            with gecos.actor(gripper):
                gripper.open(width=0.05).result()

        `medium`, `patience` and `wait` have the same meaning as in `create`. Raises CreateError
        like `create`. Raises ModelError if the object serves no model, or a model that is not
        valid. Raises CommandFailed or ConnectionFailed if the broker does not send its list, or if
        the object does not send its model.
        """
        from gecos.dynamic_client.connect import connect

        return connect(self, name, medium=medium, patience=patience, wait=wait)

    def explain(self, interface: type[Object], name: str, *, patience: float = 2.0) -> Explanation:
        """Returns the media over which `create(interface, name)` would reach an object, and the
        reasons against each of the other media. Asks the broker, and opens no session with the
        object.

        Raises CreateError as `create` does, if the object is not online or has another interface.
        """
        from gecos.explanation import Explanation, MediumVerdict, UnsuitedMember, Violation

        told = self._core.explain(table_of(interface), name, patience)
        if isinstance(told, list):
            raise CreateError([Attempt(tried, Detail(d), reason) for tried, d, reason in told])

        def violated(terms: list[tuple[str, str]]) -> tuple[Violation, ...]:
            return tuple(Violation(*each) for each in terms)

        interface_name, hostname, simulated, media = told
        verdicts = (
            MediumVerdict(
                medium,
                address,
                unreachable,
                violated(terms),
                tuple(UnsuitedMember(it, violated(its), alone) for it, its, alone in members),
                real_time_by,
            )
            for medium, address, unreachable, terms, members, real_time_by in media
        )
        return Explanation(name, interface_name, hostname, simulated, tuple(verdicts))

    def broker(self, interface: type[P], *, patience: float = 2.0) -> P:
        """Connects to the broker itself: pass `gecos_idl.broker.Broker` as `interface`.

        Raises CreateError, which lists the attempts.
        """
        opened = self._core.broker(table_of(interface), patience)
        if isinstance(opened, str):
            raise CreateError([Attempt("BROKER", Detail.NO_SERVER, opened)])
        return interface(opened)

    def _at(self, interface: type[P], address: str, patience: float) -> P | str:
        """Connects to the object at an address, without a broker. Only the built-in operations can
        be called. Returns the reason if this fails."""
        opened = self._core.session_at(table_of(interface), address, patience)
        return opened if isinstance(opened, str) else interface(opened)

    def objects(
        self, interface: type[Object] | str | None = None, *, patience: float = 2.0
    ) -> list[Entry]:
        """Returns the objects online that have `interface` or an interface derived from it, sorted
        by name; without `interface`, all objects.

        `interface` is a class that gidl generated, or a scoped name: `"robcl::Manipulator"`. Raises
        CreateError if no broker answers.
        """
        from gecos_idl.broker_types import Entry

        from gecos.wire import from_bytes

        found = self._core.objects(_name_of(interface), patience)
        if isinstance(found, str):
            raise CreateError([Attempt("BROKER", Detail.NO_SERVER, found)])
        return [from_bytes(Entry, encoded) for encoded in found]

    def watch(self, interface: type[Object] | str | None = None) -> ObjectWatch:
        """Watches which objects come online, fall silent and go:

        with lab.watch("robcl::Manipulator") as changes:
            for change in changes:
                print(change.entry.name, change.presence.name)
        """
        from gecos.object_watch import ObjectWatch

        return ObjectWatch(self._core.watch(_name_of(interface)))

    def close(self) -> None:
        """Closes the session with every object, even if proxies, leases or streams remain.

        Leases are released. Commands that arrived at a server under these leases still finish
        there, but end in this process as OUTCOME_UNKNOWN. Readers of streams raise StreamLost.
        Proxies of this Lab are unusable afterwards. Servers of this Lab keep running. Closing takes
        at most about one second, and 0.2 s more for each server over lcm that does not answer.
        """
        self._closed = True
        self._core.close()

    def __repr__(self) -> str:
        return f"<Lab: {'closed' if self._closed else 'open'}, broker {self._broker}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


class _Liveliness(IntEnum):
    AUTOMATIC = 0
    MANUAL = 1


def _wanted(names: str | Sequence[str] | ObjectRef) -> tuple[list[str], int]:
    """Returns the names to try, and the incarnation that a reference demands; 0 without one."""
    if isinstance(names, str):
        return [names], 0
    if isinstance(names, Sequence) and all(isinstance(name, str) for name in names):
        return list(names), 0
    from gecos_idl.object_ref_types import ObjectRef

    if isinstance(names, ObjectRef):
        return [names.name], names.boot
    raise TypeError(
        "the second argument must be the name of an object, a sequence of names, such as "
        f'`["LEFT", "RIGHT"]`, or a reference, not {names!r}'
    )


def _number_of(values: type[IntEnum], term: str, written: str | None) -> int:
    """Returns the number of the value of a term of `@qos`; 0 if the term is not requested."""
    if written is None:
        return 0
    names = [each.name for each in values if each.name != "DEFAULT"]
    if written not in names:
        raise ValueError(
            f"{written!r} is no {term}; choose {', '.join(names[:-1])} or {names[-1]}, as in @qos"
        )
    return values[written].value


def _longest(term: str, seconds: float | None) -> float:
    """Returns a longest time that is requested; 0 if none is requested."""
    if seconds is None:
        return 0.0
    if isinstance(seconds, bool) or not isinstance(seconds, Real):
        raise TypeError(f"{term} must be a number of seconds, such as 0.5, not {seconds!r}")
    if not seconds >= _SHORTEST:
        raise ValueError(
            f"{term} must be 1 ns or more, not {seconds} s; leave it out to request no {term}"
        )
    return float(seconds)


def _name_of(interface: type[Object] | str | None) -> str:
    if interface is None or isinstance(interface, str):
        return interface or ""
    return table_of(interface).name


def table_of(interface: type[Object]) -> Interface:
    if isinstance(interface, type) and issubclass(interface, Object):
        return interface._gecos_interface
    given = f"the class {interface.__name__}" if isinstance(interface, type) else repr(interface)
    raise TypeError(
        f"the first argument must be the class that gidl generated for the interface, not {given}: "
        'write `from robcl.rx90 import Rx90` and `lab.create(Rx90, "RX90")`'
    )
