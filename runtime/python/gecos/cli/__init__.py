"""The `gecos` command: lists, shows, reads, sets, calls and stops the objects of a laboratory."""

from __future__ import annotations

import gc
import sys

_PACKAGES = ("click", "numpy", "rich")  # what an installation without pip may lack

_MANY = 100_000  # objects to allocate before a collection; a command that runs long has collections


def main() -> int:
    """Runs the command line. `gecos.cli.exit_codes` explains the exit codes."""
    # Imports allocate much and leave nothing to collect. With the usual threshold, collections take
    # a sixth of the time of a short command.
    gc.set_threshold(_MANY)
    try:
        from gecos.cli.app import run

        return run()
    except ImportError as error:
        if error.name in _PACKAGES:
            missing = error.name
            print(
                f"gecos: the Python package {missing} is missing; install it, for example by "
                f"`pip install {missing}` or `apt-get install python3-{missing}`",
                file=sys.stderr,
            )
        elif error.name == "gecos._core":  # not built, or built for another Python
            print(f"gecos: {error}", file=sys.stderr)
        else:
            raise
        return 1
    except KeyboardInterrupt:  # Ctrl-C before `run` handles it
        return 130
    finally:
        gc.freeze()  # the process ends: Python need not look for garbage in what was imported
