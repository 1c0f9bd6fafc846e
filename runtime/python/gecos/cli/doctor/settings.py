"""Checks whether the GECOS_* variables are known and valid."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches

from gecos.cli.doctor.finding import Finding, fine, warning, wrong

_FOR_PROGRAMS = (
    *("GECOS_BROKER", "GECOS_RUNTIME_DIR", "GECOS_LAB_FILE"),
    *("GECOS_LCM_TTL", "GECOS_LOG", "GECOS_KEY_DIR", "GECOS_AUDIT_DIR"),
)
_MENDS = {
    "GECOS_LCM_TTL": "export GECOS_LCM_TTL=1 (unset GECOS_LCM_TTL where all programs run on one "
    "host)",
}
_FOR_THE_TREE = ("GECOS_PYTHON", "GECOS_BUILD", "GECOS_WERROR", "GECOS_HOSTILE_PACKETS")


def refused(variable: str, reason: str) -> Finding:
    """Returns the finding for a variable whose value the runtime refuses for `reason`. `variable`
    is empty if the reason names no variable."""
    if not variable:
        return wrong("settings", reason, "GECOS_*", "unset the variables that begin with GECOS_")
    return wrong("settings", reason, variable, _MENDS.get(variable, f"unset {variable}"))


def unknown(environment: Mapping[str, str]) -> list[Finding]:
    """Returns findings for variables that look like settings of gecos, but that no program
    reads."""
    found = []
    for name in sorted(environment):
        if not name.startswith("GECOS_") or name in _FOR_PROGRAMS + _FOR_THE_TREE:
            continue
        near = get_close_matches(name, _FOR_PROGRAMS, n=1)
        what = "no program reads this variable" + (f"; did you mean {near[0]}?" if near else "")
        mend = f"unset {name}" if not near else f'export {near[0]}="${name}"; unset {name}'
        found.append(warning("settings", what, name, mend))
    return found


def accepted(environment: Mapping[str, str]) -> Finding:
    given = [name for name in _FOR_PROGRAMS if environment.get(name)]
    return fine(
        "settings",
        "valid" if given else "no variable is set; all settings have their defaults",
        ", ".join(given),
    )
