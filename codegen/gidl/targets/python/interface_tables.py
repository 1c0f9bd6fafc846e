"""Builds the constants of a generated module that describe its operations to the runtime."""

from __future__ import annotations

from gidl.model import Attribute, Operation
from gidl.model.bulk import stream_in_place
from gidl.model.policy import Liveliness, OnDegraded, OnLoss, OnNew, Qos, QualityClass
from gidl.targets.calls import first_missing, short_name
from gidl.targets.groups import call, group
from gidl.targets.python.call_facts import CallFacts, Passed
from gidl.targets.python.interface_views import MethodTableView
from gidl.targets.python.type_text import quoted
from gidl.wire.wire_layout import CallKind, CallLayout

_NO_TERMS = "_Quality()"


class Tables(CallFacts):
    def _table(self, layout: CallLayout) -> MethodTableView:
        member = self._member(layout)
        feedback = self._feedback_hint(layout)
        return MethodTableView(
            self._constant(layout),
            self._result_hint(layout),
            feedback,
            self._operation(layout, member),
            tuple(self._carried(layout, member, feedback)),
        )

    def _carried(
        self, layout: CallLayout, member: Operation | Attribute, feedback: str
    ) -> list[str]:
        """Returns the arguments that describe the parameters, results, feedback, exceptions and
        stream of a call. The result has no argument for a part that the call lacks."""
        terms = []
        if inputs := self._inputs(layout):
            terms.append(f"takes={self._values(inputs)}")
        if outputs := self._outputs(layout):
            several = self._gives_several(layout)
            one = outputs[0]
            gives = self._result_hint(layout) if several else self._step(one)
            terms.append(f"gives={gives}")
            if isinstance(member, Operation) and not several and layout.reply[0].name != "result":
                terms.append(f"named={quoted(layout.reply[0].name)}")
        if feedback != "None":
            terms.append(f"feedback={feedback}")
        raises = [self._module.value(name) for name, _ in layout.exceptions]
        if raises:
            listed = group(raises) if raises[1:] else f"({raises[0]},)"
            terms.append(f"raises={listed}")
        getter = layout.kind is CallKind.GETTER
        if getter and isinstance(member, Attribute) and member.streams_out:
            terms.append(f"stream={self._stream(member)}")
            terms += self._openness(member)
            if name := self._in_place(member):
                terms.append(f"in_place={quoted(name)}")
        called = self._method_name(layout)
        short = short_name(layout)
        expected = f"set_{short[:-1]}" if short.endswith("=") else short
        return terms + ([f"handler={quoted(called)}"] if called != expected else [])

    def _values(self, values: list[Passed]) -> str:
        steps = self._lowering.steps((each.node, each.value.secret) for each in values)
        passed = [each.value for each in values]
        defaults = [self._missing(each) for each in values[first_missing(passed) :]]
        listed = group(defaults) if defaults[1:] else f"({defaults[0]},)" if defaults else ""
        terms = [f"defaults={listed}"] if defaults else []
        return call("_values", quoted(" ".join(each.name for each in passed)), *steps, *terms)

    def _step(self, each: Passed) -> str:
        return self._lowering.step(each.node, each.value.secret)

    def _stream(self, attribute: Attribute) -> str:
        """Returns the text of a tuple: the rate of a stream in Hz, and the size of its largest
        sample in bytes. 0 stands for a rate that is not declared, and for a size that is not
        limited."""
        assert attribute.stream is not None
        largest = self._layout.stream(attribute.scoped_name).largest or 0
        return group([repr(float(attribute.stream.rate_hz or 0)), str(largest)])

    def _in_place(self, attribute: Attribute) -> str:
        """Returns the name of the member whose octets are written in place in samples of the
        attribute. Returns "" if the samples have no such member."""
        member = stream_in_place(self._model, attribute)
        return "" if member is None else member.name

    def _openness(self, attribute: Attribute) -> list[str]:
        """Returns the argument with the fingerprint of the samples of an open stream. The list is
        empty for any other stream."""
        assert attribute.stream is not None
        fingerprint = self._layout.stream(attribute.scoped_name).fingerprint
        if not attribute.stream.is_open or fingerprint is None:
            return []
        return [f"open_fingerprint=0x{fingerprint & 0xFFFFFFFFFFFFFFFF:016X}"]

    def _inward_table(self, attribute: Attribute) -> str:
        layout = self._layout.stream(attribute.scoped_name)
        assert attribute.stream is not None
        terms = [f"0x{layout.code:08X}", quoted(attribute.name)]
        terms += [f"_Access.{attribute.write_access.name}"]
        terms += [f"gives={self._step(self._sample(attribute))}"]
        terms += [] if attribute.write_needs_presence else ["presence=False"]
        if attribute.stream.rate_hz:
            terms.append(f"rate_hz={float(attribute.stream.rate_hz)!r}")
        if attribute.stream.watchdog_ns:
            terms.append(f"watchdog_ns={attribute.stream.watchdog_ns}")
        if layout.largest:
            terms.append(f"largest={layout.largest}")
        asked = quality(attribute.qos.of_member)
        terms += [] if asked == _NO_TERMS else [f"quality={asked}"]
        terms.append(f"hash=0x{layout.hash & 0xFFFFFFFFFFFFFFFF:016X}")
        return call("_inward", *terms)

    def _event_table(self, event: Attribute) -> str:
        layout = self._layout.stream(event.scoped_name)
        terms = [f"0x{layout.code:08X}", quoted(event.name), f"_Access.{event.read_access.name}"]
        terms.append(f"gives={self._step(self._sample(event))}")
        if layout.largest:
            terms.append(f"largest={layout.largest}")
        asked = quality(event.qos.of_member)
        terms += [] if asked == _NO_TERMS else [f"quality={asked}"]
        terms.append(f"hash=0x{layout.hash & 0xFFFFFFFFFFFFFFFF:016X}")
        return call("_event", *terms)

    def _operation(self, layout: CallLayout, member: Operation | Attribute) -> str:
        """Returns the text that constructs a gecos.interface.Operation. The text always passes the
        code, name, access and hash. It passes any other argument only if the value is not the
        default."""
        setter = layout.kind is CallKind.SETTER
        getter = isinstance(member, Attribute) and not setter
        flags = {}
        if isinstance(member, Operation):
            access, presence = member.access, member.needs_presence
            flags = {"idempotent": member.idempotent, "safety": member.safety}
            flags |= {"cancelable": member.cancelable, "ordered": member.ordered}
        elif setter:
            access, presence = member.write_access, member.write_needs_presence
            flags = {"idempotent": member.idempotent}
        else:
            # The generated code calls `_getter`, which sets presence=False itself. With True here,
            # no argument for the presence is printed.
            access, presence = member.read_access, True
        terms = [f"0x{layout.code:08X}", quoted(short_name(layout)), f"_Access.{access.name}"]
        terms += ["kind=_Kind.SETTER"] if setter else []
        terms += [] if presence else ["presence=False"]
        flags["parallel"] = member.parallel
        terms += [f"{name}=True" for name, value in flags.items() if value]
        if member.on_new is not OnNew.QUEUE:
            terms.append(f"on_new=_OnNew.{member.on_new.name}")
        if member.on_loss is not OnLoss.STOP:
            terms.append(f"on_loss=_OnLoss.{member.on_loss.name}")
        # The getter of a stream is printed with all quality terms of the stream. The function
        # `method` of gecos/interface.py gives these terms to the stream, and removes from the
        # getter those that do not apply to calls.
        asked = quality((member.qos if getter else member.qos_of_calls).of_member)
        terms += [] if asked == _NO_TERMS else [f"quality={asked}"]
        terms.append(f"hash=0x{layout.hash:016X}")
        return call("_getter" if getter else "_Operation", *terms)


def quality(qos: Qos) -> str:
    terms = []
    if qos.quality_class not in (None, QualityClass.TIME_INDEPENDENT):
        assert qos.quality_class is not None
        terms.append(f"line=_QualityClass.{qos.quality_class.name}")
    if qos.reliability is not None:
        terms.append(f"reliability=_Reliability.{qos.reliability.name}")
    for name in ("deadline_ns", "start_by_ns", "latency_ns", "lifespan_ns", "depth"):
        value = getattr(qos, name)
        if value is not None:
            terms.append(f"{name}={value}")
    if qos.liveliness is Liveliness.MANUAL:
        terms.append("manual_liveliness=True")
    if qos.media is not None:
        terms.append("media=" + " | ".join(f"_Media.{medium.upper()}" for medium in qos.media))
    if qos.on_degraded not in (None, OnDegraded.EVENT):
        terms.append(f"on_degraded=_OnDegraded.{qos.on_degraded.name}")
    return f"_Quality{group(terms)}"
