"""The verb `gecos explain`."""

from __future__ import annotations

import click

from gecos.cli.options import broker_option, json_option, name_argument, print_json


@click.command()
@name_argument
@broker_option
@json_option
def explain(name: str, broker: str | None, as_json: bool) -> None:
    """Says over which medium a program on this host reaches an object, and why it does not use the
    other media: they do not reach the object, or lack the quality that the interface or a member
    demands."""
    import gecos
    from gecos.dynamic_client.connect import find, interface_of

    with gecos.Lab(broker) as lab:
        told = lab.explain(interface_of(find(lab, name)), name)
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
