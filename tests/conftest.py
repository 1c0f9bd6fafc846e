"""What holds for every test: none writes into the home of whoever runs it."""

from __future__ import annotations

import atexit
import os
import tempfile

_keys = tempfile.TemporaryDirectory(prefix="gecos-keys-")
atexit.register(_keys.cleanup)
os.environ["GECOS_KEY_DIR"] = _keys.name  # for this process and all that it starts
