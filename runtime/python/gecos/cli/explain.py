"""The verb `gecos explain`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gecos.cli.options import broker_option, json_option, name_argument, print_json

if TYPE_CHECKING:
    from gecos import Explanation, Lab, Object

_ANY_LATENCY = 3600.0  # s; asks `create` for a measurement, and refuses no medium


def round_trips(lab: Lab, interface: type[Object], told: Explanation) -> dict[str, float]:
    """Returns the round trip in s over each suitable medium of an object. Raises CreateError if no
    session can be opened over one of these media, or if a medium is too slow for the interface."""
    import gecos

    measured = {}
    for each in told.media:
        if each.suitable:
            proxy = lab.create(interface, told.name, medium=each.medium, latency=_ANY_LATENCY)
            measured[each.medium] = gecos.line_state(proxy).round_trip or 0.0
    return measured


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
        measured = round_trips(lab, interface, told) if measure else {}
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
                        "round_trip": measured.get(each.medium),
                        "members": [
                            {"name": member.name, "reason": member.reason}
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
        for medium, round_trip in measured.items():
            print(f"  measured over {medium}: {round_trip * 1e3:.3g} ms")
