"""Checks whether the extension gecos._core exists, is complete, and has the version of this
package."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gecos.cli.doctor.finding import Finding, fine, wrong

NEEDED = [
    *("Lab", "Session", "Command", "Stream", "Lease"),
    *("PulledServant", "IncomingCall", "Server", "Broker"),
    *("runtime_directory", "runtime_directory_problem"),
    *("audit_directory", "key_directory", "own_key", "key_problem", "public_key_in"),
    *("broker_in_lab_file", "lab_file_problem", "may_connect"),
    *("warn_of_other_brokers", "detail_name", "log_error"),
]
"""The names in gecos._core that this version of gecos uses."""

_PACKAGES = {
    "libglib-2.0.so.0": "libglib2.0-0",  # needed by LCM, which is part of the extension
    "libsodium.so.23": "libsodium23",
    "libstdc++.so.6": "libstdc++6",
}
_MISSING = re.compile(r"(\S+\.so[.\d]*): cannot open shared object file")
_AGAIN = "pip install --force-reinstall robcl (in a source tree: make)"


def extension(problem: str | None, lacking: Sequence[str], where: str) -> Finding:
    """Checks the extension. `problem` says why gecos._core cannot be imported; None if the import
    succeeds. `lacking` are the names of NEEDED that the extension does not have."""
    missing = _MISSING.search(problem or "")
    if missing:
        package = _PACKAGES.get(missing[1])
        mend = f"sudo apt-get install {package}" if package else f"install {missing[1]}"
        return wrong("extension", f"the library {missing[1]} is missing", where, mend)
    if problem is not None:
        return wrong("extension", f"gecos._core cannot be imported: {problem}", where, _AGAIN)
    if lacking:
        what = f"gecos._core belongs to another version of robcl: it lacks {', '.join(lacking)}"
        return wrong("extension", what, where, _AGAIN)
    return fine("extension", "gecos._core is complete", where)
