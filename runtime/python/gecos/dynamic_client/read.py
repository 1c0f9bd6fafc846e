"""Reads the texts that a server serves into a `Model`. The texts come from another program over a
network, so every mistake in them becomes a `ModelError`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from gecos.dynamic_client.free_values import check_free_values
from gecos.dynamic_client.json_object import JsonObject, Malformed, parse_object
from gecos.dynamic_client.model import (
    Attribute,
    AttributeStream,
    Bitmask,
    Bitset,
    Case,
    Declaration,
    Enumeration,
    Interface,
    Limits,
    Member,
    Model,
    ModelError,
    Operation,
    Struct,
    Typedef,
    Union,
    Value,
)
from gecos.dynamic_client.nesting import check_nesting
from gecos.dynamic_client.type_text import CODES, Type, parse_type
from gecos.interface import (
    Access,
    Media,
    OnDegraded,
    OnLoss,
    OnNew,
    Quality,
    QualityClass,
    Reliability,
)

_EXTENSIBILITY = ("final", "appendable")
_ACCESS = {each.name.lower(): each for each in Access}
_ON_NEW = {each.name.lower(): each for each in OnNew}
_ON_LOSS = {each.name.lower(): each for each in OnLoss}
_QUALITY_CLASS = {each.name: each for each in QualityClass}
_MEDIA = {each.name.lower(): each for each in Media if each.name}
_MAX_CODE = (1 << 32) - 1
_MAX_NS = (1 << 63) - 1
_MAX_BASES = 64  # limit for the length of a chain of bases of an interface or a type


def read_model(texts: Sequence[str], name: str) -> Model:
    """Reads the texts of the interface `name` and of all its bases."""
    try:
        return _Reader(texts).model(name)
    except Malformed as error:
        raise ModelError(name, str(error)) from None


class _Reader:
    def __init__(self, texts: Sequence[str]) -> None:
        self._texts = texts
        self._interfaces: dict[str, Interface] = {}
        self._types: dict[str, Declaration] = {}
        self._references: set[str] = set()

    def model(self, name: str) -> Model:
        for i, text in enumerate(self._texts):
            self._read(parse_object(text, f"text {i + 1}"))
        ordered: dict[str, Interface] = {}
        self._order(name, ordered, [])
        model = Model(name, ordered, self._types, frozenset(self._references) | ordered.keys())
        _check_types(model)
        _check_members(model)
        check_nesting(model)
        check_free_values(model)
        return model

    def _read(self, text: JsonObject) -> None:
        declared = text.inner("interface")
        if declared is None:
            raise Malformed(f"{text.place} has no 'interface'")
        interface = _interface(declared)
        if self._interfaces.setdefault(interface.name, interface) != interface:
            raise Malformed(f"interface {interface.name} is declared in two different ways")
        for each in text.list_of("types", _declaration):
            if self._types.setdefault(each.name, each) != each:
                raise Malformed(f"type {each.name} is declared in two different ways")
        self._references.update(text.scoped_names("references"))

    def _order(self, name: str, ordered: dict[str, Interface], above: list[str]) -> None:
        """Adds the interface to `ordered`, after its bases. `above` are the interfaces that derive
        from it."""
        if name in ordered:
            return
        if name in above or len(above) > _MAX_BASES:
            raise Malformed(
                f"interface {name} inherits from itself, or its chain of bases is too long"
            )
        if name not in self._interfaces:
            raise Malformed(f"there is no text of interface {name}")
        for base in self._interfaces[name].bases:
            self._order(base, ordered, [*above, name])
        ordered[name] = self._interfaces[name]


# -- types -----------------------------------------------------------------------------------------


def _declaration(data: JsonObject) -> Declaration:
    data.place = f"type {data.scoped()}"
    return _DECLARATIONS[data.one_of("kind", _DECLARATIONS)](data)


def _struct(data: JsonObject) -> Struct:
    members = data.list_of("members", _value)
    data.distinct("members", [each.name for each in members])
    return Struct(
        data.scoped(),
        members,
        data.scoped_or_none("base"),
        data.one_of("extensibility", _EXTENSIBILITY, "final") == "appendable",
        _fingerprint(data),
        data.text("kind") == "exception",
        _doc(data),
    )


def _enumeration(data: JsonObject) -> Enumeration:
    bits = data.whole("bit_bound", 1, 64, 32)
    most = (1 << (63 if bits > 32 else 31)) - 1
    found = data.list_of(
        "enumerators", lambda each: (each.name(), each.whole("value", -most - 1, most))
    )
    names = data.distinct("enumerators", [name for name, _ in found])
    if not found or len({number for _, number in found}) != len(found):
        raise Malformed(f"{data.place} has no enumerators, or two with the same number")
    otherwise = data.one_of("default_literal", names) if data.has("default_literal") else None
    return Enumeration(data.scoped(), found, otherwise, bits, _doc(data))


def _bitmask(data: JsonObject) -> Bitmask:
    bits = data.whole("bit_bound", 1, 64)
    flags = data.list_of("flags", lambda each: (each.name(), each.whole("position", 0, bits - 1)))
    data.distinct("flags", [name for name, _ in flags])
    if not flags or len({position for _, position in flags}) != len(flags):
        raise Malformed(f"{data.place} has no flags, or two at the same position")
    return Bitmask(data.scoped(), flags, bits, _doc(data))


def _bitset(data: JsonObject) -> Bitset:
    bits = data.whole("bit_size", 1, 64)

    def field(each: JsonObject) -> tuple[str, int, int, str]:
        name = each.name() if each.has("name") else ""  # bits without a name are unused
        position = each.whole("position", 0, bits - 1)
        kind = each.one_of("type", _WHOLE | {"boolean"})
        return name, position, each.whole("width", 1, bits - position), kind

    fields = data.list_of("fields", field)
    base = data.scoped_or_none("base")
    return Bitset(data.scoped(), fields, base, bits, _doc(data))


_WHOLE = CODES.keys() - {"boolean", "char", "float", "double"}


def _union(data: JsonObject) -> Union:
    cases = data.list_of("cases", _case)
    data.distinct("cases", [case.member.name for case in cases])
    labels = [repr(label) for case in cases for label in case.labels]
    if len(set(labels)) != len(labels) or sum(not case.labels for case in cases) > 1:
        raise Malformed(f"a value of the discriminator selects two members of {data.place}")
    return Union(
        data.scoped(),
        _type(data, "discriminator"),
        cases,
        data.one_of("extensibility", _EXTENSIBILITY, "final") == "appendable",
        _fingerprint(data),
        _doc(data),
    )


def _case(data: JsonObject) -> Case:
    member = data.inner("member")
    if member is None:
        raise Malformed(f"{data.place} has no 'member'")
    labels = data.raw("labels") or []
    if type(labels) is not list or any(type(each) not in (bool, int, str) for each in labels):
        raise Malformed(f"'labels' of {data.place} is not a list of values")
    is_default = data.flag("default")
    if not (labels or is_default):
        raise Malformed(f"{data.place} has no label")
    return Case(() if is_default else tuple(labels), _value(member))


def _typedef(data: JsonObject) -> Typedef:
    return Typedef(data.scoped(), _type(data, "type"), _limits(data, "range"), _doc(data))


_DECLARATIONS: dict[str, Callable[[JsonObject], Declaration]] = {
    "struct": _struct,
    "exception": _struct,
    "enum": _enumeration,
    "bitmask": _bitmask,
    "bitset": _bitset,
    "union": _union,
    "typedef": _typedef,
}


# -- values ----------------------------------------------------------------------------------------


def _value(data: JsonObject) -> Value:
    """Reads a member of a type, or a parameter."""
    return Value(
        name=data.name(),
        type=data.text("type"),
        use=_type(data, "type"),
        direction=data.one_of("direction", ("in", "out", "inout"), "in"),
        unit=data.text("unit", ""),
        limits=_limits(data, "range"),
        default=_literal(data, "default"),
        optional=data.flag("optional"),
        secret=data.flag("secret"),
        doc=_doc(data),
    )


def _result(data: JsonObject, name: str, key: str, prefix: str) -> Value:
    """Reads the result of an operation, or the value of an attribute."""
    return Value(
        name=name,
        type=data.text(key),
        use=_type(data, key),
        direction="out",
        unit=data.text(f"{prefix}unit", ""),
        limits=_limits(data, f"{prefix}range"),
        optional=data.flag(f"{prefix}optional"),
        secret=data.flag(f"{prefix}secret"),
    )


def _type(data: JsonObject, key: str) -> Type:
    try:
        return parse_type(data.text(key))
    except Malformed:
        raise
    except ValueError as error:
        raise Malformed(f"'{key}' of {data.place}: {error}") from None


def _limits(data: JsonObject, key: str) -> Limits | None:
    found = data.inner(key)
    return None if found is None else Limits(found.number("min"), found.number("max"))


def _literal(data: JsonObject, key: str) -> Any:
    value = data.raw(key)
    if value is not None and type(value) not in (bool, int, float, str):
        raise Malformed(f"'{key}' of {data.place} is not a number, boolean or text")
    return value


def _fingerprint(data: JsonObject) -> int:
    wire = data.inner("wire")
    if wire is None:
        raise Malformed(f"{data.place} has no 'wire'")
    return wire.hash("fingerprint")


def _doc(data: JsonObject) -> str:
    lines = [data.text("doc")] if data.has("doc") else []
    if data.has("since"):
        lines.append(f"Since {data.text('since')}.")
    if data.has("deprecated"):
        why = data.raw("deprecated")
        lines.append(f"Deprecated: {why}" if isinstance(why, str) and why else "Deprecated.")
    return "\n".join(lines)


# -- interfaces ------------------------------------------------------------------------------------


def _interface(data: JsonObject) -> Interface:
    name = data.scoped()
    data.place = f"interface {name}"
    members = data.list_of("members", lambda each: _member(each, name))
    data.distinct("members", [each.name for each in members])
    return Interface(
        name=name,
        version=data.text("version", ""),
        doc=_doc(data),
        bases=data.scoped_names("bases"),
        members=members,
        quality=_quality(data),
        hash=data.hash("hash"),
    )


def _member(data: JsonObject, interface: str) -> Member:
    data.place = f"{interface}::{data.name()}"
    kind = data.one_of("kind", ("operation", "event", "attribute"))
    if kind == "operation":
        return _operation(data, interface)
    return _attribute(data, interface, event=kind == "event")


def _operation(data: JsonObject, interface: str) -> Operation:
    parameters = data.list_of("parameters", _value)
    data.distinct("parameters", [each.name for each in parameters])
    result = None
    if data.has("result"):
        name, taken = "result", {each.name for each in parameters if each.direction != "in"}
        while name in taken:
            name += "_"
        result = _result(data, name, "result", "result_")
    return Operation(
        name=data.name(),
        interface=interface,
        doc=_doc(data),
        parameters=parameters,
        result=result,
        feedback=data.scoped_or_none("feedback"),
        raises=data.scoped_names("raises"),
        access=_access(data, "access", "actor"),
        safety=data.flag("safety"),
        presence=data.flag("needs_presence", True),
        idempotent=data.flag("idempotent"),
        cancelable=data.flag("cancelable"),
        parallel=data.flag("parallel"),
        ordered=data.flag("ordered"),
        on_new=_ON_NEW[data.one_of("on_new", _ON_NEW, "queue")],
        on_loss=_ON_LOSS[data.one_of("on_loss", _ON_LOSS, "stop")],
        quality=_quality(data),
        code=data.whole("code", 0, _MAX_CODE),
        hash=data.hash("hash"),
    )


def _attribute(data: JsonObject, interface: str, event: bool) -> Attribute:
    declared = data.inner("stream")
    stream = None
    if declared is not None:
        stream = AttributeStream(
            declared.one_of("direction", ("out", "in")),
            float(declared.number("rate_hz") or 0.0),
            declared.whole("largest", 0, _MAX_NS, 0),
            declared.whole("watchdog_ns", 0, _MAX_NS, 0),
            declared.flag("open"),
        )
    readonly = data.flag("readonly")
    inward = stream is not None and stream.direction == "in"
    if event and (stream is None or inward or not readonly):
        raise Malformed(f"event {data.place} is not a stream that the server sends")
    codes = data.inner("codes") or JsonObject({}, f"'codes' of {data.place}")
    return Attribute(
        name=data.name(),
        interface=interface,
        result=_result(data, "value", "type", ""),
        doc=_doc(data),
        readonly=readonly,
        stream=stream,
        event=event,
        access=_access(data, "read_access", "sensor"),
        write_access=_access(data, "write_access", "actor"),
        write_presence=data.flag("write_needs_presence", True),
        idempotent=data.flag("idempotent"),
        parallel=data.flag("parallel"),
        on_new=_ON_NEW[data.one_of("on_new", _ON_NEW, "queue")],
        on_loss=_ON_LOSS[data.one_of("on_loss", _ON_LOSS, "stop")],
        raises=data.scoped_names("get_raises"),
        set_raises=data.scoped_names("set_raises"),
        quality=_quality(data),
        code=codes.whole("stream" if inward or event else "get", 0, _MAX_CODE),
        set_code=0 if readonly or inward else codes.whole("set", 0, _MAX_CODE),
        hash=data.hash("hash"),
    )


def _access(data: JsonObject, key: str, otherwise: str) -> Access:
    return _ACCESS[data.one_of(key, _ACCESS, otherwise)]


def _quality(data: JsonObject) -> Quality:
    qos = data.inner("qos")
    if qos is None:
        return Quality()
    media = Media(0)
    for each in qos.scoped_names("media"):
        if each.lower() not in _MEDIA:
            raise Malformed(f"{qos.place} has an unknown medium {each}")
        media |= _MEDIA[each.lower()]
    return Quality(
        line=_QUALITY_CLASS[qos.one_of("quality_class", _QUALITY_CLASS, "TIME_INDEPENDENT")],
        reliability=Reliability[qos.one_of("reliability", Reliability.__members__, "DEFAULT")],
        deadline_ns=qos.whole("deadline_ns", 0, _MAX_NS, 0),
        start_by_ns=qos.whole("start_by_ns", 0, _MAX_NS, 0),
        latency_ns=qos.whole("latency_ns", 0, _MAX_NS, 0),
        lifespan_ns=qos.whole("lifespan_ns", 0, _MAX_NS, 0),
        manual_liveliness=qos.text("liveliness", "") == "MANUAL",
        depth=qos.whole("depth", 0, _MAX_CODE, 0),
        media=media,
        on_degraded=OnDegraded[qos.one_of("on_degraded", OnDegraded.__members__, "EVENT")],
    )


# -- checks across several declarations ------------------------------------------------------------


def _check_types(model: Model) -> None:
    for each in model.types.values():
        if each.name in model.references:
            raise Malformed(f"{each.name} is both a type and an interface")
        if isinstance(each, Struct | Bitset):
            _check_bases(model, each)
    for each in model.types.values():
        for use in model.direct_uses(each):
            _check_known(model, use.named(), f"type {each.name}")
        if isinstance(each, Struct):
            _check_distinct(f"type {each.name}", (m.name for m in model.all_members(each)))
        elif isinstance(each, Bitset):
            fields = model.all_fields(each)
            _check_distinct(f"type {each.name}", (name for name, *_ in fields if name))
            used = 0
            for _, position, width, _ in fields:
                bits = ((1 << width) - 1) << position
                if used & bits or position + width > each.bits:
                    raise Malformed(f"the bits of two members of type {each.name} overlap")
                used |= bits


def _check_bases(model: Model, declared: Struct | Bitset) -> None:
    kind, seen, base = type(declared), {declared.name}, declared.base
    while base:
        found = model.types.get(base)
        if not isinstance(found, kind) or base in seen or len(seen) > _MAX_BASES:
            raise Malformed(
                f"a base of type {declared.name} is missing, or the chain of its bases is too long"
            )
        seen.add(base)
        base = found.base


def _check_members(model: Model) -> None:
    codes: dict[int, str] = {}
    for member in model.members:
        place = f"{member.interface}::{member.name}"
        values = [*member.parameters, *([] if member.result is None else [member.result])]
        for value in values:
            _check_known(model, value.use.named(), place)
        raises = member.raises
        own = [member.code]
        if isinstance(member, Attribute):
            raises += member.set_raises
            own += [member.set_code] if member.can_be_set else []
        for name in raises:
            found = model.types.get(name)
            if not (isinstance(found, Struct) and found.is_exception):
                raise Malformed(f"{place} raises {name}, which is not a declared exception")
        for code in own:
            if code in codes:
                raise Malformed(f"{place} and {codes[code]} have the same function code")
            codes[code] = place


def _check_known(model: Model, names: Iterable[str], place: str) -> None:
    for name in sorted(names):
        found = model.types.get(name)
        if found is None and name not in model.references:
            raise Malformed(f"{place} uses the type {name}, which is not declared")
        if isinstance(found, Struct) and found.is_exception:
            raise Malformed(f"{place} uses the exception {name} as a value")


def _check_distinct(place: str, names: Iterable[str]) -> None:
    seen = set()
    for name in names:
        if name in seen:
            raise Malformed(f"{place} has two members {name}")
        seen.add(name)
