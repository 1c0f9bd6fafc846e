"""The two languages and the gate's own opinion, on the same values and the same bytes."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from random import Random
from typing import Any

from compare_json import changed
from compare_verdicts import mutated
from cpp_side import Asked, Program
from gidl.model import Attribute, Interface, Model, NamedType, Operation
from gidl.wire.wire_layout import Layout
from making import TOKEN, Making
from neutral import Slot, has_nan, raw
from opinion import WRONG_ARM, WRONG_BITS, Opinion
from python_side import Calls, Types, Values, Verdict


@dataclass(frozen=True)
class CallSlots:
    code: int
    inputs: list[Slot]
    outputs: list[Slot]


class Comparison:
    def __init__(self, model: Model, layout: Layout, program: Program, dice: Random) -> None:
        self._model = model
        self._layout = layout
        self._program = program
        self._dice = dice
        self._making = Making(model, dice)
        self._opinion = Opinion(model)
        self._types = Types(model, layout)
        self._checks: list[tuple[Asked, Any]] = []
        self.differences: list[str] = []
        self.accepted = self.refused = 0

    def prepare(self, values: int) -> list[Asked]:
        """All questions to the program; `judge` looks at the answers."""
        for what, name in list(self._program.numbers):
            if what == "type":
                for index in range(values):
                    self._type(name, index % 5 >= 3)
        for interface in self._model.interfaces():
            if any(name.startswith(f"{interface.name} ") for _, name in self._program.numbers):
                self._interface(interface, values)
        return [asked for asked, _ in self._checks]

    def judge(self) -> None:
        for asked, check in self._checks:
            if asked.answers is not None:
                check(*asked.answers)

    def _ask(self, what: str, name: str, first: bytes, second: bytes, check: Any) -> None:
        self._checks.append((Asked(what, name, first, second), check))

    def _differ(self, what: str, *told: str) -> None:
        self.differences.append(f"{what}\n  " + "\n  ".join(told))

    def _same(
        self, what: str, value: Any, wrong: str, told: dict[str, Verdict], expected: bytes | None
    ) -> None:
        """`told` and the gate's own verdict agree: refused by all, or accepted as `expected`."""
        self.accepted += not wrong
        self.refused += bool(wrong)
        if wrong.startswith(WRONG_ARM) and not told["Python"].why.startswith("FAULT"):
            told.pop("Python")  # its unions hold no arm; the value may do for the other one
        for verdict in told.values():
            if verdict.fine != (not wrong) or verdict.why.startswith("FAULT"):
                break
            if not wrong and expected is not None and verdict.bytes != expected:
                break
        else:
            return
        self._differ(
            f"{what}: {value!r}",
            f"should be refused: {wrong}" if wrong else "should be accepted",
            "" if expected is None else expected.hex(),
            *(f"{who}: {shown(verdict)}" for who, verdict in told.items()),
        )

    # -- types ---------------------------------------------------------------------------------

    def _type(self, name: str, spoiled: bool) -> None:
        slot = Slot(NamedType(name))
        value = self._making.values([slot], spoiled)[0]
        wrong = self._opinion.wrong(slot, value)
        neutral = raw(self._model, slot, value)
        data = self._opinion.contents(name, value)
        ours = self._types.sent(name, value)

        def sent(theirs: Verdict, printed: Verdict) -> None:
            told = {"Python": ours, "C++": theirs}
            self._same(f"sending {name}", value, wrong, told, data)
            texts = {
                "Python's text": self._types.printed(name, value),
                "C++'s text": printed.bytes.decode(errors="replace"),
                "Python's refusal": ours.why,
                "C++'s refusal": theirs.why,
            }
            if wrong.startswith(WRONG_ARM) and ours.fine:
                texts.pop("Python's text")  # the value does for the plain arm that the tag selects
            self._no_secret(name, texts)

        self._ask("type", name, neutral, b"", sent)
        if wrong.startswith(WRONG_BITS):
            return  # what does not fit in a bitset cannot be received
        self._bytes(name, data, wrong, value, neutral if not has_nan(value) else None)
        for _ in range(2):
            self._hostile(name, mutated(data, self._dice.randbytes(16), self._dice))
        if not wrong and self._dice.random() < 0.5:
            self._json(name, value, neutral, data)

    def _bytes(self, name: str, data: bytes, wrong: str, value: Any, neutral: bytes | None) -> None:
        ours = self._types.received(name, data)

        def received(theirs: Verdict, again: Verdict) -> None:
            self._same(f"receiving {name}", value, wrong, {"Python": ours, "C++": theirs}, neutral)
            if theirs.fine and again.bytes != data:
                self._differ(
                    f"C++ receives {name} and sends it otherwise", data.hex(), shown(again)
                )

        self._ask("bytes", name, data, b"", received)

    def _hostile(self, name: str, data: bytes) -> None:
        ours = self._types.received(name, data)

        def received(theirs: Verdict, again: Verdict) -> None:
            same = ours.fine == theirs.fine and not ours.why.startswith("FAULT")
            if same and ours.fine and ours.bytes != theirs.bytes:
                same = ours.why == "NaN"
            if not same:
                self._differ(
                    f"mutated bytes of {name}: {data.hex()}",
                    f"Python: {shown(ours)}",
                    f"C++: {shown(theirs)}",
                )

        self._ask("bytes", name, data, b"", received)

    def _json(self, name: str, value: Any, neutral: bytes, data: bytes) -> None:
        ours = self._types.to_json(name, data)

        def written(theirs: Verdict, _: Verdict) -> None:
            if not ours.fine or json.loads(ours.bytes) != json.loads(theirs.bytes):
                self._differ(
                    f"JSON of {name}: {value!r}", f"Python: {shown(ours)}", f"C++: {shown(theirs)}"
                )
            self._no_secret(
                name, {"Python's JSON": ours.bytes.decode(), "C++'s JSON": theirs.bytes.decode()}
            )

        self._ask("json", name, neutral, b"", written)
        if b"***" in ours.bytes or not ours.fine:
            return
        back = self._types.from_json(name, ours.bytes)

        def read(theirs: Verdict, _: Verdict) -> None:
            if not (back.fine and theirs.fine and back.bytes == theirs.bytes == data):
                self._differ(
                    f"JSON of {name} read back: {ours.bytes.decode()}",
                    data.hex(),
                    f"Python: {shown(back)}",
                    f"C++: {shown(theirs)}",
                )

        self._ask("from json", name, ours.bytes, b"", read)

    def _no_secret(self, name: str, texts: dict[str, str]) -> None:
        for what, text in texts.items():
            if TOKEN.decode() in text:
                self._differ(f"{what} of {name} shows a secret", text[:3000])

    # -- calls ---------------------------------------------------------------------------------

    def _interface(self, interface: Interface, values: int) -> None:
        calls = Calls(self._model, self._types, interface)
        for call in self._calls(interface):
            for index in range(values):
                self._call(interface, calls, call, index % 5 >= 3, index % 2 == 0)
        for member in self._model.all_interface_members(interface):
            if isinstance(member, Attribute) and member.streams_out:
                for index in range(values):
                    self._publish(interface, calls, member, index % 5 >= 3)

    def _calls(self, interface: Interface) -> list[CallSlots]:
        found = []
        for member in self._model.all_interface_members(interface):
            if isinstance(member, Operation):
                inputs = [Slot(p.type, p.range, p.optional, p.secret) for p in member.inputs]
                outputs = [Slot(p.type, p.range, p.optional, p.secret) for p in member.outputs]
                if member.result is not None:
                    result = Slot(
                        member.result,
                        member.result_range,
                        member.result_optional,
                        member.result_secret,
                    )
                    outputs.insert(0, result)
                found.append(CallSlots(self._layout.call(member.scoped_name).code, inputs, outputs))
                continue
            value = Slot(member.type, member.range, member.optional, member.secret)
            if member.has_getter:
                code = self._layout.call(member.scoped_name).code
                found.append(CallSlots(code, [], [value]))
            if member.has_setter:
                code = self._layout.call(f"{member.scoped_name}=").code
                found.append(CallSlots(code, [value], []))
        return found

    def _publish(
        self, interface: Interface, calls: Calls, member: Attribute, spoiled: bool
    ) -> None:
        """Publishes a sample of a stream, or an event."""
        slot = Slot(member.type, member.range, member.optional, member.secret)
        values = self._making.values([slot], spoiled)
        wrong = self._opinion.any_wrong([slot], values)
        sample = self._opinion.fields([slot], values)
        code = self._layout.stream(member.scoped_name).code
        ours = calls.published(member.name, slot, values[0])

        def publish(theirs: Verdict, _: Verdict) -> None:
            what = f"publishing {interface.name} {member.name}"
            self._same(what, values, wrong, {"Python": ours, "C++": theirs}, sample)

        given = raw(self._model, slot, values[0])
        self._ask("publish", f"{interface.name} {code}", given, b"", publish)

    def _call(
        self, interface: Interface, calls: Calls, call: CallSlots, spoiled: bool, of_request: bool
    ) -> None:
        key, name = f"{interface.name} {call.code}", f"{interface.name} {call.code:#x}"
        inputs = self._making.values(call.inputs, spoiled and of_request)
        outputs = self._making.values(call.outputs, spoiled and not of_request)
        wrong_in = self._opinion.any_wrong(call.inputs, inputs)
        wrong_out = self._opinion.any_wrong(call.outputs, outputs)
        raw_in = b"".join(raw(self._model, s, v) for s, v in zip(call.inputs, inputs, strict=True))
        raw_out = b"".join(
            raw(self._model, s, v) for s, v in zip(call.outputs, outputs, strict=True)
        )
        request = self._opinion.fields(call.inputs, inputs)
        reply = self._opinion.fields(call.outputs, outputs)
        asked = calls.asked(call.code, call.inputs, inputs)

        def ask(sent: Verdict, heard: Verdict) -> None:
            self._same(f"calling {name}", inputs, wrong_in, {"Python": asked, "C++": sent}, request)
            self._no_secret(name, {"Python's refusal": asked.why, "C++'s refusal": sent.why})
            if wrong_in or wrong_out.startswith(WRONG_BITS):
                return
            ours = calls.heard_reply(call.code, call.inputs, inputs, call.outputs, reply)
            expected = None if has_nan(outputs) else raw_out
            self._same(
                f"a reply of {name}", outputs, wrong_out, {"Python": ours, "C++": heard}, expected
            )

        self._ask("ask", key, raw_in, reply, ask)
        if (wrong_in + wrong_out).startswith((WRONG_BITS, WRONG_ARM)):
            return
        received = calls.heard_request(call.code, call.inputs, request)

        def serve(heard: Verdict, answered: Verdict) -> None:
            expected = None if has_nan(inputs) else raw_in
            self._same(
                f"a request of {name}",
                inputs,
                wrong_in,
                {"Python": received, "C++": heard},
                expected,
            )
            if wrong_in:
                return
            ours, text = calls.answered(call.code, call.inputs, inputs, call.outputs, outputs)
            self._same(
                f"answering {name}", outputs, wrong_out, {"Python": ours, "C++": answered}, reply
            )
            self._no_secret(
                name,
                {
                    "text of results": text,
                    "Python's refusal": ours.why,
                    "C++'s refusal": answered.why,
                },
            )

        self._ask("serve", key, request, raw_out, serve)
        if not wrong_in and call.code not in calls.methods:
            calls.find_method(call.code, call.inputs, inputs)
        if method := calls.methods.get(call.code):
            self._values(calls, key, Values(method, request, True), wrong_in)
            self._values(calls, key, Values(method, reply, False), wrong_out)
        if ("results", key) in self._program.numbers:

            def results(theirs: Verdict, printed: Verdict) -> None:
                text = printed.bytes.decode(errors="replace")
                self._no_secret(name, {"C++'s text of results": text, "C++'s refusal": theirs.why})

            self._ask("results", key, raw_out, b"", results)

    def _values(self, calls: Calls, key: str, of: Values, wrong: str) -> None:
        """Arguments or results as a struct: bytes and JSON both ways, also of JSON that is
        changed at random."""
        what = "arguments" if of.are_arguments else "result"
        if (what, key) not in self._program.numbers:
            return
        ours, our_json = calls.values(of)

        def again(theirs: Verdict, their_json: Verdict) -> None:
            self._same(
                f"{what} of {key}", of.bytes, wrong, {"Python": ours, "C++": theirs}, of.bytes
            )
            if theirs.fine and not (our_json.fine and _same_json(our_json, their_json)):
                self._differ(
                    f"JSON of the {what} of {key}", shown(our_json), f"C++: {shown(their_json)}"
                )
            texts = {"Python's JSON": our_json, "C++'s JSON": their_json}
            self._no_secret(key, {name: each.bytes.decode() for name, each in texts.items()})

        self._ask(what, key, of.bytes, b"", again)
        if not our_json.fine:
            return
        self._values_from_json(calls, key, of, our_json.bytes)
        data = changed(json.loads(our_json.bytes), self._dice)
        self._values_from_json(calls, key, of, json.dumps(data).encode())

    def _values_from_json(self, calls: Calls, key: str, of: Values, text: bytes) -> None:
        what = "arguments" if of.are_arguments else "result"
        ours = calls.values_from_json(of, text)

        def read(theirs: Verdict, _: Verdict) -> None:
            same_place = _same_place(of, ours.why, theirs.why)
            if (ours.fine, ours.bytes) != (theirs.fine, theirs.bytes) or not same_place:
                self._differ(
                    f"{what} of {key} from JSON: {text.decode()}",
                    f"Python: {shown(ours)}",
                    f"C++: {shown(theirs)}",
                )

        self._ask(f"{what} from json", key, text, b"", read)


def _same_place(of: Values, ours: str, theirs: str) -> bool:
    """Whether both languages refuse the same member. Of a result, Python names the operation alone
    if it has one result, and the struct of its results if it has several; C++ names operation and
    member. Of an array inside an array, Python names the element and C++ the array."""
    ours, theirs = (re.sub(r"\[\d+\]", "", why) for why in (ours, theirs))
    if ours == theirs:
        return True
    if of.are_arguments:
        return False
    name, named = of.method.operation.name, of.method.named
    head, _, member = ours.partition(".")
    if head.endswith("_result"):
        return theirs == f"{theirs.partition('.')[0]}.{member}"
    return theirs.removeprefix(f"{name}.") == named + ours.removeprefix(name)


def shown(verdict: Verdict) -> str:
    if verdict.fine:
        return f"accepted {verdict.bytes.hex()} {verdict.bytes!r}"[:600]
    if verdict.why.startswith("FAULT"):
        return verdict.why[-1500:]
    return f"refused {verdict.why.splitlines()[-1] if verdict.why else ''}"


def _same_json(one: Verdict, other: Verdict) -> bool:
    return bool(json.loads(one.bytes) == json.loads(other.bytes))
