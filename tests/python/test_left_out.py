"""What a program asked for after a command that did not succeed is left out (`@on_new("blend")`),
until the program has seen the failure."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import gecos
import pytest
from gecos import Detail, State
from gecos.interface import OnNew
from gecos.record import replace
from lamp import LAMP, Lamp, PlainLamp

CHAIN = replace(
    LAMP,
    operations=tuple(
        replace(operation, on_new=OnNew.BLEND) if operation.name == "shine" else operation
        for operation in LAMP.operations
    ),
)


class ChainLamp(Lamp):
    _gecos_interface = CHAIN


class ChainServant(PlainLamp):
    _gecos_interface = CHAIN


@pytest.fixture
def chained() -> ChainServant:
    return ChainServant()


@pytest.fixture(params=["inproc", "shm", "lcm"])
def lit(
    lab: gecos.Lab, chained: ChainServant, request: pytest.FixtureRequest
) -> Iterator[ChainLamp]:
    medium = request.param
    with gecos.Server(lab) as server:
        server.add("LAMP", chained, simulated=True, media=[medium])
        lamp = lab.create(ChainLamp, "LAMP", medium=medium)
        with gecos.actor(lamp):
            yield lamp


def test_what_comes_after_a_failure_names_it_and_is_not_carried_out(
    lit: ChainLamp, chained: ChainServant
) -> None:
    first, burnt, later = lit.shine(10.0), lit.shine(1200.0), lit.shine(50.0)
    with pytest.raises(gecos.CommandFailed) as left_out:
        later.result()
    assert left_out.value.detail is Detail.REJECTED
    assert str(left_out.value).startswith(
        "REJECTED: 'shine' of LAMP was not carried out, because the earlier command 'shine' of the "
        "same caller did not succeed: FAULT, "
    ), str(left_out.value)
    first.result()
    assert burnt.state is State.COMMAND_FAILED
    assert chained.starts == ["shine", "shine"]
    assert chained.value == 10


def test_a_program_begins_anew_when_it_has_seen_the_failure_and_not_when_only_its_reply_came(
    lit: ChainLamp, chained: ChainServant
) -> None:
    burnt = lit.shine(1200.0)
    lit.label().result()  # reads the reply of `burnt`, too
    while "COMMAND_FAILED" not in repr(burnt) and "FAULT" not in repr(burnt):
        lit.label().result()  # to print a command is not to look at it
    later = lit.shine(50.0)
    assert burnt.wait() is State.COMMAND_FAILED
    lit.shine(40.0).result()
    assert isinstance(later.exception(), gecos.CommandFailed)
    lit.shine(30.0).result()
    assert chained.value == 30


@pytest.mark.filterwarnings("ignore::gecos.UnobservedCommandWarning")
def test_a_command_that_is_dropped_is_not_seen(lit: ChainLamp, chained: ChainServant) -> None:
    gecos.command._warned.discard("shine")
    lit.shine(1200.0)  # its end is told by a warning when the next command replaces it
    gc.collect()
    lit.label().result()
    later = lit.shine(20.0)
    with pytest.raises(gecos.CommandFailed) as left_out:
        later.result()
    assert left_out.value.detail is Detail.REJECTED
    assert chained.value == 0


def test_a_detached_command_ends_no_others(lit: ChainLamp, chained: ChainServant) -> None:
    lit.shine(1200.0).detach()
    lit.shine(20.0).result()
    assert chained.value == 20


def test_the_cancel_of_a_command_that_waits_takes_those_after_it(
    lit: ChainLamp, chained: ChainServant
) -> None:
    burning = lit.burn_in()
    chained.burning.wait()
    first, second, third = lit.shine(1.0), lit.shine(2.0), lit.shine(3.0)
    second.cancel()
    for command in (second, third):
        with pytest.raises(gecos.CommandFailed) as canceled:
            command.result()
        assert canceled.value.detail is Detail.CANCELED
    anew = lit.shine(4.0)
    chained.finish.set()
    burning.result()
    first.result()
    anew.result()
    assert chained.starts == ["burn_in", "shine", "shine"]
