"""Errors keep what they carry when they are copied, pickled or raised in another process."""

from __future__ import annotations

import copy
import pickle
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from gecos.errors import (
    Attempt,
    CommandFailed,
    ConnectionFailed,
    CreateError,
    Detail,
    Interrupted,
    LeaseRefused,
    Rejected,
)  # fmt: skip
from generating import generate
from robcl.manipulator_types import JointLimit, OutOfReach

IDL = """
module copied {
  @final struct Place { double x; };
  exception Bare {};
  exception Rich { string text; copied::Place place; sequence<double> path;
    @optional long args; @secret string pin; };
};
"""


@pytest.fixture(scope="module")
def types(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    out = tmp_path_factory.mktemp("copied")
    (out / "copied.gidl").write_text(IDL)
    generate(out, out / "copied.gidl")
    sys.path.insert(0, str(out / "python"))
    yield import_module("copied_types")
    sys.path.remove(str(out / "python"))


def pickled(protocol: int) -> Callable[[Any], Any]:
    return lambda error: pickle.loads(pickle.dumps(error, protocol))


COPIES = [copy.copy, copy.deepcopy, *(pickled(p) for p in range(2, pickle.HIGHEST_PROTOCOL + 1))]


@pytest.mark.parametrize("again", COPIES)
def test_declared_exceptions_keep_their_members(types: Any, again: Callable[[Any], Any]) -> None:
    rich = types.Rich("a", types.Place(1.5), np.array([2.0]), None, "1234")
    rich.add_note("seen at noon")
    made = again(rich)
    assert type(made) is types.Rich
    assert (made.text_, made.place, made.args_, made.pin) == ("a", types.Place(1.5), None, "1234")
    assert list(made.path) == [2.0]
    assert made.__notes__ == ["seen at noon"]
    assert str(made) == str(rich)
    assert type(again(types.Bare())) is types.Bare


def test_a_deep_copy_shares_nothing(types: Any) -> None:
    rich = types.Rich(place=types.Place(1.5))
    copied = copy.deepcopy(rich)
    copied.place.x = 2.0
    assert rich.place.x == 1.5


@pytest.mark.parametrize("again", COPIES)
def test_so_do_the_others(again: Callable[[Any], Any]) -> None:
    for error in (
        CommandFailed(Detail.TIMED_OUT, "late"), Rejected("no"), Interrupted(),
        ConnectionFailed(Detail.NO_SERVER, "gone"), LeaseRefused("held", ()),
        CreateError([Attempt("A", Detail.NO_SERVER, "gone")]),
    ):  # fmt: skip
        made = again(error)
        assert type(made) is type(error)
        assert (str(made), made.args) == (str(error), error.args)
        if isinstance(error, CommandFailed):
            assert (made.detail, made.text) == (error.detail, error.text)


def out_of_reach() -> None:
    raise OutOfReach("too far")


def joint_limit() -> None:
    raise JointLimit(3, 1.5, lower=-1.0, upper=1.0)


def test_a_process_pool_raises_them_with_their_members() -> None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        with pytest.raises(OutOfReach) as reach:
            pool.submit(out_of_reach).result()
        with pytest.raises(JointLimit) as limit:
            pool.submit(joint_limit).result()
    assert reach.value.reason == "too far"
    assert (limit.value.axis, limit.value.value, limit.value.lower) == (3, 1.5, -1.0)
