"""The `gecos` command: lists objects, shows their states and holders, stops them."""

from __future__ import annotations


def main() -> int:
    """Runs the command line. Exit code 0: success, 1: the command failed, 2: wrong usage."""
    from gecos.cli.app import run

    return run()
