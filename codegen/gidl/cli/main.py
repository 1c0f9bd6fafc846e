"""The command line: `gidl gen | check | lint | fmt | breaking | dump | new | explain`.

Exit status: 0 success, 1 gidl could not run, 2 wrong usage, 100 findings.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from gidl import __version__
from gidl.cli import breaking, fmt, gen, lint, new
from gidl.cli.shared import (
    FAILED,
    FINDINGS,
    FINE,
    USAGE,
    add_except,
    add_files,
    compiled_from,
    files_of,
    settle,
    show,
    strictly,
)
from gidl.compile import Compiled
from gidl.diagnostics.findings import Finding, Findings
from gidl.rules import no_effect


def run() -> None:
    """Runs the installed command `gidl`."""
    sys.exit(main(sys.argv[1:]))


def main(arguments: Sequence[str]) -> int:
    """Runs one command and returns its exit status."""
    _replace_closed_streams()
    try:
        status = _status(arguments)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        _no_more_output()
        return FAILED
    except OSError as problem:
        name = problem.filename
        if name is None:  # an OSError without a file name comes from stdout
            name = "standard output"
            _no_more_output()
        print(f"gidl: {name}: {problem.strerror or problem}", file=sys.stderr)
        return FAILED
    except RecursionError:
        print(
            "gidl: declarations refer to each other in a chain that is too long; shorten the chain",
            file=sys.stderr,
        )
        return FAILED
    except KeyboardInterrupt:
        return FAILED


def _status(arguments: Sequence[str]) -> int:
    parser = _parser()
    try:
        chosen = parser.parse_args(arguments)
        chosen.words = tuple(arguments)
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else USAGE
    try:
        if chosen.command is not _explain:
            _find_current_folder()
        if chosen.settles and not settle(chosen):
            return USAGE
        command: Callable[[argparse.Namespace], int] = chosen.command
        return command(chosen)
    except OSError as problem:
        if problem.filename is None or vars(chosen).get("error_format", "text") == "text":
            raise
        show(chosen, [_not_usable(problem)], {})
        return FAILED


def _not_usable(problem: OSError) -> Finding:
    """Returns the finding for a file or folder that the operating system does not let gidl use.
    JSON, SARIF and GitHub reports contain this finding; a text report does not."""
    findings = Findings()
    findings.file_error(
        "G0001",
        Path(str(problem.filename)).as_posix(),
        f"this path cannot be used: {problem.strerror or problem}",
        "make the path accessible, or name another path, and run gidl again",
    )
    return findings.found[0]


def _find_current_folder() -> None:
    """Raises an OSError that names the current folder if the folder was deleted."""
    try:
        Path.cwd()
    except OSError as problem:
        problem.filename = "the current folder"
        raise


def _replace_closed_streams() -> None:
    """Replaces each standard stream that was closed before gidl started, because Python has None in
    place of a closed stream. After the replacement, reading stdin and writing stdout fail with an
    OSError, and text for stderr is lost."""
    if sys.stdin is None:
        sys.stdin = os.fdopen(os.open(os.devnull, os.O_WRONLY))
    if sys.stdout is None:
        sys.stdout = os.fdopen(os.open(os.devnull, os.O_RDONLY), "w")
    if sys.stderr is None:
        sys.stderr = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")


def _no_more_output() -> None:
    """Discards the buffered output. Otherwise Python would try to write this output to the closed
    stdout at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gidl",
        description="Compiler of .gidl robot interfaces.",
        epilog="Exit status: 0 success, 1 gidl could not run, 2 wrong usage, 100 findings.",
    )
    parser.add_argument("--version", action="version", version=f"gidl {__version__}")
    verbs = parser.add_subparsers(metavar="VERB", required=True)

    gen.add_verb(verbs)

    check = verbs.add_parser("check", help="report errors and warnings")
    add_files(check)
    add_except(check, "warnings to suppress, for example G0708")
    check.set_defaults(command=_check)

    lint.add_verb(verbs)
    fmt.add_verb(verbs)
    breaking.add_verb(verbs)

    dump = verbs.add_parser("dump", help="print the model as canonical JSON")
    add_files(dump)
    dump.add_argument("--whole", action="store_true", help="print included files too")
    dump.add_argument(
        "--omg",
        choices=("corba", "dds"),
        help="print OMG IDL instead of JSON: corba for omniidl, or dds (types only) for idlc",
    )
    dump.set_defaults(command=_dump, prints=True)

    new.add_verb(verbs)

    explain = verbs.add_parser("explain", help="explain the code of a finding")
    explain.add_argument(
        "code", nargs="?", help="a code, for example G0102; without a code, gidl lists all codes"
    )
    explain.set_defaults(command=_explain, settles=False)
    return parser


# ---------------------------------------------------------------------------------------------
# The functions that run the subcommands


def _check(chosen: argparse.Namespace) -> int:
    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = compiled_from(chosen, files)
    if not compiled.has_errors and no_effect.CODE not in chosen.excepted:
        findings = Findings(list(compiled.findings))
        no_effect.check(compiled.model, findings)
        compiled = replace(compiled, findings=tuple(findings.in_order(list(compiled.sources))))
    compiled = strictly(chosen, compiled)
    show(chosen, compiled.findings, compiled.sources)
    return FINDINGS if compiled.has_errors else FINE


def _dump(chosen: argparse.Namespace) -> int:
    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = strictly(chosen, compiled_from(chosen, files))
    findings = Findings(list(compiled.findings))
    text = "" if compiled.has_errors else _dumped(chosen, compiled, findings)
    order = [file.path for file in compiled.model.files]
    show(chosen, findings.in_order(order), compiled.sources)
    if findings.has_errors:
        return FINDINGS
    sys.stdout.write(text)
    return FINE


def _dumped(chosen: argparse.Namespace, compiled: Compiled, findings: Findings) -> str:
    from gidl.omg import omg_text
    from gidl.targets.model_json import model_text
    from gidl.wire import wire_layout
    from gidl.wire.events import events_as_streams

    if chosen.omg is not None:
        return omg_text(compiled.model, chosen.omg, chosen.whole, findings)
    model = events_as_streams(compiled.model)
    return model_text(model, wire_layout.build(model), chosen.whole)


def _explain(chosen: argparse.Namespace) -> int:
    from gidl.cli.explain import all_titles, closest, page

    if chosen.code is None:
        for code, title in all_titles():
            print(f"{code}  {title}")
        return FINE
    found = page(chosen.code)
    if found is None:
        hint = closest(chosen.code)
        print(f"gidl: there is no code {chosen.code}{hint}", file=sys.stderr)
        return USAGE
    print(found)
    return FINE
