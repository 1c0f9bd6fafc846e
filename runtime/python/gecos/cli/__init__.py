"""The `gecos` command: lists objects, shows their states and holders, stops them."""

from __future__ import annotations


def main() -> int:
    """Runs the command line. Exit code 0: done, 1: it could not be done, 2: wrong usage."""
    from gecos.cli.app import run

    return run()
