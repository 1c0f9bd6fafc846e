"""Holds RAIL, lets it ride, and goes on as the lines say that it reads: one answer for each."""

import sys

import gecos
from lab.rail_sensor import RailSensor

rail = gecos.Lab().create(RailSensor, "RAIL", medium=sys.argv[1])
lease = gecos.actor(rail)


def told(command: gecos.Command[object]) -> str:
    command.wait()
    error = command.exception()
    return f"{command.state.name}/{command.progress().detail.name}: {error}"


ride = rail.travel(1.0)
while ride.wait(0.01) is gecos.State.RUNNING and ride.progress().fraction == 0.0:
    pass
print(f"rides {ride!r}", flush=True)
for line in sys.stdin:
    match line.strip():
        case "ride":
            print("ride", told(ride), flush=True)
        case "move":
            print("move", told(rail.travel(0.5)), flush=True)
        case "read":
            print("read", told(rail.measure()), flush=True)
        case "stop":
            print("stop", told(gecos.stop(rail)), flush=True)
        case "name":
            print("name", gecos.describe(rail).result().registration, flush=True)
        case "hold":
            try:
                lease = gecos.actor(rail)
                print("hold granted", flush=True)
            except gecos.LeaseRefused as refused:
                print(f"hold refused: {refused}", flush=True)
