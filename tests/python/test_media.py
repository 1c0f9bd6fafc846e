"""`@qos(media=…)` of an interface decides which medium `create` takes."""

from __future__ import annotations

import gecos
import pytest
from gecos.interface import Media, Quality
from gecos.record import replace
from lamp import Lamp


def over(media: Media) -> type[Lamp]:
    """The lamp's interface as if its file said `@qos(media=…)`."""
    table = replace(Lamp._gecos_interface, quality=Quality(media=media))
    return type("Lamp", (Lamp,), {"_gecos_interface": table})


@pytest.mark.parametrize(
    ("media", "taken"),
    [
        (Media(0), "inproc"),
        (Media.LCM, "lcm"),
        (Media.SHM, "inproc"),  # one process is as good as its shared memory
        (Media.SHM | Media.CAN, "inproc"),
        (Media.LCM | Media.TCP, "lcm"),
    ],
)
def test_the_best_that_is_named_is_taken(
    lab: gecos.Lab, server: gecos.Server, media: Media, taken: str
) -> None:
    lamp = lab.create(over(media), "LAMP")
    assert repr(lamp).endswith(f"over {taken}>")


def test_each_medium_is_refused_by_the_term(lab: gecos.Lab, server: gecos.Server) -> None:
    with pytest.raises(gecos.CreateError) as refused:
        lab.create(over(Media.TCP | Media.CAN), "LAMP")
    text = str(refused.value)
    for medium in ("inproc", "shm", "lcm"):
        assert f"media=tcp|can: {medium} is not one of these media" in text
    assert "QOS_UNAVAILABLE" in text
