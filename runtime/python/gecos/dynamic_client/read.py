"""Reads the texts that a server serves into a `Model`. The texts come from another program over a
network: whatever is wrong with them becomes a `ModelError`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from gecos.dynamic_client.entries import Entries, Malformed, parse_object
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
from gecos.interface import Access, Media, OnLoss, OnNew, Quality, QualityClass

_EXTENSIBILITY = ("final", "appendable")
_ACCESS = {each.name.lower(): each for each in Access}
_ON_NEW = {each.name.lower(): each for each in OnNew}
_ON_LOSS = {each.name.lower(): each for each in OnLoss}
_QUALITY_CLASS = {each.name: each for each in QualityClass}
_MEDIA = {each.name.lower(): each for each in Media if each.name}
_MAX_CODE = (1 << 32) - 1
_MAX_NS = (1 << 63) - 1
_MAX_BASES = 64  # of an interface or a type, in each other


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
        return model

    def _read(self, text: Entries) -> None:
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
        """Adds the interface to `ordered`, after its bases. `above` are interfaces that derive from
        it."""
        if name in ordered:
            return
        if name in above or len(above) > _MAX_BASES:
            raise Malformed(f"interface {name} inherits from itself, or from too many others")
        if name not in self._interfaces:
            raise Malformed(f"there is no text of interface {name}")
        for base in self._interfaces[name].bases:
            self._order(base, ordered, [*above, name])
        ordered[name] = self._interfaces[name]


# -- types -----------------------------------------------------------------------------------------


def _declaration(entries: Entries) -> Declaration:
    entries.place = f"type {entries.scoped()}"
    return _DECLARATIONS[entries.one_of("kind", _DECLARATIONS)](entries)


def _struct(entries: Entries) -> Struct:
    members = entries.list_of("members", _value)
    entries.distinct("members", [each.name for each in members])
    return Struct(
        entries.scoped(),
        members,
        entries.scoped_or_none("base"),
        entries.one_of("extensibility", _EXTENSIBILITY, "final") == "appendable",
        _fingerprint(entries),
        entries.text("kind") == "exception",
        _doc(entries),
    )


def _enumeration(entries: Entries) -> Enumeration:
    bits = entries.whole("bit_bound", 1, 64, 32)
    most = (1 << (63 if bits > 32 else 31)) - 1
    found = entries.list_of(
        "enumerators", lambda each: (each.name(), each.whole("value", -most - 1, most))
    )
    names = entries.distinct("enumerators", [name for name, _ in found])
    if not found or len({number for _, number in found}) != len(found):
        raise Malformed(f"{entries.place} has no enumerators, or two with the same number")
    otherwise = entries.one_of("default_literal", names) if entries.has("default_literal") else None
    return Enumeration(entries.scoped(), found, otherwise, bits, _doc(entries))


def _bitmask(entries: Entries) -> Bitmask:
    bits = entries.whole("bit_bound", 1, 64)
    flags = entries.list_of(
        "flags", lambda each: (each.name(), each.whole("position", 0, bits - 1))
    )
    entries.distinct("flags", [name for name, _ in flags])
    if not flags or len({position for _, position in flags}) != len(flags):
        raise Malformed(f"{entries.place} has no flags, or two at the same position")
    return Bitmask(entries.scoped(), flags, bits, _doc(entries))


def _bitset(entries: Entries) -> Bitset:
    bits = entries.whole("bit_size", 1, 64)

    def field(each: Entries) -> tuple[str, int, int, str]:
        name = each.name() if each.has("name") else ""  # without a name: unused bits
        position = each.whole("position", 0, bits - 1)
        kind = each.one_of("type", _WHOLE | {"boolean"})
        return name, position, each.whole("width", 1, bits - position), kind

    fields = entries.list_of("fields", field)
    base = entries.scoped_or_none("base")
    return Bitset(entries.scoped(), fields, base, bits, _doc(entries))


_WHOLE = CODES.keys() - {"boolean", "char", "float", "double"}


def _union(entries: Entries) -> Union:
    cases = entries.list_of("cases", _case)
    entries.distinct("cases", [case.member.name for case in cases])
    labels = [repr(label) for case in cases for label in case.labels]
    if len(set(labels)) != len(labels) or sum(not case.labels for case in cases) > 1:
        raise Malformed(f"a value of the discriminator selects two members of {entries.place}")
    return Union(
        entries.scoped(),
        _type(entries, "discriminator"),
        cases,
        entries.one_of("extensibility", _EXTENSIBILITY, "final") == "appendable",
        _fingerprint(entries),
        _doc(entries),
    )


def _case(entries: Entries) -> Case:
    member = entries.inner("member")
    if member is None:
        raise Malformed(f"{entries.place} has no 'member'")
    labels = entries.raw("labels") or []
    if type(labels) is not list or any(type(each) not in (bool, int, str) for each in labels):
        raise Malformed(f"'labels' of {entries.place} is not a list of values")
    is_default = entries.flag("default")
    if not (labels or is_default):
        raise Malformed(f"{entries.place} has no label")
    return Case(() if is_default else tuple(labels), _value(member))


def _typedef(entries: Entries) -> Typedef:
    return Typedef(
        entries.scoped(), _type(entries, "type"), _limits(entries, "range"), _doc(entries)
    )


_DECLARATIONS: dict[str, Callable[[Entries], Declaration]] = {
    "struct": _struct,
    "exception": _struct,
    "enum": _enumeration,
    "bitmask": _bitmask,
    "bitset": _bitset,
    "union": _union,
    "typedef": _typedef,
}


# -- values ----------------------------------------------------------------------------------------


def _value(entries: Entries) -> Value:
    """A member of a type, or a parameter."""
    return Value(
        name=entries.name(),
        type=entries.text("type"),
        use=_type(entries, "type"),
        direction=entries.one_of("direction", ("in", "out", "inout"), "in"),
        unit=entries.text("unit", ""),
        limits=_limits(entries, "range"),
        default=_literal(entries, "default"),
        optional=entries.flag("optional"),
        secret=entries.flag("secret"),
        doc=_doc(entries),
    )


def _result(entries: Entries, name: str, key: str, prefix: str) -> Value:
    """The result of an operation, or the value of an attribute."""
    return Value(
        name=name,
        type=entries.text(key),
        use=_type(entries, key),
        direction="out",
        unit=entries.text(f"{prefix}unit", ""),
        limits=_limits(entries, f"{prefix}range"),
        optional=entries.flag(f"{prefix}optional"),
        secret=entries.flag(f"{prefix}secret"),
    )


def _type(entries: Entries, key: str) -> Type:
    try:
        return parse_type(entries.text(key))
    except Malformed:
        raise
    except ValueError as error:
        raise Malformed(f"'{key}' of {entries.place}: {error}") from None


def _limits(entries: Entries, key: str) -> Limits | None:
    found = entries.inner(key)
    return None if found is None else Limits(found.number("min"), found.number("max"))


def _literal(entries: Entries, key: str) -> Any:
    value = entries.raw(key)
    if value is not None and type(value) not in (bool, int, float, str):
        raise Malformed(f"'{key}' of {entries.place} is not a number, boolean or text")
    return value


def _fingerprint(entries: Entries) -> int:
    wire = entries.inner("wire")
    if wire is None:
        raise Malformed(f"{entries.place} has no 'wire'")
    return wire.hash("fingerprint")


def _doc(entries: Entries) -> str:
    lines = [entries.text("doc")] if entries.has("doc") else []
    if entries.has("since"):
        lines.append(f"Since {entries.text('since')}.")
    if entries.has("deprecated"):
        why = entries.raw("deprecated")
        lines.append(f"Deprecated: {why}" if isinstance(why, str) and why else "Deprecated.")
    return "\n".join(lines)


# -- interfaces ------------------------------------------------------------------------------------


def _interface(entries: Entries) -> Interface:
    name = entries.scoped()
    entries.place = f"interface {name}"
    members = entries.list_of("members", lambda each: _member(each, name))
    entries.distinct("members", [each.name for each in members])
    return Interface(
        name=name,
        version=entries.text("version", ""),
        doc=_doc(entries),
        bases=entries.scoped_names("bases"),
        members=members,
        quality=_quality(entries),
        hash=entries.hash("hash"),
    )


def _member(entries: Entries, interface: str) -> Member:
    entries.place = f"{interface}::{entries.name()}"
    kind = entries.one_of("kind", ("operation", "event", "attribute"))
    return _attribute(entries, interface) if kind == "attribute" else _operation(entries, interface)


def _operation(entries: Entries, interface: str) -> Operation:
    parameters = entries.list_of("parameters", _value)
    entries.distinct("parameters", [each.name for each in parameters])
    result = None
    if entries.has("result"):
        name, taken = "result", {each.name for each in parameters if each.direction != "in"}
        while name in taken:
            name += "_"
        result = _result(entries, name, "result", "result_")
    return Operation(
        kind=entries.text("kind"),
        name=entries.name(),
        interface=interface,
        doc=_doc(entries),
        parameters=parameters,
        result=result,
        feedback=entries.scoped_or_none("feedback"),
        raises=entries.scoped_names("raises"),
        access=_access(entries, "access", "actor"),
        safety=entries.flag("safety"),
        presence=entries.flag("needs_presence", True),
        idempotent=entries.flag("idempotent"),
        cancelable=entries.flag("cancelable"),
        parallel=entries.flag("parallel"),
        ordered=entries.flag("ordered"),
        on_new=_ON_NEW[entries.one_of("on_new", _ON_NEW, "queue")],
        on_loss=_ON_LOSS[entries.one_of("on_loss", _ON_LOSS, "stop")],
        quality=_quality(entries),
        code=entries.whole("code", 0, _MAX_CODE),
        hash=entries.hash("hash"),
    )


def _attribute(entries: Entries, interface: str) -> Attribute:
    declared = entries.inner("stream")
    stream = None
    if declared is not None:
        stream = AttributeStream(
            declared.one_of("direction", ("out", "in")),
            float(declared.number("rate_hz") or 0.0),
            declared.whole("largest", 0, _MAX_NS, 0),
        )
    readonly = entries.flag("readonly")
    inward = stream is not None and stream.direction == "in"
    codes = entries.inner("codes") or Entries({}, f"'codes' of {entries.place}")
    return Attribute(
        name=entries.name(),
        interface=interface,
        result=_result(entries, "value", "type", ""),
        doc=_doc(entries),
        readonly=readonly,
        stream=stream,
        access=_access(entries, "read_access", "sensor"),
        write_access=_access(entries, "write_access", "actor"),
        write_presence=entries.flag("write_needs_presence", True),
        idempotent=entries.flag("idempotent"),
        parallel=entries.flag("parallel"),
        on_new=_ON_NEW[entries.one_of("on_new", _ON_NEW, "queue")],
        on_loss=_ON_LOSS[entries.one_of("on_loss", _ON_LOSS, "stop")],
        raises=entries.scoped_names("get_raises"),
        set_raises=entries.scoped_names("set_raises"),
        quality=_quality(entries),
        code=0 if inward else codes.whole("get", 0, _MAX_CODE),
        set_code=0 if readonly or inward else codes.whole("set", 0, _MAX_CODE),
        hash=entries.hash("hash"),
    )


def _access(entries: Entries, key: str, otherwise: str) -> Access:
    return _ACCESS[entries.one_of(key, _ACCESS, otherwise)]


def _quality(entries: Entries) -> Quality:
    qos = entries.inner("qos")
    if qos is None:
        return Quality()
    media = Media(0)
    for each in qos.scoped_names("media"):
        if each.lower() not in _MEDIA:
            raise Malformed(f"{qos.place} has an unknown medium {each}")
        media |= _MEDIA[each.lower()]
    return Quality(
        line=_QUALITY_CLASS[qos.one_of("quality_class", _QUALITY_CLASS, "TIME_INDEPENDENT")],
        best_effort=qos.text("reliability", "") == "BEST_EFFORT",
        deadline_ns=qos.whole("deadline_ns", 0, _MAX_NS, 0),
        start_by_ns=qos.whole("start_by_ns", 0, _MAX_NS, 0),
        latency_ns=qos.whole("latency_ns", 0, _MAX_NS, 0),
        lifespan_ns=qos.whole("lifespan_ns", 0, _MAX_NS, 0),
        depth=qos.whole("depth", 0, _MAX_CODE, 0),
        media=media,
    )


# -- what must hold between declarations -----------------------------------------------------------


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
                    raise Malformed(f"the members of type {each.name} overlap")
                used |= bits


def _check_bases(model: Model, declared: Struct | Bitset) -> None:
    kind, seen, base = type(declared), {declared.name}, declared.base
    while base:
        found = model.types.get(base)
        if not isinstance(found, kind) or base in seen or len(seen) > _MAX_BASES:
            raise Malformed(f"a base of type {declared.name} is missing, or there are too many")
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
        own = [member.code] if member.offered else []
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
