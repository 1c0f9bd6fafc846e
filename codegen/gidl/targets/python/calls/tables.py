"""The constants that say how operations are called and streams are read."""

from __future__ import annotations

from gidl.model import Attribute, Operation
from gidl.policy import OnLoss, OnNew, Qos, QualityClass, Reliability
from gidl.targets.calls import short_name
from gidl.targets.groups import group
from gidl.targets.python.calls.bodies import Bodies
from gidl.targets.python.calls.views import (
    MethodTableView,
    StreamTableView,
)
from gidl.wire_layout import CallKind, CallLayout


class Tables(Bodies):
    def _table(self, call: CallLayout) -> MethodTableView:
        member = self._member(call)
        arguments = [self._reader(call)]
        feedback = self._feedback_hint(call)
        raises = [self._module.value(name) for name, _ in call.exceptions]
        if feedback != "None":
            arguments.append(f"feedback={feedback}.decode")
        if raises:
            listed = group(raises) if raises[1:] else f"({raises[0]},)"
            arguments.append(f"raises={listed}")
        result = self._result_hint(call)
        return MethodTableView(
            self._constant(call),
            f"_Method[{result}, {feedback}]",
            tuple(self._operation_arguments(call, member)),
            tuple(arguments),
        )

    def _operation_arguments(self, call: CallLayout, member: Operation | Attribute) -> list[str]:
        """Only what differs from the defaults of gecos.interface.Operation, and the access."""
        lines = [f"code=0x{call.code:08X}", f'name="{short_name(call)}"']
        setter = call.kind is CallKind.SETTER
        if isinstance(member, Attribute):
            lines.append(f"kind=_Kind.{'SETTER' if setter else 'GETTER'}")
            access = member.write_access if setter else member.read_access
            presence = setter and member.write_needs_presence
            idempotent = member.idempotent or not setter
        else:
            access, presence, idempotent = member.access, member.needs_presence, member.idempotent
        lines.append(f"access=_Access.{access.name}")
        flags = {"presence": presence, "idempotent": idempotent, "parallel": member.parallel}
        if isinstance(member, Operation):
            flags |= {"safety": member.safety, "cancelable": member.cancelable}
            flags |= {"ordered": member.ordered}
        lines += [
            f"{name}={value}" for name, value in flags.items() if value != (name == "presence")
        ]
        if member.on_new is not OnNew.QUEUE:
            lines.append(f"on_new=_OnNew.{member.on_new.name}")
        if member.on_loss is not OnLoss.STOP:
            lines.append(f"on_loss=_OnLoss.{member.on_loss.name}")
        terms = quality(member.qos)
        if terms != "_Quality()":
            lines.append(f"quality={terms}")
        return [*lines, f"hash=0x{call.hash:016X}"]

    def _stream_table(self, attribute: Attribute) -> StreamTableView:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        lines = [f"code=0x{layout.code:08X}", f'name="{attribute.name}"']
        lines.append(f"access=_Access.{attribute.read_access.name}")
        lines.append(f"rate_hz={float(attribute.stream.rate_hz or 0)!r}")
        lines.append(f"largest={layout.sample.fixed_size or 0}")
        terms = quality(attribute.qos)
        if terms != "_Quality()":
            lines.append(f"quality={terms}")
        return StreamTableView(self._stream_constant(attribute), tuple(lines))


def quality(qos: Qos) -> str:
    terms = []
    if qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        assert qos.quality_class is not None
        terms.append(f"line=_QualityClass.{qos.quality_class.name}")
    if qos.reliability is Reliability.BEST_EFFORT:
        terms.append("best_effort=True")
    for name in ("deadline_ns", "start_by_ns", "latency_ns", "lifespan_ns", "depth"):
        value = getattr(qos, name)
        if value is not None:
            terms.append(f"{name}={value}")
    if qos.media is not None:
        terms.append("media=" + " | ".join(f"_Media.{medium.upper()}" for medium in qos.media))
    return f"_Quality{group(terms)}"
