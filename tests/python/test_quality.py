"""An operation or stream whose own `@qos` the medium does not meet is refused before it is sent."""

from __future__ import annotations

import gecos
import pytest
from gecos.interface import Media, Quality
from gecos.record import replace
from lamp import LAMP, Lamp

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
