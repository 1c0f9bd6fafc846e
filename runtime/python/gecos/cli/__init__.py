"""The `gecos` command: lists, shows, reads, sets, calls and stops the objects of a laboratory."""

from __future__ import annotations

import sys


def main() -> int:
    """Runs the command line. `gecos.cli.exit_codes` explains the exit codes."""
    try:
        from gecos.cli.app import run

        return run()
    except ImportError as error:
        if error.name != "gecos._core":
            raise
        print(f"gecos: {error}", file=sys.stderr)  # it is not built, or for another Python
        return 1
    except KeyboardInterrupt:  # before `run` handles it
        return 130
