"""The `gecos` command: lists, shows, reads, sets, calls and stops the objects of a laboratory."""

from __future__ import annotations

import gc
import sys

_PACKAGES = ("click", "numpy", "rich")  # may be missing in an installation without pip

_MANY = 100_000  # allocated objects before a garbage collection


def main() -> int:
    """Runs the command line. `gecos.cli.exit_codes` explains the exit codes."""
    # Imports allocate many objects, of which none is garbage. With the usual threshold, garbage
    # collections take a sixth of the time of a short command.
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
        gc.freeze()  # the process ends, so a garbage collection at its end would be useless
