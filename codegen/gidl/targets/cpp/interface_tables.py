"""Builds the tables that sessions read: operations, streams and quality."""

from __future__ import annotations

from gidl.model import (
    Attribute,
    Operation,
)
from gidl.model.bulk import stream_in_place
from gidl.model.policy import (
    Access,
    Liveliness,
    OnDegraded,
    OnLoss,
    OnNew,
    Qos,
    QualityClass,
    Reliability,
)
from gidl.targets.calls import (
    short_name,
)
from gidl.targets.cpp.call_facts import CallFacts, hex32, hex64
from gidl.targets.cpp.interface_views import InwardRow, OperationRow, StreamRow
from gidl.targets.groups import WIDTH
from gidl.wire.wire_layout import CallKind, CallLayout


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
        is_getter = (kind, status, presence, idempotent) == ("Getter", "SENSOR", False, True)
        terms = []
        if not is_getter:
            if kind != "Operation":
                terms.append(f".kind = gecos::OperationKind::{kind}")
            if status != "ACTOR":
                terms.append(f".status = gecos::access::Status::{status.capitalize()}")
        flags = {
            "safety": safety,
            "presence": presence or is_getter,
            "idempotent": idempotent and not is_getter,
            "cancelable": cancelable,
            "parallel": member.parallel,
            "ordered": ordered,
        }
        for name, value in flags.items():
            if value is (name != "presence"):
                terms.append(f".{name} = {'true' if value else 'false'}")
        if member.on_new is not OnNew.QUEUE:
            terms.append(f".on_new = gecos::OnNew::{member.on_new.value.capitalize()}")
        if member.on_loss is OnLoss.FINISH:
            terms.append(".on_loss = gecos::OnLoss::Finish")
        return OperationRow(
            self._constants[call.name], hex32(call.code), short_name(call), hex64(call.hash),
            is_getter, filled([*terms, *asked(member.qos_of_calls)]),
        )  # fmt: skip

    def _stream_row(self, attribute: Attribute) -> StreamRow:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        terms = []
        if attribute.read_access is not Access.SENSOR:
            status = attribute.read_access.name.capitalize()
            terms.append(f".status = gecos::access::Status::{status}")
        if attribute.stream.rate_hz:
            terms.append(f".rate_hz = {float(attribute.stream.rate_hz)!r}")
        if layout.largest:
            terms.append(f".largest = {layout.largest}")
        if stream_in_place(self._model, attribute):
            terms.append(".bulk = true")
        if attribute.event is not None:
            terms += [".event = true", f".hash = {hex64(layout.hash)}"]
        if attribute.stream.is_open and layout.fingerprint is not None:
            terms.append(f".open_fingerprint = {hex64(layout.fingerprint)}")
        return StreamRow(
            self._stream_constants[attribute.name], hex32(layout.code), attribute.name,
            filled([*terms, *asked(attribute.qos)]),
        )  # fmt: skip

    def _inward_row(self, attribute: Attribute) -> InwardRow:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        terms = []
        if attribute.write_access is not Access.ACTOR:
            status = attribute.write_access.name.capitalize()
            terms.append(f".status = gecos::access::Status::{status}")
        if not attribute.write_needs_presence:
            terms.append(".presence = false")
        if attribute.stream.rate_hz:
            terms.append(f".rate_hz = {float(attribute.stream.rate_hz)!r}")
        if attribute.stream.watchdog_ns:
            terms.append(f".watchdog = gecos::Duration{{{attribute.stream.watchdog_ns}}}")
        if layout.largest:
            terms.append(f".largest = {layout.largest}")
        return InwardRow(
            self._stream_constants[attribute.name], hex32(layout.code), attribute.name,
            hex64(layout.hash), filled([*terms, *asked(attribute.qos)]),
        )  # fmt: skip


def asked(qos: Qos) -> list[str]:
    """Returns the initialiser of the member `.quality`. The list is empty if `qos` demands
    nothing."""
    terms = quality(qos.of_member)
    if terms:
        terms[0] = f".quality = {{{terms[0]}"
        terms[-1] += "}"
    return terms


def quality(qos: Qos) -> list[str]:
    """Returns designated initialisers for the members of gecos::qos::Quality that `qos` sets."""
    terms = []
    if qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        word = "SoftRealtime" if qos.quality_class is QualityClass.SOFT_REALTIME else "HardRealtime"
        terms.append(f".line = gecos::qos::Class::{word}")
    if qos.reliability is not None:
        word = "Reliable" if qos.reliability is Reliability.RELIABLE else "BestEffort"
        terms.append(f".reliability = gecos::qos::Reliability::{word}")
    for name in ("deadline", "start_by", "latency", "lifespan"):
        value = getattr(qos, f"{name}_ns")
        if value is not None:
            terms.append(f".{name} = gecos::Duration{{{value}}}")
    if qos.liveliness is Liveliness.MANUAL:
        terms.append(".liveliness = gecos::qos::Liveliness::Manual")
    if qos.depth is not None:
        terms.append(f".depth = {qos.depth}")
    if qos.media is not None:
        named = " | ".join(f"gecos::qos::Media::{medium.capitalize()}" for medium in qos.media)
        terms.append(f".media = {named}")
    if qos.on_degraded not in (None, OnDegraded.EVENT):
        terms.append(f".on_degraded = gecos::qos::OnDegraded::{qos.on_degraded.value.capitalize()}")
    return terms


def filled(terms: list[str]) -> tuple[str, ...]:
    """Returns `terms` joined by commas, in lines that contain as many terms as fit."""
    lines: list[str] = []
    for term in terms:
        if lines and len(lines[-1]) + len(term) < WIDTH - 12:
            lines[-1] += f", {term}"
        else:
            lines.append(term)
    return tuple(lines)
