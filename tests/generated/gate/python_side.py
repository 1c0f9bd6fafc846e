"""What generated Python says: values are built from neutral ones without a check, and sent,
received, printed and turned into JSON. Calls are made without a server."""

from __future__ import annotations

import dataclasses
import enum
import json
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import gecos.wire.json
import numpy as np
import spelled
from gecos import wire
from gecos.errors import DeclaredError
from gecos.interface import Method
from gecos.proxy import StreamAttribute
from gidl.files.names import python_module
from gidl.model import (
    ArrayType,
    Bitmask,
    Bitset,
    EnumDeclaration,
    Interface,
    MapType,
    Model,
    NamedType,
    Primitive,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Union,
)
from gidl.targets.python import names
from gidl.wire.wire_layout import Layout
from neutral import (
    REFERENCE,
    Slot,
    arms,
    chosen,
    element,
    has_nan,
    is_hand_written,
    members,
    named_fields,
    raw,
    settled,
)

DTYPES = {
    Primitive.BOOLEAN: "?", Primitive.OCTET: "u1", Primitive.INT8: "i1", Primitive.UINT8: "u1",
    Primitive.INT16: "i2", Primitive.UINT16: "u2", Primitive.INT32: "i4", Primitive.UINT32: "u4",
    Primitive.INT64: "i8", Primitive.UINT64: "u8", Primitive.FLOAT: "f4", Primitive.DOUBLE: "f8",
}  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """Accepted, with bytes in the neutral form or of the wire; or refused, and why."""

    fine: bool
    bytes: bytes
    why: str = ""


def judged(work: Callable[[], bytes]) -> Verdict:
    """A value of another type is a TypeError; any other exception is a fault of the code."""
    try:
        return Verdict(True, work())
    except (wire.EncodeError, wire.DecodeError, wire.JsonError, TypeError) as error:
        return Verdict(False, b"", f"{''.join(traceback.format_exception(error))}{error}")
    except Exception:
        return Verdict(False, b"", "FAULT " + traceback.format_exc())


class Types:
    """Values of generated types."""

    def __init__(self, model: Model, layout: Layout) -> None:
        self._model = model
        self._layout = layout

    def kind(self, name: str) -> Any:
        return spelled.python(self._model, self._layout, name)

    def sent(self, name: str, value: Any) -> Verdict:
        return judged(lambda: wire.to_bytes(self.built(Slot(NamedType(name)), value)))

    def printed(self, name: str, value: Any) -> str:
        """All texts that a program or a log gets of the value without asking for its members."""
        made = self.built(Slot(NamedType(name)), value)
        texts = [repr(made), str(made), f"{made}", f"{made!r:>3}"]
        if isinstance(made, BaseException):
            try:
                raise made
            except BaseException as error:
                texts.append("".join(traceback.format_exception(error)))
                texts.append(
                    repr(DeclaredError.__str__(error)) if isinstance(error, DeclaredError) else ""
                )
        return "\n".join(texts)

    def received(self, name: str, data: bytes) -> Verdict:
        def work() -> bytes:
            slot = Slot(NamedType(name))
            value = self.neutral(slot, wire.from_bytes(self.kind(name), data))
            nan.append(has_nan(value))
            return raw(self._model, slot, value)

        nan: list[bool] = []
        verdict = judged(work)
        return Verdict(True, verdict.bytes, "NaN") if any(nan) else verdict

    def to_json(self, name: str, data: bytes) -> Verdict:
        made = wire.from_bytes(self.kind(name), data)
        return judged(lambda: gecos.wire.json.dumps(made).encode())

    def from_json(self, name: str, text: bytes) -> Verdict:
        return judged(lambda: wire.to_bytes(gecos.wire.json.loads(self.kind(name), text)))

    # -- neutral to Python ---------------------------------------------------------------------

    def built(self, slot: Slot, value: Any) -> Any:
        slot = settled(self._model, slot)
        if slot.optional:
            return self.built(Slot(slot.type, slot.range), value[0]) if value else None
        match slot.type:
            case PrimitiveType(Primitive.BOOLEAN):
                return bool(value)
            case PrimitiveType(Primitive.CHAR):
                return chr(value)
            case PrimitiveType():
                return value
            case StringType():
                return value.decode("utf-8", "surrogateescape")
            case SequenceType(PrimitiveType(Primitive.OCTET)):
                return bytes(value)
            case ArrayType(PrimitiveType(Primitive.OCTET), (_,)):
                return bytes(value)
            case SequenceType() | ArrayType():
                numbers = self._dtype(element(slot))
                if numbers is not None:
                    return np.array(value, numbers).reshape(_shape(slot.type, value))
                return [self.built(element(slot), item) for item in value]
            case MapType(key, kind):
                return {self.built(Slot(key), k): self.built(Slot(kind), v) for k, v in value}
            case NamedType(name):
                return self._named(name, value)

    def _dtype(self, slot: Slot) -> str | None:
        """The numpy type of an array of such elements; None for elements in a list."""
        used = slot.type
        if isinstance(used, ArrayType):
            used = used.element
        used = settled(self._model, Slot(used)).type
        return DTYPES.get(used.kind) if isinstance(used, PrimitiveType) else None

    def _named(self, name: str, value: Any) -> Any:
        declaration = self._model.find(name)
        match declaration:
            case Interface():
                texts = [self.built(s, v) for s, v in zip(REFERENCE, value, strict=True)]
                return import_module("gecos_idl.object_ref_types").ObjectRef(*texts)
            case EnumDeclaration() | Bitmask():
                return self.kind(name)(value)
            case Bitset():
                fields = zip(named_fields(self._model, declaration), value, strict=True)
                return self.kind(name)(*(self.built(Slot(f.type), v) for f, v in fields))
            case Struct() if is_hand_written(declaration):
                return self.kind(name).decode(wire.Decoder(value))
            case Struct():
                slots = members(self._model, declaration)
                given = (self.built(s, v) for s, v in zip(slots, value, strict=True))
                return self.kind(name)(*given)
            case Union():
                tag, index, held = value
                made = self.built(arms(declaration)[index - 1], held[0]) if index else None
                return self.kind(name)(self.built(Slot(declaration.discriminator), tag), made)
        raise AssertionError(name)

    # -- Python to neutral ---------------------------------------------------------------------

    def neutral(self, slot: Slot, value: Any) -> Any:
        slot = settled(self._model, slot)
        if slot.optional:
            return [] if value is None else [self.neutral(Slot(slot.type), value)]
        match slot.type:
            case PrimitiveType(Primitive.CHAR):
                return ord(value)
            case PrimitiveType(kind):
                return float(value) if kind.is_floating else int(value)
            case StringType():
                return value.encode()
            case SequenceType() | ArrayType():
                return [self.neutral(element(slot), item) for item in value]
            case MapType(key, kind):
                pairs = [
                    [self.neutral(Slot(key), k), self.neutral(Slot(kind), v)]
                    for k, v in value.items()
                ]
                return sorted(pairs, key=lambda pair: pair[0])
            case NamedType(name):
                return self._neutral_named(name, value)

    def _neutral_named(self, name: str, value: Any) -> Any:
        declaration = self._model.find(name)
        match declaration:
            case Interface():
                return self._members(list(REFERENCE), value)
            case EnumDeclaration() | Bitmask():
                assert isinstance(value, enum.IntEnum | enum.IntFlag), f"{value!r} is no {name}"
                return int(value)
            case Bitset():
                slots = [Slot(f.type) for f in named_fields(self._model, declaration)]
                return self._members(slots, value)
            case Struct() if is_hand_written(declaration):
                return wire.to_bytes(value)
            case Struct():
                return self._members(members(self._model, declaration), value)
            case Union():
                tag, held = (getattr(value, f.name) for f in dataclasses.fields(value))
                number = self.neutral(Slot(declaration.discriminator), tag)
                index = chosen(self._model, declaration, number)
                if not index:
                    assert held is None
                    return [number, 0, []]
                return [number, index, [self.neutral(arms(declaration)[index - 1], held)]]
        raise AssertionError(name)

    def _members(self, slots: list[Slot], value: Any) -> list[Any]:
        given = [getattr(value, field.name) for field in dataclasses.fields(value)]
        return [self.neutral(s, v) for s, v in zip(slots, given, strict=True)]


def _shape(used: Any, value: Any) -> tuple[int, ...]:
    if isinstance(used, ArrayType):
        return tuple(used.dimensions)
    if isinstance(used.element, ArrayType):
        return (len(value), *used.element.dimensions)
    return (len(value),)


@dataclass(frozen=True)
class Values:
    """The arguments or the result of a call, in bytes."""

    method: Method[Any, Any]
    bytes: bytes
    are_arguments: bool


class Calls:
    """Calls of one interface: what a proxy sends and hears, what a servant hears and sends."""

    def __init__(self, model: Model, types: Types, interface: Interface) -> None:
        self._model = model
        self._types = types
        module = import_module(python_module(model.file_of(interface.name)))
        kinds = [
            k
            for k in vars(module).values()
            if isinstance(k, type) and _name_of(k) == interface.name
        ]
        self._proxy = next(k for k in kinds if not hasattr(k, "_gecos_handlers"))
        self._servant = next(k for k in kinds if hasattr(k, "_gecos_handlers"))
        self.methods: dict[int, Method[Any, Any]] = {}

    def asked(self, code: int, slots: list[Slot], values: list[Any]) -> Verdict:
        """Arguments given to the proxy: the request."""
        return judged(lambda: self._asked(code, slots, values)[1])

    def _asked(
        self, code: int, slots: list[Slot], values: list[Any]
    ) -> tuple[Method[Any, Any], bytes]:
        handler = self._servant._gecos_handlers[code]
        caught: list[tuple[Method[Any, Any], bytes]] = []

        class Probe(self._proxy):  # type: ignore[misc, name-defined]
            def __init__(self) -> None:
                super().__init__(None)

            def _gecos_call(self, method: Method[Any, Any], out: wire.Parts) -> None:
                caught.append((method, b"".join(out)))

        entry = getattr(Probe(), handler.method)
        arguments = [self._types.built(s, v) for s, v in zip(slots, values, strict=True)]
        if isinstance(entry, StreamAttribute):
            entry()
        else:
            entry(*arguments)
        return caught[0]

    def heard_reply(
        self, code: int, inputs: list[Slot], arguments: list[Any], slots: list[Slot], reply: bytes
    ) -> Verdict:
        """A reply given to the proxy: the results."""

        def work() -> bytes:
            method, _ = self._asked(code, inputs, arguments)
            result = method.result(wire.Decoder(reply))
            return self._raw_result(slots, result)

        return judged(work)

    def _raw_result(self, slots: list[Slot], result: Any) -> bytes:
        if not slots:
            assert result is None
            return b""
        given = [result]
        if len(slots) > 1:
            given = [getattr(result, field.name) for field in dataclasses.fields(result)]
        return self._raw(slots, given)

    def _raw(self, slots: list[Slot], given: list[Any]) -> bytes:
        out = b""
        for slot, value in zip(slots, given, strict=True):
            out += raw(self._model, slot, self._types.neutral(slot, value))
        return out

    def heard_request(self, code: int, slots: list[Slot], request: bytes) -> Verdict:
        """A request given to the servant: the arguments of the handler."""
        handler = self._servant._gecos_handlers[code]
        return judged(lambda: self._raw(slots, list(handler.arguments(wire.Decoder(request)))))

    def values(self, of: Values) -> tuple[Verdict, Verdict]:
        """What Python makes of the bytes of arguments or of a result: the bytes again, and JSON."""

        def value() -> Any:
            if of.are_arguments:
                return of.method.arguments.decode(wire.Decoder(of.bytes))
            return of.method.result(wire.Decoder(of.bytes))

        def written() -> bytes:
            if of.are_arguments:
                return b"".join(of.method.arguments.encode(*value()))
            return b"".join(of.method.body(value()))

        def text() -> bytes:
            known = of.method
            plain = known.arguments.plain if of.are_arguments else known.plain_result
            return json.dumps(plain(value()), ensure_ascii=False).encode()

        return judged(written), judged(text)

    def values_from_json(self, of: Values, text: bytes) -> Verdict:
        """The bytes of the arguments or result in `text`; else the path of what is wrong."""

        def made() -> bytes:
            data = gecos.wire.json.plain(text)
            if of.are_arguments:
                return b"".join(of.method.arguments.encode(*of.method.arguments.made_values(data)))
            return b"".join(of.method.body(of.method.made_result(data)))

        try:
            return Verdict(True, made())
        except wire.JsonError as error:
            return Verdict(False, b"", error.path)
        except wire.EncodeError as error:
            return Verdict(False, b"", error.field)

    def find_method(self, code: int, slots: list[Slot], values: list[Any]) -> None:
        """Keeps in `methods` how the proxy describes a call. The values must be valid arguments."""
        self.methods[code] = self._asked(code, slots, values)[0]

    def answered(
        self,
        code: int,
        inputs: list[Slot],
        arguments: list[Any],
        slots: list[Slot],
        values: list[Any],
    ) -> tuple[Verdict, str]:
        """Results given by a handler: the reply, and the text of what was given."""
        handler = self._servant._gecos_handlers[code]
        given = [self._types.built(s, v) for s, v in zip(slots, values, strict=True)]
        result: Any = given[0] if len(given) == 1 else None
        text = ""
        if len(given) > 1:
            method, _ = self._asked(code, inputs, arguments)
            kind = method.result.__self__  # type: ignore[attr-defined]
            result = kind(*given)
            text = f"{result!r}\n{result}"
        return judged(lambda: b"".join(handler.result(result))), text

    def published(self, member: str, slot: Slot, value: Any) -> Verdict:
        """A value given to the servant as a sample of a stream, or as an event."""
        name = names.publisher(member)
        caught: list[bytes] = []

        class Probe(self._servant):  # type: ignore[misc, name-defined]
            def _gecos_publish(self, code: int, out: wire.Parts, stamp: float | None) -> None:
                caught.append(b"".join(out))

        Probe.__abstractmethods__ = frozenset()
        probe = Probe()

        def work() -> bytes:
            getattr(probe, name)(self._types.built(slot, value))
            return caught[0]

        return judged(work)


def _name_of(kind: type) -> str:
    return str(getattr(kind, "_gecos_interface", None) and kind._gecos_interface.name)  # type: ignore[attr-defined]
