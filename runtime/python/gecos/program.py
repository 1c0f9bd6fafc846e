"""What this program is called, for those who ask who holds a robot."""

from __future__ import annotations

import sys
from pathlib import Path


def program_name() -> str:
    """The script's file name, or the module's name under `python -m`, else "python"."""
    spec = getattr(sys.modules.get("__main__"), "__spec__", None)
    if spec is not None and spec.name != "__main__":  # which a folder or archive has
        return str(spec.name).removesuffix(".__main__")
    name = Path(sys.argv[0]).name if sys.argv else ""
    if name in ("", "-", "-c"):
        return "python"
    return name.encode(errors="replace").decode()
