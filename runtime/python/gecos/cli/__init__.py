"""The `gecos` command: what is online, what state it is in, who moves it, and stop."""

from __future__ import annotations


def main() -> int:
    """Runs the command line. Exit code 0: done, 1: it could not be done, 2: wrong usage."""
    from gecos.cli.app import run

    return run()
