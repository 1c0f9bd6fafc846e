"""The verb `gecos explain`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import click

from gecos.cli.options import broker_option, json_option, name_argument, print_json

if TYPE_CHECKING:
    from gecos import CreateError, Explanation, Lab, Object

# The limit for the round trip in s that is passed to `create`. With a limit, `create` measures the
# round trip; the limit is so long that no medium is refused.
_ANY_LATENCY = 3600.0


@dataclass(frozen=True, slots=True)
class RoundTrips:
    """The media that were tried. `not_reached` has the reason why no session can be opened over a
    medium, for example because the server does not admit the key of this user, or because the
    medium is too slow for the interface."""

    measured: dict[str, float] = field(default_factory=dict)  # in s
    not_reached: dict[str, str] = field(default_factory=dict)


def round_trips(lab: Lab, interface: type[Object], told: Explanation) -> RoundTrips:
    """Measures the round trip over each suitable medium of an object."""
    import gecos

    tried = RoundTrips()
    for each in told.media:
        if each.suitable:
            try:
                proxy = lab.create(interface, told.name, medium=each.medium, latency=_ANY_LATENCY)
            except gecos.CreateError as error:
                tried.not_reached[each.medium] = _reasons(error)
            else:
                tried.measured[each.medium] = gecos.line_state(proxy).round_trip or 0.0
    return tried


def _reasons(error: CreateError) -> str:
    return "; ".join(attempt.reason for attempt in error.attempts)


@click.command()
@name_argument
@broker_option
@click.option("--measure", is_flag=True, help="Also measure the round trip over each medium.")
@json_option
def explain(name: str, broker: str | None, measure: bool, as_json: bool) -> None:
    """Says over which medium a program on this host reaches an object, and why the program does not
    use the other media. A medium may not reach the object, or may lack a quality that the interface
    or a member of the interface demands."""
    import gecos
    from gecos.dynamic_client.connect import find, interface_of

    with gecos.Lab(broker) as lab:
        interface = interface_of(find(lab, name))
        told = lab.explain(interface, name)
        tried = round_trips(lab, interface, told) if measure else RoundTrips()
    if as_json:
        print_json(
            {
                "name": told.name,
                "type": told.interface_name,
                "hostname": told.hostname,
                "simulated": told.simulated,
                "media": [
                    {
                        "medium": each.medium,
                        "address": each.address,
                        "suitable": each.suitable,
                        "reason": each.reason,
                        "real_time_by": each.real_time_by,
                        "round_trip": tried.measured.get(each.medium),
                        "not_reached": tried.not_reached.get(each.medium),
                        "members": [
                            {
                                "name": member.name,
                                "reason": member.reason,
                                "samples_only": member.samples_only,
                            }
                            for member in each.members
                        ],
                    }
                    for each in told.media
                ],
            }
        )
    else:
        from gecos.cli import report

        print(report.printable(str(told)))
        for medium, round_trip in tried.measured.items():
            print(f"  measured over {medium}: {round_trip * 1e3:.3g} ms")
        for medium, reason in tried.not_reached.items():
            print(report.printable(f"  {medium}: not reached: {reason}"))
