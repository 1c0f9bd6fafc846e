"""The verb `gecos ls`."""

from __future__ import annotations

import click

from gecos.cli.options import broker_option, interfaces, json_option, print_json


@click.command()
@click.option(
    "--interface",
    metavar="NAME",
    default="",
    help="Only objects that have this interface or a derived one, e.g. robcl::Manipulator.",
    shell_complete=interfaces,
)
@click.option("--watch", "watching", is_flag=True, help="Print each change until Ctrl-C.")
@broker_option
@json_option
def ls(interface: str, watching: bool, broker: str | None, as_json: bool) -> None:
    """Lists the objects that are online, and those whose servers are silent."""
    import gecos
    from gecos.cli.presence import changes, presences

    with gecos.Lab(broker) as lab:
        if watching:
            for change in changes(lab, interface):
                if as_json:
                    print_json(change)
                else:
                    from gecos.cli import report

                    report.change(change)
            return
        found = presences(lab, interface)
    if as_json:
        print_json([one.as_json() for one in found])
    else:
        from gecos.cli import report

        report.objects(found)
