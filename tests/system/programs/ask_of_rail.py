"""Holds RAIL, lets it ride, and goes on as the lines say that it reads: one answer for each."""

import sys

import gecos
from lab.rail_sensor import RailSensor

rail = gecos.Lab().create(RailSensor, "RAIL", medium=sys.argv[1])
lease = gecos.actor(rail)


def say(line: str) -> None:
    """In one write: the library writes warnings to the same pipe meanwhile."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def told(command: gecos.Command[object]) -> str:
    command.wait()
    error = command.exception()
    return f"{command.state.name}/{command.progress().detail.name}: {error}"


ride = rail.travel(1.0)
while ride.wait(0.01) is gecos.State.RUNNING and ride.progress().fraction == 0.0:
    pass
say(f"rides {ride!r}")
for line in sys.stdin:
    match line.strip():
        case "ride":
            say(f"ride {told(ride)}")
        case "move":
            say(f"move {told(rail.travel(0.5))}")
        case "read":
            say(f"read {told(rail.measure())}")
        case "stop":
            say(f"stop {told(gecos.stop(rail))}")
        case "name":
            say(f"name {gecos.describe(rail).result().registration}")
        case "hold":
            try:
                lease = gecos.actor(rail)
                say("hold granted")
            except gecos.LeaseRefused as refused:
                say(f"hold refused: {refused}")
