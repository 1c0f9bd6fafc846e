"""Proxies made at run time send and receive the same bytes as generated proxies."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from inspect import signature
from random import Random
from typing import Any

import pytest
from gecos.dynamic_client import DynamicObject, proxy_class
from gecos.dynamic_client.model import Operation
from gecos.dynamic_client.read import read_model
from gecos.dynamic_client.types import Types
from gecos.interface import Method
from gecos.wire import DecodeError, DecodeProblem, Decoder, EncodeError, JsonError
from gecos.wire.kinds import kind_of
from served_models import (
    FILES,
    TREE,
    CallKind,
    CallLayout,
    Plain,
    Slot,
    Unsayable,
    generate,
    inputs,
    load,
    names,
    outputs,
    python_module,
    served,
    shown,
)

MODEL, LAYOUT = load()
OFFERED = sorted(i.name for i in MODEL.interfaces() if not i.name.startswith("gecos::"))


@pytest.fixture(scope="module", autouse=True)
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The generated Python of all interfaces that are not in the tree."""
    out = tmp_path_factory.mktemp("dynamic")
    generate(out, *(each for each in FILES if TREE / "idl" not in each.parents))
    sys.path.insert(0, str(out / "python"))
    yield
    sys.path.remove(str(out / "python"))


@pytest.fixture(params=OFFERED)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


class Sent(Exception):
    """A call that was issued: its method table and the bytes of its request."""

    def __init__(self, method: Method[Any, Any], request: bytes) -> None:
        self.method, self.request = method, request


def generated_class(name: str) -> Any:
    module = import_module(python_module(MODEL.file_of(name)))
    return getattr(module, LAYOUT.python_names.types[name].name)


def dynamic_class(name: str) -> type[DynamicObject]:
    return proxy_class(served(MODEL, LAYOUT, name), name)


def sender(kind: Any) -> Any:
    """A proxy that raises `Sent` instead of calling."""

    class Sender(kind):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(None)

        def _gecos_call(self, method: Method[Any, Any], arguments: Any) -> None:
            raise Sent(method, b"".join(arguments))

    return Sender()


def sent(proxy: Any, method: str, *given: Any, **named: Any) -> Sent:
    with pytest.raises(Sent) as caught:
        getattr(proxy, method)(*given, **named)
    return caught.value


def calls(name: str) -> list[CallLayout]:
    return list(LAYOUT.all_calls(MODEL, MODEL.interface(name)))


def tables(name: str) -> dict[int, Method[Any, Any]]:
    """The method tables in the modules of a generated proxy and of its bases, by function code."""
    modules = [vars(sys.modules[each.__module__]) for each in generated_class(name).__mro__[:-2]]
    found = (each for module in modules for each in module.values() if isinstance(each, Method))
    return {each.operation.code: each for each in found}


def entry_name(call: CallLayout) -> str:
    """The name of the proxy's method for a call."""
    short = call_name(call)
    return names.setter(short) if call.kind is CallKind.SETTER else names.method_name(short)


def call_name(call: CallLayout) -> str:
    return call.name.removesuffix("=").rpartition("::")[2]


def test_the_interface_is_the_generated_one(name: str) -> None:
    assert dynamic_class(name)._gecos_interface == generated_class(name)._gecos_interface


def test_the_members_are_spelled_as_in_generated_code(name: str) -> None:
    dynamic, generated = dynamic_class(name), generated_class(name)
    members = {each for kind in generated.__mro__[:-2] for each in vars(kind)}
    members = {each for each in members if not each.startswith("_")}
    assert {each for each in vars(dynamic) if not each.startswith("_")} == members
    for each in members:
        entry = getattr(generated, each)
        assert isinstance(entry, property) == isinstance(getattr(dynamic, each), property)
        if not isinstance(entry, property):
            here, there = signature(getattr(dynamic, each)), signature(entry)
            assert list(here.parameters) == list(there.parameters)
            for p, q in zip(here.parameters.values(), there.parameters.values(), strict=True):
                assert (p.default is p.empty) == (q.default is q.empty), (each, p)


def test_requests_are_equal_bytes(name: str) -> None:
    proxy, known = sender(dynamic_class(name)), tables(name)
    plain = Plain(MODEL, 7)
    for call in calls(name):
        keys, slots = split(inputs(MODEL, call))
        for spoiled in [False] * 6 + [True] * 10:
            with suppress(Unsayable):
                values = plain.values(slots, spoiled)
                data = dict(zip(keys, values, strict=True))
                expected = generated_request(known[call.code], data)
                if expected is None:
                    with pytest.raises(EncodeError, match=f"^{call_name(call)}\\."):
                        getattr(proxy, entry_name(call))(**data)
                else:
                    assert sent(proxy, entry_name(call), **data).request == expected
                    assert sent(proxy, entry_name(call), *values).request == expected


def generated_request(method: Method[Any, Any], data: dict[str, Any]) -> bytes | None:
    """None if generated code refuses the arguments."""
    try:
        return b"".join(method.request(*method.arguments.made_values(data)))
    except (EncodeError, JsonError):
        return None


def test_replies_are_read_alike(name: str) -> None:
    proxy, known = sender(dynamic_class(name)), tables(name)
    plain, dice = Plain(MODEL, 11), Random(11)
    for call in calls(name):
        keys, slots = split(outputs(MODEL, call))
        arguments = plain.values([slot for _, slot in inputs(MODEL, call)], False)
        dynamic = sent(proxy, entry_name(call), *arguments).method
        for _ in range(8 if slots else 0):
            values = plain.values(slots, False)
            reply = encoded(name, call, values)
            again = known[call.code].result(Decoder(reply))
            assert b"".join(known[call.code].body(again)) == reply
            masked = [shown(MODEL, s, v) for s, v in zip(slots, values, strict=True)]
            wanted = dict(zip(keys, masked, strict=True)) if len(slots) > 1 else masked[0]
            assert dynamic.result(Decoder(reply)) == wanted
            for _ in range(6):
                broken = damaged(reply, dice)
                expected = problem(known[call.code], broken)
                if expected is not DecodeProblem.INVALID_VALUE:  # of a class written by hand
                    # of two errors, the codecs may report different ones
                    assert (problem(dynamic, broken) is None) == (expected is None)


def split(slots: list[tuple[str, Slot]]) -> tuple[list[str], list[Slot]]:
    return [key for key, _ in slots], [slot for _, slot in slots]


def encoded(name: str, call: CallLayout, values: list[Any]) -> bytes:
    """A reply, encoded by the types of the served model."""
    model = read_model(served(MODEL, LAYOUT, name), name)
    member = next(m for m in model.members if m.name == call_name(call))
    types, out = Types(model), []
    results = member.outputs if isinstance(member, Operation) else (member.result,)
    for value, each in zip(results, values, strict=True):
        kind = kind_of(types.step(value))
        kind.put(kind.made(each, ""), out, "")
    return b"".join(out)


def damaged(reply: bytes, dice: Random) -> bytes:
    changed = bytearray(reply)
    if dice.random() < 0.3:
        del changed[dice.randrange(len(changed) + 1) :]
    for _ in range(2):
        if changed:
            changed[dice.randrange(len(changed))] = dice.choice((0, 1, 2, 127, 255))
    return bytes(changed)


def problem(method: Method[Any, Any], data: bytes) -> DecodeProblem | None:
    try:
        method.result(Decoder(data))
    except DecodeError as error:
        return error.problem
    return None
