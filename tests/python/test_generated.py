"""Generated proxies and servants over the runtime: the laser distance sensor in Python."""

from __future__ import annotations

import gecos
import pytest
from robcl.device import Device
from robcl.frames import Frame
from robcl.laser_distance_sensor import (
    Distance,
    LaserDistanceSensor,
    LaserDistanceSensorServant,
    SensorFault,
)
from robcl.manipulator import Manipulator


class Lds(LaserDistanceSensorServant):
    def __init__(self) -> None:
        self.on = True
        self.carrier, self.offset = "", Frame()

    def base(self) -> Frame:
        return self.offset

    def parent(self) -> str:
        return self.carrier

    def mount(self, carrier: str, offset: Frame) -> None:
        self.carrier, self.offset = carrier, offset

    def beam(self) -> Distance:
        return self.measure()

    def measure(self) -> Distance:
        if not self.on:
            raise SensorFault("the laser is off")
        return Distance(0.25, True, 0.1, 1.0, 100.0)

    def power(self, on: bool) -> None:
        self.on = on


@pytest.fixture
def sensor(lab: gecos.Lab, server: gecos.Server) -> LaserDistanceSensor:
    server.add("LASER", Lds(), simulated=True)
    return lab.create(LaserDistanceSensor, "LASER")


def test_a_call_gives_a_typed_value(sensor: LaserDistanceSensor) -> None:
    assert sensor.measure().result() == Distance(0.25, True, 0.1, 1.0, 100.0)


def test_an_error_is_typed(sensor: LaserDistanceSensor) -> None:
    with gecos.actor(sensor):
        sensor.power(False).result()
    with pytest.raises(SensorFault) as caught:
        sensor.measure().result()
    assert caught.value.reason == "the laser is off"


def test_an_inherited_operation_takes_a_frame(sensor: LaserDistanceSensor) -> None:
    offset = Frame((0.0, 0.0, 0.125))
    with gecos.actor(sensor):
        sensor.mount("RX90", offset).result()
    assert sensor.parent().result() == "RX90"
    assert sensor.base().result() == offset


def test_a_stream_gives_typed_samples(lab: gecos.Lab, server: gecos.Server) -> None:
    servant = Lds()
    server.add("LASER", servant)
    stream = lab.create(LaserDistanceSensor, "LASER").beam.stream()
    servant.publish_beam(Distance(0.5, True, 0.1, 1.0, 7.0), stamp=7.0)
    sample = stream.next(10.0)
    assert sample.value.value == 0.5
    assert sample.stamp == 7.0


def test_a_program_for_the_base_interface_runs_on_the_derived_object(
    lab: gecos.Lab, sensor: LaserDistanceSensor
) -> None:
    device = lab.create(Device, "LASER")
    assert device.base().result() == Frame()
    assert repr(device).startswith("<robcl::LaserDistanceSensor 'LASER'")


def test_assigning_to_a_proxy_says_what_to_call(sensor: LaserDistanceSensor) -> None:
    with pytest.raises(AttributeError, match=r"power cannot be assigned; call the method set_"):
        sensor.power = True  # type: ignore[method-assign, assignment]
    arm = Manipulator(sensor._gecos_session)
    with pytest.raises(AttributeError, match=r"call set_tool_offset\(…\) instead"):
        arm.tool_offset = Frame()  # type: ignore[method-assign, assignment]
