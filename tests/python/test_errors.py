from __future__ import annotations

import pickle
from typing import Any

import gecos
import pytest
from gecos import Attempt, CreateError, Detail
from lamp import Burnt
from robcl.manipulator_types import Configuration, JointLimit, PlaceOnLine


def test_create_says_why_for_each_name() -> None:
    error = CreateError(
        [
            Attempt("RX90", Detail.NO_SERVER, "not online"),
            Attempt("SIM", Detail.REFUSED, "is a test::Lamp, not a test::Heater"),
        ]
    )
    assert str(error) == (
        "RX90: NO_SERVER: not online; SIM: REFUSED: is a test::Lamp, not a test::Heater"
    )


def test_create_without_a_name_says_so() -> None:
    assert str(CreateError([])) == "create was given no name"


@pytest.mark.parametrize(
    ("kind", "natural"),
    [
        (gecos.CreateError, ConnectionError),
        (gecos.ConnectionFailed, ConnectionError),
        (gecos.StreamLost, ConnectionError),
        (gecos.StreamRevoked, gecos.StreamLost),
        (gecos.DeadlineMissed, TimeoutError),
        (gecos.CommandFailed, RuntimeError),
        (gecos.DeclaredError, gecos.CommandFailed),
        (gecos.LeaseRefused, PermissionError),
        (gecos.ServeError, RuntimeError),
        (gecos.UnobservedCommandWarning, RuntimeWarning),
    ],
)
def test_errors_derive_from_the_natural_builtin(kind: type, natural: type) -> None:
    assert issubclass(kind, natural)


def test_a_failure_shows_its_detail_and_text() -> None:
    assert str(gecos.CommandFailed(Detail.STOPPED, "by ada")) == "STOPPED: by ada"
    assert str(gecos.ConnectionFailed(Detail.NO_SERVER, "gone")) == "NO_SERVER: gone"


def test_a_declared_exception_shows_its_members() -> None:
    error = Burnt(hours=12)
    assert (error.detail, error.text) == (Detail.FAULT, "test::Burnt(hours=12)")
    assert repr(error) == "Burnt(hours=12)"


@pytest.mark.parametrize(
    ("computed", "asks"),
    [
        ({}, True),
        ({"place": PlaceOnLine(way=0.1)}, False),
        ({"configuration": Configuration()}, False),
    ],
)
def test_a_value_that_the_object_computed_is_not_asked_about(
    computed: dict[str, Any], asks: bool
) -> None:
    error = JointLimit(axis=4, value=45.0, lower=-1.0, upper=1.0, **computed)
    assert ("is the value in degrees?" in str(error)) is asks


def test_two_declared_exceptions_are_two_exceptions() -> None:
    first, second = Burnt(hours=1), Burnt(hours=1)
    assert first != second
    assert len({first, second}) == 2


def test_failures_travel_between_processes() -> None:
    for error in (
        gecos.CommandFailed(Detail.FAULT, "why"),
        gecos.ConnectionFailed(Detail.NO_SERVER, "why"),
        CreateError([Attempt("RX90", Detail.NO_SERVER, "why")]),
        gecos.LeaseRefused("why"),
    ):
        twin = pickle.loads(pickle.dumps(error))
        assert type(twin) is type(error)
        assert str(twin) == str(error)
        assert vars(twin) == vars(error)
