"""An operation or stream whose own `@qos` the medium does not meet is refused before it is sent."""

from __future__ import annotations

import gecos
import pytest
from gecos.interface import Media, Quality, QualityClass, Reliability
from gecos.record import replace
from lamp import LAMP, Lamp, PlainLamp

HERE_ALONE = Quality(media=Media.SHM)


class DemandingLamp(Lamp):
    """Asks for the label, and for samples of the level, over shared memory alone."""

    _gecos_interface = replace(
        LAMP,
        operations=tuple(
            replace(operation, quality=HERE_ALONE) if operation.name == "label" else operation
            for operation in LAMP.operations
        ),
        streams=tuple(replace(stream, quality=HERE_ALONE) for stream in LAMP.streams),
    )


@pytest.mark.usefixtures("server")
def test_over_another_medium_it_ends_at_once_and_the_rest_works(lab: gecos.Lab) -> None:
    lamp = lab.create(DemandingLamp, "LAMP", medium="lcm")
    refused = lamp.label()
    assert refused.state is gecos.State.CONNECTION_FAILED
    assert str(refused.exception()) == (
        "QOS_UNAVAILABLE: 'label' of LAMP was not sent over lcm: media=shm: lcm is not one of "
        "these media; create the proxy over another medium"
    )
    with pytest.raises(gecos.ConnectionFailed, match=r"^QOS_UNAVAILABLE: .*media=shm: "):
        lamp.level.stream()
    with gecos.actor(lamp):
        assert lamp.dim(0.25).result() == 0.0


@pytest.mark.usefixtures("server")
def test_over_a_medium_that_meets_it_all_is_well(lab: gecos.Lab) -> None:
    lamp = lab.create(DemandingLamp, "LAMP", medium="shm")
    assert lamp.label().result() == "a lamp"
    lamp.level.stream().close()


class ReliableLamp(Lamp):
    """No sample of its level may be lost on the way."""

    _gecos_interface = replace(
        LAMP,
        streams=tuple(
            replace(stream, quality=Quality(reliability=Reliability.RELIABLE))
            for stream in LAMP.streams
        ),
    )


@pytest.mark.usefixtures("server")
def test_a_stream_that_must_lose_no_sample_is_refused_over_lcm_and_its_getter_works(
    lab: gecos.Lab,
) -> None:
    lamp = lab.create(ReliableLamp, "LAMP", medium="lcm")
    with pytest.raises(gecos.ConnectionFailed) as refused:
        lamp.level.stream()
    assert str(refused.value) == (
        "QOS_UNAVAILABLE: LAMP.level: 'level' of LAMP was not opened over lcm: "
        "reliability=RELIABLE: the medium lcm may lose samples, and nothing retransmits them; "
        "create the proxy over another medium"
    )
    assert lamp.level().result() == 0.0


@pytest.mark.usefixtures("server")
@pytest.mark.parametrize("medium", ["inproc", "shm"])
def test_a_stream_that_must_lose_no_sample_is_read_over_memory(
    lab: gecos.Lab, servant: PlainLamp, medium: str
) -> None:
    lamp = lab.create(ReliableLamp, "LAMP", medium=medium)
    with lamp.level.stream() as stream:
        servant.publish_level(0.5)
        assert stream.next(10.0).value == 0.5


@pytest.mark.usefixtures("server")
def test_explain_says_that_only_the_samples_are_refused(lab: gecos.Lab) -> None:
    told = lab.explain(ReliableLamp, "LAMP")
    by_name = {each.medium: each for each in told.media}
    assert not by_name["shm"].members
    assert [(each.name, each.samples_only) for each in by_name["lcm"].members] == [("level", True)]
    assert (
        "    not the samples of level: reliability=RELIABLE: the medium lcm may lose samples, and "
        "nothing retransmits them"
    ) in str(told)


class RealTimeLamp(Lamp):
    _gecos_interface = replace(LAMP, quality=Quality(line=QualityClass.HARD_REALTIME))


class LampOverCan(Lamp):
    _gecos_interface = replace(LAMP, quality=Quality(media=Media.CAN))


@pytest.mark.usefixtures("server")
def test_explain_says_what_speaks_against_each_medium(lab: gecos.Lab) -> None:
    told = lab.explain(Lamp, "LAMP")
    assert (told.name, told.interface_name, told.simulated) == ("LAMP", LAMP.name, True)
    best = told.media[0]
    assert best.suitable and not best.members
    assert lab.create(Lamp, "LAMP")._gecos_session.medium == best.medium
    lcm = next(each for each in told.media if each.medium == "lcm")
    assert lcm.suitable and "  lcm: used if no medium above it answers" in str(told)

    told = lab.explain(LampOverCan, "LAMP")
    assert not any(each.suitable for each in told.media)
    assert "  lcm: media=can: lcm is not one of these media" in str(told)


@pytest.mark.usefixtures("server")
def test_explain_names_the_members_that_a_medium_does_not_suit(lab: gecos.Lab) -> None:
    told = lab.explain(DemandingLamp, "LAMP")
    by_name = {each.medium: each for each in told.media}
    assert not by_name["shm"].members
    assert {each.name for each in by_name["lcm"].members} == {"label", "level"}
    assert "    not label: media=shm: lcm is not one of these media" in str(told)


@pytest.mark.usefixtures("server")
def test_real_time_of_a_simulated_lamp_is_soft(lab: gecos.Lab) -> None:
    """A simulated device is not harmed by a late packet."""
    assert all(
        each.suitable or each.unreachable for each in lab.explain(RealTimeLamp, "LAMP").media
    )


@pytest.mark.usefixtures("server")
def test_explain_fails_as_create_does(lab: gecos.Lab) -> None:
    with pytest.raises(gecos.CreateError, match="NOBODY: NO_SERVER"):
        lab.explain(Lamp, "NOBODY")
