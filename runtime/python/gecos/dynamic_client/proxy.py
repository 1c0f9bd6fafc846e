"""Makes the class of a proxy from the model that an object serves.

The class has the same members as a generated proxy. Values are plain data, as in `gecos.wire.json`:
for example `robot.move({"position": {"x": 0.4, "y": 0, "z": 0.3}, …}).result()`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from types import SimpleNamespace
from typing import Any, ClassVar

from gecos.command import Command
from gecos.dynamic_client.docs import attribute_doc, operation_doc, setter_doc
from gecos.dynamic_client.json_object import Malformed
from gecos.dynamic_client.model import Attribute, Member, Model, ModelError, Operation, Struct
from gecos.dynamic_client.names import METHOD_WORDS, escaped, simple
from gecos.dynamic_client.read import read_model
from gecos.dynamic_client.request import Request
from gecos.dynamic_client.types import Types
from gecos.errors import DeclaredError
from gecos.interface import Event as EventTable
from gecos.interface import (
    Interface,
    Inward,
    Kind,
    Method,
    event,
    getter,
    interface,
    inward,
    method,
    quality_of_calls,
)
from gecos.interface import Operation as OperationTable
from gecos.proxy import Event, Object, StreamAttribute
from gecos.record import replace
from gecos.wire import Decoder, layout
from gecos.wire.kinds import kind_of
from gecos.writer import InwardAttribute


class DynamicObject(Object):
    """The base class of proxies that are made at run time."""

    _gecos_model: ClassVar[Model]


def proxy_class(
    models: Sequence[str], name: str, only: Collection[str] | None = None
) -> type[DynamicObject]:
    """Makes the class of proxies for the interface `name`. `models` are the served texts of the
    interface and all its bases. `only` names the members to make; the default is all members.
    Raises ModelError if the texts are not valid."""
    model = read_model(models, name)
    try:
        return _Builder(model).built(only)
    except Malformed as error:
        raise ModelError(name, str(error)) from None


def description_of(proxy: DynamicObject | type[DynamicObject]) -> Model:
    """Returns the model of the object's interface. Its `members` describe operations and
    attributes."""
    return proxy._gecos_model


class _Builder:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._types = Types(model)
        self._errors: dict[str, type[DeclaredError]] = {}
        self._methods: dict[str, list[Method[Any, Any]]] = {name: [] for name in model.interfaces}
        self._inward: dict[str, list[Inward[Any]]] = {name: [] for name in model.interfaces}
        self._events: dict[str, list[EventTable[Any]]] = {name: [] for name in model.interfaces}
        self._entries: dict[str, Any] = {}

    def built(self, only: Collection[str] | None) -> type[DynamicObject]:
        model = self._model
        for member in model.members:
            if only is None or member.name in only:
                for name, entry in self._members(member):
                    if name in self._entries:
                        raise Malformed(f"two members of {model.interface} are called {name}")
                    self._entries[name] = entry
        entries = self._entries | {
            "__doc__": model.own.doc,
            "__module__": __name__,
            "_gecos_interface": self._tables(),
            "_gecos_model": model,
        }
        return type(simple(model.interface), (DynamicObject,), entries)

    def _tables(self) -> Interface:
        known: dict[str, Interface] = {}
        for each in self._model.interfaces.values():
            bases: list[Any] = [SimpleNamespace(_gecos_interface=known[b]) for b in each.bases]
            known[each.name] = interface(
                each.name,
                each.version,
                each.hash,
                bases,
                self._methods[each.name],
                each.quality,
                inward=self._inward[each.name],
                events=self._events[each.name],
            )
        return known[self._model.interface]

    def _members(self, member: Member) -> Iterator[tuple[str, Any]]:
        """Yields the names and the values of the class attributes that a member needs."""
        name = escaped(member.name, METHOD_WORDS)
        if isinstance(member, Operation):
            yield name, self._operation(member, name)
            return
        if member.inward:
            yield name, self._writer(member)
            return
        if member.event:
            yield name, self._event(member)
            return
        yield name, self._getter(member, name)
        if member.can_be_set:
            yield f"set_{member.name}", self._setter(member)

    def _operation(self, member: Operation, name: str) -> Any:
        request = Request(member.name, member.inputs, self._types, self._model)
        outputs = member.outputs
        several = len(outputs) > 1
        gives = self._types.result(member) if several else None
        made = self._table(
            OperationTable(
                member.code,
                member.name,
                member.access,
                safety=member.safety,
                presence=member.presence,
                idempotent=member.idempotent,
                cancelable=member.cancelable,
                parallel=member.parallel,
                ordered=member.ordered,
                on_new=member.on_new,
                on_loss=member.on_loss,
                quality=member.quality,
                hash=member.hash,
            ),
            member,
            request,
            self._types.step(outputs[0]) if len(outputs) == 1 else gives,
            member.raises,
        )
        names = dict(zip((each.name for each in member.inputs), request.spelled, strict=True))
        doc = operation_doc(member, names, self._model)
        return _caller(made, request, name, doc, _given(member))

    def _getter(self, member: Attribute, name: str) -> Any:
        request = Request(member.name, (), self._types, self._model)
        stream = member.stream
        made = self._table(
            getter(
                member.code,
                member.name,
                member.access,
                parallel=member.parallel,
                on_new=member.on_new,
                on_loss=member.on_loss,
                quality=member.quality,
                hash=member.hash,
            ),
            member,
            request,
            self._types.step(member.result),
            member.raises,
            None if stream is None else (stream.rate_hz, stream.largest),
        )
        doc = attribute_doc(member)
        if stream is None:
            return _caller(made, request, name, doc, member.result.type)
        return property(lambda proxy: StreamAttribute(proxy, made), doc=doc)

    def _setter(self, member: Attribute) -> Any:
        value = replace(member.result, direction="in", doc="")
        request = Request(member.name, (value,), self._types, self._model)
        made = self._table(
            OperationTable(
                member.set_code,
                f"{member.name}=",
                member.write_access,
                kind=Kind.SETTER,
                presence=member.write_presence,
                idempotent=member.idempotent,
                parallel=member.parallel,
                on_new=member.on_new,
                on_loss=member.on_loss,
                quality=quality_of_calls(member.quality) if member.stream else member.quality,
                hash=member.hash,
            ),
            member,
            request,
            None,
            member.set_raises,
        )
        return _caller(made, request, f"set_{member.name}", setter_doc(member), "None")

    def _writer(self, member: Attribute) -> Any:
        value = replace(member.result, direction="in", doc="")
        request = Request(member.name, (value,), self._types, self._model)
        assert member.stream is not None
        made = inward(
            member.code,
            member.name,
            member.write_access,
            gives=self._types.step(member.result),
            presence=member.write_presence,
            rate_hz=member.stream.rate_hz,
            watchdog_ns=member.stream.watchdog_ns,
            largest=member.stream.largest,
            quality=member.quality,
            hash=member.hash,
        )
        made = replace(made, body=lambda sample: request.encoded((sample,), {}))
        self._inward[member.interface].append(made)
        return property(lambda proxy: InwardAttribute(proxy, made), doc=attribute_doc(member))

    def _event(self, member: Attribute) -> Any:
        assert member.stream is not None
        gives = self._types.step(member.result)
        made = event(
            member.code,
            member.name,
            member.access,
            gives=gives,
            largest=member.stream.largest,
            quality=member.quality,
            hash=member.hash,
        )
        made = replace(made, result=_plainly(made.result, kind_of(gives).plain))
        self._events[member.interface].append(made)
        return property(lambda proxy: Event(proxy, made), doc=attribute_doc(member))

    def _table(
        self,
        operation: OperationTable,
        member: Member,
        request: Request,
        gives: layout.Step | None,
        raises: tuple[str, ...],
        stream: tuple[float, int] | None = None,
    ) -> Method[Any, Any]:
        """Builds the `Method` of a call of `member`. Its decoders return plain data."""
        names = request.arguments.names
        made = method(
            operation,
            takes=(names, request.steps, request.defaults) if names else None,
            gives=gives,
            raises=tuple(self._error(name) for name in raises),
            stream=stream,
        )
        if gives is not None:
            made = replace(made, result=_plainly(made.result, kind_of(gives).plain))
        if member.feedback:
            made = replace(made, feedback=self._feedback(member))
        self._methods[member.interface].append(made)
        return made

    def _feedback(self, member: Member) -> Callable[[Decoder], Any]:
        if not isinstance(self._model.types.get(member.feedback), Struct):
            raise Malformed(f"the feedback of {member.interface}::{member.name} is not a struct")
        kind = self._types.named(member.feedback)
        return _plainly(kind.decode, kind._gecos_layout.plain)

    def _error(self, name: str) -> type[DeclaredError]:
        """Returns the class of a declared exception. The members of a received exception are plain
        data."""
        if name not in self._errors:
            kind = self._types.named(name)
            kind.decode = classmethod(_plain_members(kind.decode.__func__, kind._gecos_layout))
            self._errors[name] = kind
        return self._errors[name]


def _plain_members(decode: Callable[..., Any], described: Any) -> Callable[..., Any]:
    def plain_members(cls: Any, source: Decoder, /) -> Any:
        return cls(*described.plain(decode(cls, source)).values())

    return plain_members


def _plainly(
    decode: Callable[[Decoder], Any], plain: Callable[[Any], Any]
) -> Callable[[Decoder], Any]:
    return lambda source: plain(decode(source))


def _caller(
    table: Method[Any, Any], request: Request, name: str, doc: str, gives: str
) -> Callable[..., Command[Any, Any]]:
    def call(proxy: DynamicObject, /, *given: Any, **named: Any) -> Command[Any, Any]:
        return proxy._gecos_call(table, request.encoded(given, named))

    call.__name__ = call.__qualname__ = name
    call.__doc__ = doc
    call.__signature__ = request.signature(gives)  # type: ignore[attr-defined]
    return call


def _given(operation: Operation) -> str:
    """Returns the result of an operation as a text for its signature."""
    outputs = {each.name: each.type for each in operation.outputs}
    if len(outputs) < 2:
        return next(iter(outputs.values()), "None")
    return "{" + ", ".join(f"{name}: {type}" for name, type in outputs.items()) + "}"
