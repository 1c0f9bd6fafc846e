"""Checks RAIL over the medium named: the Python half of the pairs in test_pairs.py."""

import sys

import gecos
from lab.rail_sensor import RailEnd, RailSensor
from robcl.laser_distance_sensor import SensorFault


def check(rail: RailSensor) -> None:
    """Raises AssertionError where something does not hold."""
    with gecos.actor(rail):
        rail.travel(0.0).result()
        assert rail.measure().result().value == 2.0  # a call

        try:
            rail.travel(10.0).result()  # a declared exception
        except RailEnd as end:
            assert end.limit == 1.0
        else:
            raise AssertionError("travel(10) must raise RailEnd")

        beam = rail.beam.stream()
        ride = rail.travel(1.0)
        before, sequence = 2.0 + 1e-9, 0
        for _ in range(20):  # a stream, read while it moves
            sample = beam.next(2.0)
            assert sample is not None
            assert sample.sequence > sequence
            assert sample.value.value <= before
            before, sequence = sample.value.value, sample.sequence
        between = rail.measure().result()  # a sensor call is answered meanwhile
        assert 1.0 < between.value < 2.0
        assert ride.state is gecos.State.RUNNING
        progress = ride.progress()
        assert progress.detail is gecos.Detail.EXECUTING
        assert 0.0 < progress.fraction < 1.0
        ride.result()
        assert ride.state is gecos.State.FINISHED
        assert rail.measure().result().value == 1.0

        rail.power(False).result()
        try:
            rail.measure().result()
        except SensorFault:
            pass
        else:
            raise AssertionError("measure() with the laser off must raise SensorFault")
        finally:
            rail.power(True).result()


if __name__ == "__main__":
    medium = sys.argv[1]
    check(gecos.Lab().create(RailSensor, "RAIL", medium=medium))
    print(f"all held over {medium}")
