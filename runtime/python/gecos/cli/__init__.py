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
        # The extension is not built, or is built for another Python.
        print(f"gecos: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:  # Ctrl-C before `run` handles it
        return 130
