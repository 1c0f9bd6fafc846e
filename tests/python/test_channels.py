"""Channels that a program names in `create`: one for what comes in, one for what goes out."""

from __future__ import annotations

import gecos
import pytest
from lamp import Lamp, PlainLamp


@pytest.mark.usefixtures("server")
def test_samples_come_in_over_one_medium_and_calls_go_out_over_another(
    lab: gecos.Lab, servant: PlainLamp
) -> None:
    lamp = lab.create(Lamp, "LAMP", in_="shm", out="lcm")
    assert gecos.line_state(lamp).medium == "lcm"
    with gecos.actor(lamp), lamp.level.stream() as level:
        assert lamp.dim(0.25).result() == 0.0
        servant.publish_level(0.5)
        assert level.next(10.0).value == 0.5


@pytest.mark.parametrize(("in_", "out"), [("lcm", None), (None, "lcm")])
def test_a_channel_that_is_impossible_is_refused_although_others_exist(
    lab: gecos.Lab, servant: PlainLamp, in_: str | None, out: str | None
) -> None:
    with gecos.Server(lab) as server:
        server.add("LAMP", servant, simulated=True, media=["inproc", "shm"])
        with pytest.raises(gecos.CreateError) as refused:
            lab.create(Lamp, "LAMP", in_=in_, out=out)
        assert str(refused.value) == (
            f"LAMP: QOS_UNAVAILABLE: LAMP ({'in' if in_ else 'out'}=lcm) cannot be reached over "
            "lcm: the server does not offer this medium; use inproc, shm"
        )


@pytest.mark.usefixtures("server")
def test_a_channel_must_be_a_medium(lab: gecos.Lab) -> None:
    with pytest.raises(ValueError, match=r"^no medium is called 'radio'; choose inproc, shm"):
        lab.create(Lamp, "LAMP", in_="radio")
