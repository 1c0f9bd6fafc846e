"""The `gecos` command: lists, shows, reads, sets, calls and stops the objects of a laboratory."""

from __future__ import annotations


def main() -> int:
    """Runs the command line. `gecos.cli.exit_codes` explains the exit codes."""
    try:
        from gecos.cli.app import run

        return run()
    except KeyboardInterrupt:  # before `run` handles it
        return 130
