"""Proxies made at run time: arguments, results, errors and descriptions as a program sees them."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from contextlib import suppress
from functools import partial
from random import Random
from typing import Any

import gecos
import pytest
from gecos.dynamic_client import DynamicObject, ModelError, description_of, proxy_class
from gecos.dynamic_client import names as dynamic_names
from gecos.dynamic_client.proxy import _Builder
from gecos.interface import Method
from gecos.wire import DecodeError, Decoder, EncodeError, to_bytes
from gidl.names.languages import PYTHON_WORDS
from gidl.names.type_names import escaped
from robcl.frames import Frame
from robcl.laser_distance_sensor import Distance, LaserDistanceSensorServant, SensorFault
from served_models import load, names, served

MODEL, LAYOUT = load()
GOAL = {"position": {"x": 1}, "orientation": {"w": 1}}


def texts(name: str) -> list[str]:
    return served(MODEL, LAYOUT, name)


def issued(name: str, method: str, *given: Any, **named: Any) -> tuple[Method[Any, Any], bytes]:
    """The method table and the request of a call."""

    class Proxy(proxy_class(texts(name), name)):  # type: ignore[misc]
        def __init__(self) -> None:
            self._gecos_sent: Any = None

        def _gecos_call(self, table: Method[Any, Any], arguments: Any) -> Any:
            return table, b"".join(arguments)

    found: tuple[Method[Any, Any], bytes] = getattr(Proxy(), method)(*given, **named)
    return found


# -- with a server ---------------------------------------------------------------------------------


class Lds(LaserDistanceSensorServant):
    def __init__(self) -> None:
        self.on = True
        self.offset = Frame()

    def base(self) -> Frame:
        return self.offset

    def parent(self) -> str:
        return "RX90"

    def mount(self, carrier: str, offset: Frame) -> None:
        self.offset = offset

    def beam(self) -> Distance:
        return self.measure()

    def measure(self) -> Distance:
        if not self.on:
            raise SensorFault("the laser is off")
        return Distance(0.25, True, 0.1, 1.0, 100.0)

    def power(self, on: bool) -> None:
        self.on = on


def sensor_class() -> type[DynamicObject]:
    return proxy_class(texts("robcl::LaserDistanceSensor"), "robcl::LaserDistanceSensor")


def test_a_call_gives_plain_data(lab: gecos.Lab, server: gecos.Server) -> None:
    server.add("LASER", Lds(), simulated=True)
    sensor: Any = lab.create(sensor_class(), "LASER")
    expected = {"value": 0.25, "valid": True, "lower": 0.1, "upper": 1.0, "stamp": 100.0}
    assert sensor.measure().result() == expected
    with gecos.actor(sensor):
        sensor.mount("RX90", offset=GOAL).result()
        sensor.power(False).result()
    assert sensor.base().result()["position"] == {"x": 1.0, "y": 0.0, "z": 0.0}
    with pytest.raises(gecos.DeclaredError, match="the laser is off") as caught:
        sensor.measure().result()
    assert caught.value._gecos_name == "robcl::SensorFault"
    assert caught.value.reason == "the laser is off"  # type: ignore[attr-defined]


def test_a_proxy_waits_for_its_object(lab: gecos.Lab, server: gecos.Server) -> None:
    for name, dynamic in (("LEFT", lab.dynamic), ("RIGHT", partial(gecos.dynamic, lab=lab))):
        starts = threading.Timer(0.3, server.add, (name, Lds()))
        starts.start()
        sensor: Any = dynamic(name, wait=20)
        assert sensor.measure().result()["value"] == 0.25
        starts.join()
    with pytest.raises(gecos.CreateError, match="no such object is online"):
        lab.dynamic("NOBODY", wait=0.1)


def test_a_stream_gives_plain_samples(lab: gecos.Lab, server: gecos.Server) -> None:
    servant = Lds()
    server.add("LASER", servant)
    sensor: Any = lab.create(sensor_class(), "LASER")
    stream = sensor.beam.stream()
    servant.publish_beam(Distance(0.5, True, 0.1, 1.0, 7.0))
    assert stream.next(10.0).value["value"] == 0.5


# -- arguments -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("goal", "how", "why"),
    [
        ({"position": {"x": "a"}}, None, "move.goal.position.x: a number is expected, a text"),
        ({"position": [1]}, None, "move.goal.position: an object is expected, a list is there"),
        ({"q": 1}, None, "move.goal.q: unknown member; the known members are position, orient"),
        (None, None, "move.goal: an object is expected, null is there"),
        (GOAL, {"speed": 2}, r"move.how.speed: 2.0 is outside \[0.01, 1.0\]"),
        (GOAL, {"path": "BENT"}, "move.how.path: unknown name BENT; the known names are STRAIGHT"),
        (object(), None, "move.goal: a value of the type object is not plain data"),
    ],
)
def test_a_wrong_argument_is_named(goal: Any, how: Any, why: str) -> None:
    with pytest.raises(EncodeError, match=f"^{why}"):
        issued("robcl::Rx90", "move", goal, how)


def test_the_element_of_a_wrong_list_is_named() -> None:
    with pytest.raises(EncodeError, match=r"^go.to\[1\]: 4.0 is outside \[-3.0, 3.0\]"):
        issued("bounded::Robot", "go", [0, 4, 0], {})
    with pytest.raises(EncodeError, match=r"^go.by_level\[0\]: 10 is outside \[1, 9\]"):
        issued("bounded::Robot", "go", [0, 0, 0], {10: 0})
    with pytest.raises(EncodeError, match=r"^paint.words\[1\]: 6 bytes"):
        issued("everything::Stage", "paint", "RED", ["a", "longer"])


@pytest.mark.parametrize(
    ("given", "named", "why"),
    [
        ((), {}, r"move\(\) needs its parameter goal"),
        ((1, 2, 3, 4), {}, r"move\(\) takes at most 3 arguments, 4 are given"),
        ((GOAL,), {"goal": GOAL}, r"move\(\) got two values for its parameter goal"),
        ((GOAL,), {"fast": 1}, r"move\(\) has no parameter fast; give one of goal, how"),
    ],
)
def test_arguments_are_checked_as_in_python(given: Any, named: Any, why: str) -> None:
    with pytest.raises(TypeError, match=why):
        issued("robcl::Rx90", "move", *given, **named)


def test_arguments_with_defaults_may_be_left_out() -> None:
    whole = issued("everything::Stage", "paint", "RED", [], 3)
    assert issued("everything::Stage", "paint", "RED", words=[])[1] == whole[1]


def test_a_map_may_be_a_dict() -> None:
    pairs = issued("bounded::Robot", "go", [0, 0, 0], [[2, 0.5], [1, 0.25]])[1]
    assert issued("bounded::Robot", "go", (0, 0, 0), {1: 0.25, 2: 0.5})[1] == pairs
    assert issued("bounded::Robot", "go", (0, 0, 0), {"1": 0.25, "2": 0.5})[1] == pairs
    with pytest.raises(EncodeError, match="already has this key"):
        issued("bounded::Robot", "go", (0, 0, 0), {"1": 0.25, 1: 0.5})


def test_a_secret_is_sent_and_never_shown() -> None:
    _, request = issued("workshop::Changer", "turn", 1.0, "hunter2")
    assert b"hunter2" in request
    with pytest.raises(EncodeError) as caught:
        issued("workshop::Changer", "turn", 1.0, "hunter2\0")
    assert "hunter2" not in str(caught.value)
    with pytest.raises(EncodeError, match="stands for a secret"):
        issued("workshop::Changer", "turn", 1.0, "***")
    table, _ = issued("bounded::Robot", "both")
    reply = b"\0" * 8 + b"\0\0\0\0" + b"\0\0\0\2q\0"
    assert table.result(Decoder(reply)) == {"result": 0.0, "along": [], "token": "***"}


def test_an_exception_has_plain_members() -> None:
    table, _ = issued("bounded::Robot", "go", [0, 0, 0], {})
    (kind,) = table.raises
    error = kind.decode(Decoder(b"\0" * 8 + b"\0\0\0\2q\0"))
    assert str(error) == "bounded::Broken(at=0.0, token=***)"
    assert error.at == 0.0  # type: ignore[attr-defined]
    assert kind.__name__ == "Broken"


def test_feedback_is_plain() -> None:
    from robcl.manipulator_types import MotionProgress

    table, _ = issued("robcl::Rx90", "move", GOAL)
    assert table.feedback is not None
    data = to_bytes(MotionProgress(0.5, 2.0))
    known = {"fraction": 0.5, "remaining": 2.0, "corner": None, "speed_override": None}
    assert table.feedback(Decoder(data)) == known


def test_a_proxy_describes_its_members() -> None:
    model = description_of(proxy_class(texts("robcl::Gripper"), "robcl::Gripper"))
    found = {each.name: each for each in model.members}
    assert list(found)[:3] == ["base", "parent", "mount"]
    width = found["open"].parameters[0]
    assert (width.name, width.type, width.unit, width.range) == (
        "width",
        "double",
        "m",
        "at least 0.0",
    )
    assert found["open"].feedback == "robcl::GripperState"
    assert found["open"].raises == ("robcl::WidthOutOfRange",)
    assert found["jaws"].stream.rate_hz == 50.0  # type: ignore[union-attr]
    assert found["max_width"].result is not None
    assert found["max_width"].result.unit == "m"


def test_docstrings_are_those_of_generated_code() -> None:
    from robcl.gripper import Gripper

    kind: Any = proxy_class(texts("robcl::Gripper"), "robcl::Gripper")
    for name in ("open", "jaws", "max_width", "grip_point"):
        words = (getattr(each, name).__doc__.split() for each in (kind, Gripper))
        assert next(words) == next(words)


WORDS = {
    "PARAMETER_WORDS": PYTHON_WORDS,
    "METHOD_WORDS": names.METHOD_WORDS,
    "STRUCT_WORDS": names.STRUCT_WORDS,
    "BITSET_WORDS": names.STRUCT_WORDS | {"pack", "unpack"},  # as gidl.targets.python.types_file
    "EXCEPTION_WORDS": names.EXCEPTION_WORDS,
    "ENUM_WORDS": names.ENUM_WORDS,
}


@pytest.mark.parametrize("words", sorted(WORDS))
def test_names_are_escaped_as_in_generated_code(words: str) -> None:
    taken = WORDS[words]
    assert getattr(dynamic_names, words) == taken
    taken |= {"held_"}
    for plain in (*taken, "held", "width", "class_of"):
        for name in (plain, f"{plain}_", f"{plain}__"):
            assert dynamic_names.escaped(name, taken) == escaped(name, taken)
            assert dynamic_names.member_name(name, taken) == names.member_name(name, taken)


def test_slow_modules_are_not_imported() -> None:
    name = "robcl::Rx90"
    code = (
        "import json, sys; from gecos.dynamic_client import proxy_class;"
        "kind = proxy_class(json.load(sys.stdin), 'robcl::Rx90');"
        "from gecos.dynamic_client.types import Types;"
        "from gecos.wire.kinds import kind_of;"
        "types = Types(kind._gecos_model);"
        "joints = next(m for m in kind._gecos_model.members if m.name == 'joints');"
        "made = kind_of(types.step(joints.result)).made({}, '');"
        "assert not {'numpy', 'click', 'rich', 'asyncio', 'gidl'} & sys.modules.keys()"
    )
    subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        env={"PYTHONPATH": ":".join(filter(None, sys.path))},
        input=json.dumps(texts(name)),
        text=True,
    )


def test_only_the_members_that_are_asked_for_are_made() -> None:
    name = "robcl::Rx90"
    kind = proxy_class(texts(name), name, only=["tool"])
    assert isinstance(vars(kind)["tool"], property)
    assert not {"move", "flange", "set_tool_offset"} & set(dir(kind))
    assert {each.name for each in kind._gecos_model.members} >= {"tool", "move", "flange"}
    assert [each.name for each in kind._gecos_interface.operations] == ["tool"]


def test_the_errors_of_dynamic_are_found_in_the_package() -> None:
    assert gecos.ModelError is ModelError
    assert "ModelError" in dir(gecos)
    told = gecos.Lab.dynamic.__doc__ or ""
    for name in ("CreateError", "ModelError", "CommandFailed", "ConnectionFailed"):
        assert name in told
        assert hasattr(gecos, name)


# -- malformed models ------------------------------------------------------------------------------


def model_with(types: list[Any], used: str = "S", **changed: Any) -> list[str]:
    get = {"kind": "attribute", "name": "a", "type": used, "readonly": True, "hash": "0x1"}
    interface = {
        "kind": "interface",
        "name": "I",
        "hash": "0x1",
        "members": [get | {"codes": {"get": 1}}],
    }
    return [json.dumps({"interface": interface | changed, "types": types})]


def struct(name: str, *members: str, **more: Any) -> Any:
    listed = [{"name": f"m{i}", "type": each} for i, each in enumerate(members)]
    return {
        "kind": "struct",
        "name": name,
        "members": listed,
        "wire": {"fingerprint": "0x1"},
    } | more


CHAIN = [struct(f"S{i}", f"S{i + 1}") for i in range(5000)]
LAUGHS = [struct("S", *["S1"] * 9), *(struct(f"S{i}", *[f"S{i + 1}"] * 9) for i in range(1, 9))]
EMPTY = struct("E")
NO_BYTES = "values that take no bytes"


def typedef(name: str, type: str) -> Any:
    return {"kind": "typedef", "name": name, "type": type}


def optional(name: str, type: str) -> Any:
    return struct(name, members=[{"name": "m", "type": type, "optional": True}])


def operation(*results: str) -> Any:
    """An operation that sets one parameter of each type in `results`."""
    listed = [{"name": f"p{i}", "type": t, "direction": "out"} for i, t in enumerate(results)]
    return {"kind": "operation", "name": "o", "code": 1, "hash": "0x1", "parameters": listed}


LISTS = [struct(f"S{i or ''}", f"sequence<S{i + 1}>") for i in range(5000)]


@pytest.mark.parametrize(
    ("served_texts", "why"),
    [
        ([], "there is no text of interface I"),
        (["{"], "text 1 is not JSON"),
        (["[" * 100_000], "text 1 is not JSON"),
        (["[]"], "text 1 is not an object"),
        (['{"interface": {}, "interface": {}}'], "an object has two entries with the same name"),
        (["{}"], "text 1 has no 'interface'"),
        (model_with([]), "I::a uses the type S, which is not declared"),
        (model_with([struct("S", "T")]), "type S uses the type T, which is not declared"),
        (model_with([struct("S", "S")]), "type S contains itself other than through a sequence"),
        (model_with([struct("S", "S[2]")]), "type S contains itself"),
        (model_with([struct("S", base="S")]), "a base of type S is missing"),
        (model_with([struct("S"), struct("S", "double")]), "type S is declared in two different"),
        (model_with([struct("S", "double[99999999]")]), "more than 4194304 members"),
        (model_with([*LAUGHS, struct("S9", "double")]), "more than 4194304 members"),
        (model_with([*CHAIN, struct("S5000"), struct("S", "S0")]), "64 levels"),
        (model_with([*LISTS, struct("S5000")]), "more than 64 levels of types"),
        (model_with([{"kind": "typedef", "name": "S", "type": "S"}]), "type S contains itself"),
        (model_with([EMPTY], "E[65537]"), NO_BYTES),
        (model_with([EMPTY], "E[300][300]"), NO_BYTES),
        (model_with([EMPTY], "sequence<E[2000000000]>"), NO_BYTES),
        (model_with([EMPTY], "map<string, E[300000]>"), NO_BYTES),
        (model_with([EMPTY, typedef("A", "E[3000]")], "A[3000]"), NO_BYTES),
        (model_with([EMPTY, typedef("A", "E[3000]")], "sequence<A>"), NO_BYTES),
        (model_with([EMPTY, struct("A", "E[3000]")], "map<string, A[3000]>"), NO_BYTES),
        (model_with([EMPTY, optional("S", "E[300000]")]), NO_BYTES),
        (model_with([EMPTY, struct("A", "E[3000]"), optional("S", "A[3000]")]), NO_BYTES),
        (model_with([EMPTY, typedef("A", "sequence<E>"), struct("S", *["A"] * 65)]), NO_BYTES),
        (model_with([EMPTY], members=[operation(*["E[65536]"] * 65)]), NO_BYTES),
        (model_with([], "map<sequence<double>, double>"), "sequence cannot be the key of a map"),
        (model_with([EMPTY], "map<E, double>"), "E cannot be the key of a map"),
        (model_with([], "map<double, double>"), "double cannot be the key of a map"),
        (model_with([typedef("A", "float")], "map<A, string>"), "A cannot be the key of a map"),
        (model_with([], "map<map<char, char>, double>"), "map cannot be the key of a map"),
        (model_with([], "sequence<" * 9000), "nested deeper than 16"),
        (model_with([], "sequence<double"), "'>' is expected"),
        (model_with([], "double x"), "unexpected text after the type"),
        (model_with([], "string<-1>"), "unexpected character"),
        (model_with([{"kind": "enum", "name": "S"}]), "type S has no enumerators"),
        (model_with([{"kind": "thing", "name": "S"}]), "'kind' of type S is none of struct"),
        (model_with([struct("S", "double", members=[{"name": "__class__", "type": "double"}])]),
         "is not a name"),
        (model_with([{"kind": "typedef", "name": "S", "type": "float", "range": {"min": 10**40}}]),
         "the range at least 1"),
        (model_with([], "double", bases=["I"]), "interface I inherits from itself"),
        (model_with([], "double", bases=["J"]), "there is no text of interface J"),
        (model_with([], "double", hash=7), "'hash' of interface I is not a text"),
        (model_with([], "double", members=[{"kind": "attribute"}]), "has no 'name'"),
    ],
)  # fmt: skip
def test_a_malformed_model_is_refused(served_texts: list[str], why: str) -> None:
    with pytest.raises(ModelError, match=r"^the model of I is not valid: ") as caught:
        proxy_class(served_texts, "I")
    assert why in caught.value.why
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    ("types", "used", "reply", "size"),
    [
        ([EMPTY], "E[65536]", b"", 65536),
        ([EMPTY], "sequence<E>", b"\0\1\0\0", 65536),
        ([EMPTY, struct("A", "E[16]")], "sequence<A, 9>", b"\0\0\0\2", 2),
        ([struct("S", "sequence<T>"), struct("T", "S[2]")], "S[3]", b"\0" * 12, 3),
        ([], "double[70000]", b"\0" * 560_000, 70_000),
    ],
)
def test_values_without_bytes_are_limited(
    types: list[Any], used: str, reply: bytes, size: int
) -> None:
    class Proxy(proxy_class(model_with(types, used), "I")):  # type: ignore[misc]
        def _gecos_call(self, table: Method[Any, Any], arguments: Any) -> Any:
            return table.result(Decoder(reply))

    assert len(Proxy(None).a()) == size


def test_a_changed_model_is_refused_or_decodes_any_reply(monkeypatch: pytest.MonkeyPatch) -> None:
    tables: list[Method[Any, Any]] = []
    make = _Builder._table

    def kept(*given: Any) -> Any:
        tables.append(make(*given))
        return tables[-1]

    monkeypatch.setattr(_Builder, "_table", kept)
    dice = Random(5)
    given = [json.loads(text) for text in texts("everything::Deep")]
    refused = read = 0
    for _ in range(150):
        copy = json.loads(json.dumps(given))
        change(copy, dice)
        tables.clear()
        try:
            proxy_class([json.dumps(each) for each in copy], "everything::Deep")
        except ModelError:
            refused += 1
            continue
        read += sum(decodes(each, dice) for each in tables)
    assert refused > 30
    assert read > 30


def decodes(table: Method[Any, Any], dice: Random) -> bool:
    """Whether random bytes are a valid reply."""
    read = False
    for decode in (table.result, *(each.decode for each in table.raises)):
        with suppress(DecodeError):
            decode(Decoder(bytes(dice.choices((0, 0, 0, 0, 1, 2, 97, 255), k=dice.randrange(400)))))
            read = True
    return read


def change(data: Any, dice: Random) -> None:
    """Replaces one entry by another value, or removes it."""
    while True:
        keys: list[Any] = list(data) if isinstance(data, dict) else list(range(len(data)))
        key = dice.choice(keys)
        if isinstance(data[key], dict | list) and data[key] and dice.random() < 0.95:
            data = data[key]
            continue
        if dice.random() < 0.3:
            del data[key]
        else:
            wrong: list[Any] = [None, -1, 10**40, 1e300, "", "double", "x::y", [], {}, [[]], True]
            data[key] = dice.choice(wrong)
        return
