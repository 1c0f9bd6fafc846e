"""What is @secret is nowhere shown: not by repr, str or a traceback, not in JSON, not in the text
of a refusal."""

from __future__ import annotations

import copy
import pickle
import sys
import traceback
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import pytest
from gecos import wire
from gecos.wire.json import dumps, loads
from generating import generate

IDL = """
module secrets {
  typedef string<8> Digits;
  struct Login { string user; @secret Digits pin; @secret @optional string word; };
  exception Refused { string why; @secret string pin; };
  union Key switch (long) { case 1: string name; case 2: @secret Digits pin; };
  union Proof switch (long) {
    case 1: @secret string pin; case 2: Login both; case 3: unsigned long count;
    case 5: char letter; case 6: string<3> word; };
  union Only switch (boolean) { case TRUE: @secret string pin; };

  @version("1.0") interface Door {
    @secret string code();
    @secret Digits both(in string user, @secret in Digits pin, @secret out Digits again,
      @secret inout string third);
    void open(in Login with, @optional @secret in string pin) raises (Refused);
    @secret attribute Digits master_pin;
  };
};
"""
SECRET = "hunter2"


@pytest.fixture(scope="module")
def types(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    out = tmp_path_factory.mktemp("secrets")
    (out / "secrets_.gidl").write_text(IDL)
    generate(out, out / "secrets_.gidl")
    sys.path.insert(0, str(out / "python"))
    yield import_module("secrets__types")
    sys.path.remove(str(out / "python"))


def values(types: Any) -> Iterator[Any]:
    yield types.Login("ann", SECRET, SECRET)
    yield types.Refused("no", SECRET)
    yield types.Refused(why="no", pin=SECRET)
    yield types.Key.make_pin(SECRET)
    yield types.Only.make_pin(SECRET)
    yield types.Only(False, SECRET)  # which nothing selects
    yield types.Door_both_result(SECRET, SECRET, SECRET)


def test_no_value_shows_one(types: Any) -> None:
    for value in values(types):
        assert SECRET not in repr(value) + str(value)
        assert SECRET not in dumps(value)
        assert SECRET not in repr(copy.copy(value)) + str(pickle.loads(pickle.dumps(value)))


def test_a_traceback_shows_none(types: Any) -> None:
    pin = SECRET
    try:
        raise types.Refused("no", pin)
    except types.Refused as error:
        assert SECRET not in traceback.format_exc()
        assert SECRET not in repr(error.args)
        assert str(error) == "secrets::Refused(why='no', pin=***)"
        assert error.pin == SECRET


def test_what_is_no_secret_is_shown(types: Any) -> None:
    assert repr(types.Key.make_name("ann")) == "Key(tag=1, value='ann')"
    assert repr(types.Key.make_pin(SECRET)) == "Key(tag=2, value=***)"
    assert repr(types.Login("ann", SECRET)) == "Login(user='ann')"
    assert dumps(types.Key.make_pin(SECRET)) == '{"tag": 2, "value": "***"}'
    assert dumps(types.Key.make_name("ann")) == '{"tag": 1, "value": "ann"}'
    assert loads(types.Key, '{"tag": 2, "value": "1234"}') == types.Key.make_pin("1234")
    with pytest.raises(wire.JsonError, match="value: the text stands for a secret"):
        loads(types.Key, '{"tag": 2, "value": "***"}')


def test_a_secret_under_the_tag_of_another_arm_is_not_shown(types: Any) -> None:
    assert repr(types.Proof(2, SECRET)) == "Proof(tag=2, value=***)"


@pytest.mark.parametrize(
    "wrong", [SECRET, [SECRET], SECRET.encode()], ids=["text", "list", "bytes"]
)
def test_a_secret_under_the_tag_of_another_arm_is_not_said(types: Any, wrong: Any) -> None:
    for tag in (2, 3, 4, 5, 6):
        union = types.Proof(tag, wrong)
        assert SECRET not in repr(union)
        with pytest.raises((wire.EncodeError, AttributeError)) as refused:
            wire.to_bytes(union)
        assert SECRET not in "".join(traceback.format_exception(refused.value))
    with pytest.raises(wire.EncodeError, match="-1 is not a whole number"):
        wire.to_bytes(types.Proof(3, -1))


WRONG = [
    SECRET + "\0",
    SECRET + "\ud800",
    SECRET * 4,
    [SECRET],
    b"hunter2",
]


@pytest.mark.parametrize("wrong", WRONG, ids=["NUL", "no UTF-8", "too long", "a list", "bytes"])
def test_no_refusal_says_it(types: Any, wrong: Any) -> None:
    module = import_module("secrets_")
    handlers = {h.method: h for h in module.DoorServant._gecos_handlers.values()}
    proxy = object.__new__(module.Door)
    object.__setattr__(proxy, "_gecos_call", lambda method, parts: None)
    acts = [
        lambda: wire.to_bytes(types.Login("ann", wrong)),
        lambda: wire.to_bytes(types.Refused("no", wrong)),
        lambda: wire.to_bytes(types.Key.make_pin(wrong)),
        lambda: proxy.both("ann", wrong, "a"),
        lambda: proxy.open(types.Login("ann", "1"), wrong),
        lambda: proxy.set_master_pin(wrong),
        lambda: handlers["code"].result(wrong),
        lambda: handlers["both"].result(types.Door_both_result("a", wrong, "b")),
    ]
    refused = 0
    for act in acts:
        try:
            act()
        except wire.EncodeError as error:
            refused += 1
            assert SECRET not in "".join(traceback.format_exception(error))
            assert SECRET not in error.why
    accepted = 3 if wrong == SECRET * 4 else 0  # by strings without a bound
    assert refused == len(acts) - accepted
