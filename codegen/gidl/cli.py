"""The command line: `gidl gen | check | lint | fmt | breaking | dump | new | explain`.

Exit status: 0 fine, 1 the tool could not run, 2 wrong usage, 100 findings.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from gidl import cli_breaking, cli_fmt, cli_lint, cli_new
from gidl.cli_shared import (
    FAILED,
    FINDINGS,
    FINE,
    USAGE,
    add_files,
    compiled_from,
    count,
    files_of,
    show,
)
from gidl.compile import Compiled
from gidl.diagnostics import Findings
from gidl.output import compare, diff_text, write

TARGETS = ("cpp", "python", "lcm", "model")


def run() -> None:
    """Entry of the installed command."""
    sys.exit(main(sys.argv[1:]))


def main(arguments: Sequence[str]) -> int:
    """Runs one command and gives its exit status."""
    parser = _parser()
    try:
        chosen = parser.parse_args(arguments)
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else USAGE
    command: Callable[[argparse.Namespace], int] = chosen.command
    try:
        return command(chosen)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except OSError as problem:
        name = f"{problem.filename}: " if problem.filename else ""
        print(f"gidl: {name}{problem.strerror or problem}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return FAILED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gidl",
        description="Compiler of .gidl robot interfaces.",
        epilog="Exit status: 0 fine, 1 could not run, 2 wrong usage, 100 findings.",
    )
    verbs = parser.add_subparsers(metavar="VERB", required=True)

    gen = verbs.add_parser("gen", help="write C++, Python, LCM and model files")
    add_files(gen)
    gen.add_argument("--out", type=Path, default=Path("generated"), help="folder to write to")
    gen.add_argument(
        "--lang",
        type=_languages,
        default=TARGETS,
        metavar="A,B",
        help=f"which of {', '.join(TARGETS)}; all by default",
    )
    gen.add_argument("--check", action="store_true", help="write nothing; show what differs")
    gen.add_argument(
        "--depfile", type=Path, metavar="FILE", help="for Make and Ninja: what was read"
    )
    gen.set_defaults(command=_gen)

    check = verbs.add_parser("check", help="report what is wrong")
    add_files(check)
    check.set_defaults(command=_check)

    cli_lint.add_verb(verbs)
    cli_fmt.add_verb(verbs)
    cli_breaking.add_verb(verbs)

    dump = verbs.add_parser("dump", help="print the model as canonical JSON")
    add_files(dump)
    dump.add_argument("--whole", action="store_true", help="included files too")
    dump.add_argument(
        "--omg",
        choices=("corba", "dds"),
        help="as plain IDL instead: for omniidl, or types for idlc",
    )
    dump.set_defaults(command=_dump)

    cli_new.add_verb(verbs)

    explain = verbs.add_parser("explain", help="the page of a finding's code")
    explain.add_argument("code", nargs="?", help="like G0102; all of them when left out")
    explain.set_defaults(command=_explain)
    return parser


def _languages(text: str) -> tuple[str, ...]:
    chosen = tuple(part.strip() for part in text.split(","))
    for language in chosen:
        if language not in TARGETS:
            raise argparse.ArgumentTypeError(f"'{language}' is none of {', '.join(TARGETS)}")
    return chosen


# ---------------------------------------------------------------------------------------------
# Verbs


def _gen(chosen: argparse.Namespace) -> int:
    from gidl import wire_layout
    from gidl.depfile import depfile_text
    from gidl.emit import UnsupportedError, render
    from gidl.model_json import file_text

    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = compiled_from(chosen, files)
    if compiled.has_errors:
        return FINDINGS
    model = compiled.model
    layout = wire_layout.build(model)
    languages = [language for language in chosen.lang if language != "model"]
    try:
        texts = render(model, layout, languages)
    except UnsupportedError as problem:
        findings = Findings()
        findings.error("G0801", problem.location, problem.text)
        show(chosen, findings.found, compiled.sources)
        return FINDINGS
    if "model" in chosen.lang:
        for file in model.files:
            if file.asked_for:
                path = f"model/{file.path.removesuffix('.gidl')}.json"
                texts[path] = file_text(model, layout, file)
    difference = compare(chosen.out, texts, chosen.lang)
    if not chosen.check:
        write(chosen.out, texts, difference)
        if chosen.depfile is not None:
            text = depfile_text(chosen.out, texts, compiled.sources)
            chosen.depfile.parent.mkdir(parents=True, exist_ok=True)
            chosen.depfile.write_text(text, encoding="utf-8")
        stale = f", {len(difference.stale)} deleted" if difference.stale else ""
        written = len(difference.changed) + len(difference.missing)
        print(f"gidl: {len(texts)} files in {chosen.out}/, {written} written{stale}")
        return FINE
    if difference.is_empty:
        print(f"gidl: {len(texts)} files in {chosen.out}/ are what the interfaces say")
        return FINE
    sys.stdout.write(diff_text(chosen.out, texts, difference))
    sys.stdout.flush()
    mend = _mending_command(chosen)
    which = count(difference.count, "file")
    print(f"gidl: {which} in {chosen.out}/ not as generated; this mends it: {mend}")
    return FINDINGS


def _check(chosen: argparse.Namespace) -> int:
    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = compiled_from(chosen, files)
    return FINDINGS if compiled.has_errors else FINE


def _dump(chosen: argparse.Namespace) -> int:
    from gidl import wire_layout
    from gidl.model_json import model_text

    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = compiled_from(chosen, files)
    if compiled.has_errors:
        return FINDINGS
    if chosen.omg is not None:
        return _dump_omg(chosen, compiled)
    sys.stdout.write(model_text(compiled.model, wire_layout.build(compiled.model), chosen.whole))
    return FINE


def _dump_omg(chosen: argparse.Namespace, compiled: Compiled) -> int:
    from gidl.omg import omg_text

    findings = Findings()
    text = omg_text(compiled.model, chosen.omg, chosen.whole, findings)
    if findings.found:
        order = [file.path for file in compiled.model.files]
        show(chosen, findings.in_order(order), compiled.sources)
        return FINDINGS
    sys.stdout.write(text)
    return FINE


def _explain(chosen: argparse.Namespace) -> int:
    from gidl.explain import all_titles, closest, page

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


def _mending_command(chosen: argparse.Namespace) -> str:
    words = ["gidl", "gen"]
    for folder in chosen.search:
        words += ["-I", folder]
    if chosen.out != Path("generated"):
        words += ["--out", str(chosen.out)]
    if tuple(chosen.lang) != TARGETS:
        words += ["--lang", ",".join(chosen.lang)]
    return " ".join([*words, *chosen.files])
