"""Stands for the dead-man button of a person in the laboratory: reports that it is held, until
someone presses Return. A silent button counts as released after 1 s, so a report is repeated.
"""

import select
import sys

import gecos
from gecos_idl.presence import Zone


def main() -> None:
    zone = gecos.Lab().create(Zone, "CELL")
    zone.report_button("BUTTON", True).result()
    print("the button is held", flush=True)
    while not select.select([sys.stdin], [], [], 0.3)[0]:
        zone.report_button("BUTTON", True).result()
    zone.report_button("BUTTON", False).result()
    print("the button is released")


if __name__ == "__main__":
    try:
        main()
    except (gecos.CommandFailed, ConnectionError) as failed:  # no CELL, or who may not report
        sys.exit(str(failed))
