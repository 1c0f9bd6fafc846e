"""The tables that sessions read: operations, streams, quality."""

from __future__ import annotations

from gidl.model import (
    Attribute,
    Operation,
)
from gidl.policy import OnLoss, OnNew, Qos, QualityClass, Reliability
from gidl.targets.calls import (
    short_name,
)
from gidl.targets.cpp.calls.facts import CallFacts, hex32, hex64
from gidl.targets.cpp.calls.views import (
    OperationRow,
    StreamRow,
)
from gidl.targets.groups import group
from gidl.wire_layout import CallKind, CallLayout


class Tables(CallFacts):
    def _row(self, call: CallLayout) -> OperationRow:
        member = self._member(call)
        if isinstance(member, Operation):
            status, presence = member.access.name, member.needs_presence
            safety, cancelable, ordered = member.safety, member.cancelable, member.ordered
            idempotent = member.idempotent
            kind = "Operation"
        else:
            setter = call.kind is CallKind.SETTER
            status = (member.write_access if setter else member.read_access).name
            presence = setter and member.write_needs_presence
            safety = cancelable = ordered = False
            idempotent = member.idempotent or not setter
            kind = "Setter" if setter else "Getter"
        return OperationRow(
            hex32(call.code), short_name(call), kind, status.capitalize(),
            _bool(safety), _bool(presence), _bool(idempotent), _bool(cancelable),
            _bool(member.parallel), _bool(ordered), _on_new(member.on_new),
            "Finish" if member.on_loss is OnLoss.FINISH else "Stop",
            quality(member.qos), hex64(call.hash),
        )  # fmt: skip

    def _stream_row(self, attribute: Attribute) -> StreamRow:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        return StreamRow(
            hex32(layout.code),
            attribute.name,
            attribute.read_access.name.capitalize(),
            repr(float(attribute.stream.rate_hz or 0)),
            str(layout.sample.fixed_size or 0),
            quality(attribute.qos),
        )


def quality(qos: Qos) -> str:
    """Designated initialisers of gecos::qos::Quality; only what was asked for."""
    terms = []
    if qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        word = "SoftRealtime" if qos.quality_class is QualityClass.SOFT_REALTIME else "HardRealtime"
        terms.append(f".line = gecos::qos::Class::{word}")
    if qos.reliability is Reliability.BEST_EFFORT:
        terms.append(".reliability = gecos::qos::Reliability::BestEffort")
    for name in ("deadline", "start_by", "latency", "lifespan"):
        value = getattr(qos, f"{name}_ns")
        if value is not None:
            terms.append(f".{name} = gecos::Duration{{{value}}}")
    if qos.depth is not None:
        terms.append(f".depth = {qos.depth}")
    if qos.media is not None:
        named = " | ".join(f"gecos::qos::Media::{medium.capitalize()}" for medium in qos.media)
        terms.append(f".media = {named}")
    return group(terms, "{", "}")


def _on_new(value: OnNew) -> str:
    return value.value.capitalize()


def _bool(value: bool) -> str:
    return "true" if value else "false"
