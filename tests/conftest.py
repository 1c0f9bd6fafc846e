"""What holds for every test: none writes into the home of whoever runs it, and Ctrl-C is what it is
at a terminal, also where the tests run in the background of a shell, which ignores it."""

from __future__ import annotations

import atexit
import os
import signal
import tempfile

_keys = tempfile.TemporaryDirectory(prefix="gecos-keys-")
atexit.register(_keys.cleanup)
os.environ["GECOS_KEY_DIR"] = _keys.name  # for this process and all that it starts
_audit = tempfile.TemporaryDirectory(prefix="gecos-audit-", ignore_cleanup_errors=True)
atexit.register(_audit.cleanup)
os.environ["GECOS_AUDIT_DIR"] = _audit.name

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # programs that are started would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)
