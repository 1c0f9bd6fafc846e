from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import gecos
import pytest
from gecos import Detail, State, wire
from gecos_idl.object_types import Holder, Status, StatusRefused
from lamp import Lamp, PlainLamp
from test_process import running, says

SERVER = """
import gecos
from lamp import PlainLamp
gecos.serve({"LAMP": PlainLamp()}, simulated=True)
"""


@pytest.fixture
def other(lab: gecos.Lab, server: gecos.Server) -> Lamp:
    """A second proxy, which has a session of its own."""
    return lab.create(Lamp, "LAMP")


def test_status_lasts_as_long_as_the_block(lamp: Lamp) -> None:
    with gecos.actor(lamp):
        lamp.dim(1.0).result()
    with pytest.raises(gecos.CommandFailed) as caught:
        lamp.dim(1.0).result()
    assert caught.value.detail is Detail.DENIED
    assert "actor(object) of gecos" in caught.value.text


def test_a_second_client_is_refused_and_told_who_holds_it(held: Lamp, other: Lamp) -> None:
    with pytest.raises(gecos.LeaseRefused, match="LAMP") as caught:
        gecos.actor(other)
    (holder,) = caught.value.holders
    assert holder.status.name == "ACTOR"
    assert holder.user in str(caught.value)
    assert holder.held_for >= 0


def test_reading_needs_no_status(held: Lamp, other: Lamp) -> None:
    assert other.label().result() == "a lamp"


def test_master_refuses_reading_to_others(lamp: Lamp, other: Lamp) -> None:
    with gecos.master(lamp):
        assert lamp.label().result() == "a lamp"
        with pytest.raises(gecos.CommandFailed):
            other.label().result()
    assert other.label().result() == "a lamp"


def test_status_is_shared_by_password(lamp: Lamp, other: Lamp) -> None:
    with gecos.actor(lamp, password="sesame"):
        with pytest.raises(gecos.LeaseRefused):
            gecos.actor(other, password="open")
        with gecos.actor(other, password="sesame"):
            other.dim(1.0).result()
            lamp.dim(1.0).result()


def test_a_password_cannot_be_guessed_by_trying_many(lamp: Lamp, other: Lamp) -> None:
    with gecos.actor(lamp, password="sesame"):
        for guess in range(5):
            with pytest.raises(gecos.LeaseRefused, match="the given password is wrong"):
                gecos.actor(other, password=f"open {guess}")
        with pytest.raises(gecos.LeaseRefused, match=r"5 wrong passwords.*try again in") as refused:
            gecos.actor(other, password="sesame")
        assert len(refused.value.holders) == 1


def test_releasing_drains_what_was_issued(lamp: Lamp, other: Lamp, servant: PlainLamp) -> None:
    with gecos.actor(lamp):
        burning, dimmed = lamp.burn_in(), lamp.dim(1.0)
    servant.burning.wait()
    with pytest.raises(gecos.LeaseRefused) as caught:
        gecos.actor(other)
    assert caught.value.holders[0].releasing
    servant.finish.set()
    assert burning.wait() is State.FINISHED
    assert dimmed.wait() is State.FINISHED


def test_releasing_now_stops_what_was_issued(lamp: Lamp, other: Lamp, servant: PlainLamp) -> None:
    lease = gecos.actor(lamp)
    burning = lamp.burn_in()
    servant.burning.wait()
    lease.release_now()
    assert burning.wait() is State.COMMAND_FAILED
    with gecos.actor(other):
        pass


def test_a_released_lease_may_be_released_again(lamp: Lamp) -> None:
    lease = gecos.actor(lamp)
    lease.release()
    lease.release()
    lease.release_now()


def test_a_lease_shows_what_is_known_of_it(lamp: Lamp, other: Lamp, server: gecos.Server) -> None:
    with gecos.actor(lamp) as first:
        assert f"ACTOR of LAMP: acquired, not released, epoch {first.epoch:#x}" in repr(first)
        gecos.stop(lamp).result()
        assert ": acquired, not released," in repr(first), "it has stopped the object itself"
        gecos.stop(other).result()
        with gecos.actor(lamp) as second:
            assert ": lost," in repr(first)
            assert ": acquired, not released," in repr(second)
        assert ": released," in repr(second)
    assert ": released," in repr(first)

    last = gecos.actor(lamp)
    server.close()
    lamp.label().wait()
    assert ": lost," in repr(last)


def test_a_status_is_waited_for_in_line(lamp: Lamp, other: Lamp) -> None:
    places: list[int] = []
    lease = gecos.actor(lamp)

    def on_position(before: int) -> None:
        places.append(before)
        lease.release()

    with gecos.actor(other, timeout=60, on_position=on_position):
        other.dim(1.0).result()
    assert places == [0]


def test_a_wait_in_line_ends_in_time(held: Lamp, other: Lamp) -> None:
    with pytest.raises(gecos.LeaseRefused, match=r"the request waited 0\.05 s") as caught:
        gecos.master(other, timeout=0.05)
    assert len(caught.value.holders) == 1


def test_a_program_that_is_interrupted_leaves_the_line(lamp: Lamp, other: Lamp) -> None:
    lease = gecos.actor(lamp)

    def on_position(before: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gecos.actor(other, timeout=None, on_position=on_position)
    lease.release()
    with gecos.actor(lamp, timeout=60):  # not kept by the other, even if it was granted meanwhile
        lamp.dim(1.0).result()


def test_stop_ends_the_line(lamp: Lamp, other: Lamp) -> None:
    with (
        gecos.actor(lamp),
        pytest.raises(gecos.LeaseRefused, match="ended while it waited: stopped by"),
    ):
        gecos.actor(other, timeout=None, on_position=lambda before: gecos.stop(lamp).detach())


def test_a_server_that_dies_while_others_wait_is_a_failed_connection(lab: gecos.Lab) -> None:
    with running(SERVER) as server:
        assert says(server) == "serving LAMP\n"
        lease = gecos.actor(lab.create(Lamp, "LAMP"))
        waiting = lab.create(Lamp, "LAMP")
        with pytest.raises(gecos.ConnectionFailed, match="the server was lost while the request"):
            gecos.actor(waiting, timeout=None, on_position=lambda before: server.kill())
        lease.release()


def test_a_holder_is_told_who_asks_and_grants_by_releasing(lamp: Lamp, other: Lamp) -> None:
    lease = gecos.actor(lamp)
    asked = gecos.requests(lamp, timeout=None)
    asked.add_done_callback(lambda told: lease.release())
    with gecos.actor(other, timeout=None):
        other.dim(1.0).result()
    (request,) = asked.result()
    assert request.pid == os.getpid()
    assert request.wanted.name == "ACTOR"


def test_a_holder_denies_a_request_with_its_reason(held: Lamp, other: Lamp) -> None:
    def deny() -> None:
        (request,) = gecos.requests(held, timeout=None).result()
        assert gecos.deny(held, request.id, "hot").result()
        assert not gecos.deny(held, request.id).result()

    with ThreadPoolExecutor() as pool:
        denied = pool.submit(deny)
        with pytest.raises(
            gecos.LeaseRefused, match=r"refused by its holder, .*: hot \(request "
        ) as refused:
            gecos.actor(other, timeout=None)
        denied.result()
    assert len(refused.value.holders) == 1


def test_a_holder_that_denied_a_request_asks_again_for_newer_ones(held: Lamp, other: Lamp) -> None:
    with ThreadPoolExecutor() as pool:
        first = pool.submit(gecos.actor, other, timeout=30)
        (request,) = gecos.requests(held, timeout=None).result()
        newer = gecos.requests(held, request.id, timeout=None)
        (again,) = gecos.requests(held, timeout=None).result()
        assert again.id == request.id, "with 0 it is told of what still waits"
        assert newer.state is gecos.State.RUNNING
        gecos.deny(held, request.id, "hot").result()
        with pytest.raises(gecos.LeaseRefused):
            first.result()
        second = pool.submit(gecos.actor, other, timeout=30)
        (asked,) = newer.result()
        assert asked.id > request.id
        gecos.deny(held, asked.id).result()
        with pytest.raises(gecos.LeaseRefused):
            second.result()


def test_holders_lists_who_has_status(held: Lamp, other: Lamp) -> None:
    (holder,) = gecos.holders(other).result()
    assert holder.status.name == "ACTOR"
    assert not holder.releasing


def test_an_observer_is_told_each_change_of_the_holders(lamp: Lamp, other: Lamp) -> None:
    first = gecos.roster(other).result()
    assert (first.holders, first.changes) == ([], [])
    asked = gecos.roster(other, first.newest, timeout=None)
    with gecos.actor(lamp, password="sesame"):
        (came,) = asked.result().changes
        gecos.take_over(lamp).result()
    later = gecos.roster(other, came.number, timeout=None).result()
    assert [change.what.name for change in later.changes] == ["TAKEN_OVER", "ENDED"]
    assert (came.number, later.newest) == (first.newest + 1, first.newest + 3)
    assert came.holder.pid == later.changes[-1].holder.pid == os.getpid()
    assert later.changes[-1].why == "released"


def test_a_program_that_shares_the_status_takes_over_and_gives_back(
    lamp: Lamp, other: Lamp, servant: PlainLamp
) -> None:
    with gecos.actor(lamp, password="sesame"), gecos.actor(other, password="sesame"):
        burning = lamp.burn_in()
        servant.burning.wait()
        gecos.take_over(other).result()
        assert burning.wait() is State.COMMAND_FAILED
        assert burning.progress().detail is Detail.PREEMPTED
        with pytest.raises(gecos.CommandFailed, match="is held off: ") as caught:
            lamp.dim(1.0).result()
        assert caught.value.detail is Detail.DENIED
        assert sorted(each.taken_over for each in gecos.holders(lamp).result()) == [False, True]
        with pytest.raises(StatusRefused, match="has taken over") as refused:
            gecos.take_over(lamp).result()
        assert len(refused.value.holders) == 2
        other.dim(1.0).result()
        gecos.give_back(other).result()
        lamp.dim(1.0).result()


def test_a_program_without_the_status_does_not_take_over(held: Lamp, other: Lamp) -> None:
    with pytest.raises(StatusRefused, match="does not hold the status; acquire it first"):
        gecos.take_over(other).result()
    gecos.give_back(other).result()


def test_nobody_holds_a_fresh_object(lamp: Lamp) -> None:
    assert gecos.holders(lamp).result() == []


def test_anyone_may_stop(held: Lamp, other: Lamp, servant: PlainLamp) -> None:
    burning, queued = held.burn_in(), held.dim(1.0)
    servant.burning.wait()
    gecos.stop(other).result()
    assert burning.wait() is State.COMMAND_FAILED
    assert queued.wait() is State.COMMAND_FAILED
    assert burning.progress().detail is Detail.STOPPED
    assert servant.stopped.wait()
    assert servant.interrupted.wait()
    assert servant.starts == ["burn_in"]


def test_after_a_stop_status_may_be_had_at_once(held: Lamp, other: Lamp) -> None:
    gecos.stop(other).result()
    with gecos.actor(other):
        other.dim(1.0).result()


def test_every_object_can_be_pinged_and_described(held: Lamp) -> None:
    gecos.ping(held).result()
    described = gecos.describe(held).result()
    assert described.name == "LAMP"
    assert described.interface_name == "test::Lamp"
    assert described.simulated


def test_a_lease_that_is_dropped_at_once_says_what_to_write(
    lamp: Lamp, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.warns(gecos.DroppedLeaseWarning) as warned:
        gecos.actor(lamp)
    assert str(warned[0].message) == (
        "actor status of LAMP was released at once, before any command was issued under it; "
        "write `with gecos.actor(…):`"
    )
    assert warned[0].filename == __file__
    assert capfd.readouterr().err == ""


def test_a_lease_that_was_used_released_or_entered_is_dropped_in_silence(
    lamp: Lamp, capfd: pytest.CaptureFixture[str]
) -> None:
    lease = gecos.actor(lamp)
    lamp.dim(1.0).result()
    del lease
    gecos.master(lamp).release()
    with gecos.actor(lamp):
        pass
    assert capfd.readouterr().err == ""


def test_a_holder_that_an_older_server_tells_has_not_taken_over() -> None:
    now = Holder(Status.ACTOR, "eva", "lab", "demo", 42, 1.5, 0.25, True, True, 0.5)
    newer = 1 + 8  # the size of `taken_over` and `taken_over_for`
    read = wire.from_bytes(Holder, wire.to_bytes(now)[:-newer])
    assert read == Holder(Status.ACTOR, "eva", "lab", "demo", 42, 1.5, 0.25, True, False, 0.0)
