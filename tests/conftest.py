"""What holds for every test: none writes into the home of whoever runs it, and Ctrl-C is what it is
at a terminal, also where the tests run in the background of a shell, which ignores it. And a test
that plays what people see in real time begins again if the machine stood still."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
sys.path.append(str(TESTS / "stress"))  # lateness.py

from lateness import Watch, now_ns  # noqa: E402

_keys = tempfile.TemporaryDirectory(prefix="gecos-keys-")
atexit.register(_keys.cleanup)
os.environ["GECOS_KEY_DIR"] = _keys.name  # for this process and all that it starts
_audit = tempfile.TemporaryDirectory(prefix="gecos-audit-", ignore_cleanup_errors=True)
atexit.register(_audit.cleanup)
os.environ["GECOS_AUDIT_DIR"] = _audit.name

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # programs that are started would inherit it
    signal.signal(signal.SIGINT, signal.default_int_handler)


IN_REAL_TIME = (TESTS / "docs", TESTS / "system")
STOOD_STILL_S = 0.2
"""An arm whose server stands still for 0.5 s ends its motion, and the programs of the lessons stop
it when their newest sample is older than 0.2 s: both are right, and not what the test waits for."""


class Machine:
    """True when the machine has not run one of its cores for so long since the test began. A test
    that fails on a machine that ran is not run again."""

    def __init__(self) -> None:
        self._watch = Watch()
        self._watches = False
        self._began = 0

    def begin(self) -> None:
        if not self._watches:
            self._watch.__enter__()
            self._watches = True
        self._began = now_ns()

    def __bool__(self) -> bool:
        return self._watch.longest_s(self._began) > STOOD_STILL_S


_machine = Machine()


def pytest_collection_modifyitems(items: Iterable[pytest.Item]) -> None:
    for item in items:
        if any(item.path.is_relative_to(folder) for folder in IN_REAL_TIME):
            item.add_marker(pytest.mark.flaky(reruns=2, condition=_machine))


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("flaky"):
        _machine.begin()
