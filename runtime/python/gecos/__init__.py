"""gecos: asynchronous, access-controlled calls to robots and sensors.

    lab = gecos.Lab()
    robot = lab.create(Manipulator, ["RX90", "SIM"])
    with gecos.actor(robot):
        move = robot.move(goal)
        move.result()

Names are imported at first use: `gecos.wire` and generated types work without the C++ extension.
"""

from __future__ import annotations

import sys as _sys
from importlib import import_module
from typing import TYPE_CHECKING, Any


def _check_python() -> None:
    if _sys.version_info < (3, 11):  # noqa: UP036  # a source tree is used without an installer
        raise ImportError(
            f"gecos needs Python 3.11 or newer, and {_sys.executable} is Python "
            f"{_sys.version_info[0]}.{_sys.version_info[1]}; run the program with a newer Python"
        )


_check_python()

if TYPE_CHECKING:
    from gecos.broker import Broker as Broker
    from gecos.builtin_operations import Outcome as Outcome
    from gecos.builtin_operations import break_status as break_status
    from gecos.builtin_operations import deny as deny
    from gecos.builtin_operations import describe as describe
    from gecos.builtin_operations import give_back as give_back
    from gecos.builtin_operations import holders as holders
    from gecos.builtin_operations import model as model
    from gecos.builtin_operations import outcome as outcome
    from gecos.builtin_operations import ping as ping
    from gecos.builtin_operations import requests as requests
    from gecos.builtin_operations import roster as roster
    from gecos.builtin_operations import stats as stats
    from gecos.builtin_operations import stop as stop
    from gecos.builtin_operations import take_over as take_over
    from gecos.command import Command as Command
    from gecos.command import Progress as Progress
    from gecos.dynamic_client import DynamicObject as DynamicObject
    from gecos.dynamic_client import ModelError as ModelError
    from gecos.dynamic_client.connect import dynamic as dynamic
    from gecos.errors import Attempt as Attempt
    from gecos.errors import CommandFailed as CommandFailed
    from gecos.errors import ConnectionFailed as ConnectionFailed
    from gecos.errors import CreateError as CreateError
    from gecos.errors import DeadlineMissed as DeadlineMissed
    from gecos.errors import DeclaredError as DeclaredError
    from gecos.errors import Detail as Detail
    from gecos.errors import DroppedLeaseWarning as DroppedLeaseWarning
    from gecos.errors import Interrupted as Interrupted
    from gecos.errors import LeaseRefused as LeaseRefused
    from gecos.errors import Rejected as Rejected
    from gecos.errors import ServeError as ServeError
    from gecos.errors import State as State
    from gecos.errors import StreamLost as StreamLost
    from gecos.errors import StreamRevoked as StreamRevoked
    from gecos.errors import UnobservedCommandWarning as UnobservedCommandWarning
    from gecos.execution import Caller as Caller
    from gecos.execution import Execution as Execution
    from gecos.in_place import Loan as Loan
    from gecos.in_place import SampleInPlace as SampleInPlace
    from gecos.inward import Inward as Inward
    from gecos.inward import InwardSample as InwardSample
    from gecos.lab import Lab as Lab
    from gecos.lease import Lease as Lease
    from gecos.lease import actor as actor
    from gecos.lease import master as master
    from gecos.line import LineState as LineState
    from gecos.line import LineWatch as LineWatch
    from gecos.line import line_state as line_state
    from gecos.listener import Listener as Listener
    from gecos.object_watch import ObjectWatch as ObjectWatch
    from gecos.proxy import Event as Event
    from gecos.proxy import Object as Object
    from gecos.proxy import StreamAttribute as StreamAttribute
    from gecos.proxy import reference as reference
    from gecos.proxy import with_deadline as with_deadline
    from gecos.reconnecting import Reconnecting as Reconnecting
    from gecos.reconnecting_stream import ReconnectingStream as ReconnectingStream
    from gecos.servant import Servant as Servant
    from gecos.server import Server as Server
    from gecos.server import serve as serve
    from gecos.stream import Sample as Sample
    from gecos.stream import Stream as Stream
    from gecos.stream import StreamCounts as StreamCounts
    from gecos.writer import InwardAttribute as InwardAttribute
    from gecos.writer import Writer as Writer

_NAMES = {
    "broker": "Broker",
    "command": "Command Progress",
    "dynamic_client": "DynamicObject ModelError",
    "dynamic_client.connect": "dynamic",
    "errors": "Attempt CommandFailed ConnectionFailed CreateError DeadlineMissed DeclaredError "
    "Detail DroppedLeaseWarning Interrupted LeaseRefused Rejected ServeError State StreamLost "
    "StreamRevoked UnobservedCommandWarning",
    "execution": "Caller Execution",
    "in_place": "Loan SampleInPlace",
    "inward": "Inward InwardSample",
    "lab": "Lab",
    "lease": "Lease actor master",
    "line": "LineState LineWatch line_state",
    "listener": "Listener",
    "object_watch": "ObjectWatch",
    "proxy": "Event Object StreamAttribute reference with_deadline",
    "builtin_operations": "Outcome break_status deny describe give_back holders model outcome ping "
    "requests roster stats stop take_over",
    "reconnecting": "Reconnecting",
    "reconnecting_stream": "ReconnectingStream",
    "servant": "Servant",
    "server": "Server serve",
    "stream": "Sample Stream StreamCounts",
    "writer": "InwardAttribute Writer",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    if name == "_core":
        return _extension()
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'gecos' has no attribute {name!r}")
    value = getattr(import_module(f"gecos.{home}"), name)
    globals()[name] = value
    return value


def _extension() -> Any:
    """Returns the C++ part of gecos. If it is missing or built for another Python, raises
    ImportError, whose text says what to do."""
    try:
        return import_module("gecos._core")
    except ModuleNotFoundError as error:
        if error.name != "gecos._core":
            raise
    from pathlib import Path

    folder, this = Path(__file__).parent, f"{_sys.version_info[0]}.{_sys.version_info[1]}"
    built = sorted(each.name for each in folder.glob("_core.*.so"))
    if built:
        text = (
            f"{folder} has {', '.join(built)}, which is built for another Python than this "
            f"one, {this}"
        )
        advice = (
            f"run the program with the Python for which gecos was built, or build gecos with {this}"
        )
    else:
        text = f"the C++ part of gecos is not built: {folder} has no _core.*.so"
        advice = "run `make build` in the source tree, or `pip install robcl`"
    raise ImportError(f"{text}; {advice}", name="gecos._core")


def __dir__() -> list[str]:
    return sorted(_HOME)
