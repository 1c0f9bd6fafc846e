"""Finds the folders of interfaces in installed packages.

A package declares its folder of interfaces by an entry point. For example, the wheel `robcl`
declares the folder that contains `robcl/device.gidl`:

    [project.entry-points."gidl.interfaces"]
    robcl = "robcl_interfaces.idl"
"""

from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

GROUP = "gidl.interfaces"


def installed_folders() -> tuple[Path, ...]:
    """Returns the folders of interfaces, sorted by entry point name. Entry points without a folder
    are skipped."""
    found: list[Path] = []
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            spec = find_spec(point.module)
        except ImportError:
            continue
        places = spec.submodule_search_locations if spec is not None else None
        found += [Path(place) for place in places or ()]
    return tuple(found)
