"""`gidl new`: writes the first files of a new device, or with --mock the first files of a mock
server."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from gidl.cli.scaffold import ScaffoldRefusal, write_device, write_mock
from gidl.cli.shared import FINDINGS, FINE, USAGE, add_reading, compiled_from, settle, show
from gidl.diagnostics.findings import Findings


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    new = verbs.add_parser(
        "new", help="write the first files of a device (interface, server, client) or a mock server"
    )
    new.add_argument("name", nargs="?", help="name of the device, for example thermometer")
    new.add_argument("--into", type=Path, help="folder to create; default: the name of the device")
    new.add_argument(
        "--mock",
        metavar="FILE",
        help="write a mock server for the interfaces of FILE, not a device",
    )
    new.add_argument(
        "--lang", choices=("cpp", "python"), default="python", help="language of the mock"
    )
    new.add_argument(
        "--interface", metavar="NAME", help="interface to mock; default: all interfaces of FILE"
    )
    add_reading(new)
    new.set_defaults(command=_new, error_format="text", prints=False, settles=False)


def _new(chosen: argparse.Namespace) -> int:
    if (chosen.name is None) == (chosen.mock is None) or chosen.mock == "-":
        print(
            "gidl: write the name of the device, for example thermometer, or --mock and a file",
            file=sys.stderr,
        )
        return USAGE
    try:
        if chosen.mock is not None:
            return _mock(chosen)
        print(write_device(chosen.name, chosen.into))
    except ScaffoldRefusal as refusal:
        print(f"gidl: {refusal}", file=sys.stderr)
        return USAGE
    return FINE


def _mock(chosen: argparse.Namespace) -> int:
    from gidl.targets.emit import UnsupportedError

    chosen.files = [chosen.mock]
    if not settle(chosen):
        return USAGE
    compiled = compiled_from(chosen, chosen.files)
    findings = Findings(list(compiled.findings))
    told = ""
    if not compiled.has_errors:
        try:
            told = write_mock(compiled, chosen.lang, chosen.interface, chosen.into, chosen.search)
        except UnsupportedError as problem:
            findings.error("G0801", problem.location, problem.text)
    show(chosen, findings.found, compiled.sources)
    if findings.has_errors:
        return FINDINGS
    print(told)
    return FINE
