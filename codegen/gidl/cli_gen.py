"""`gidl gen`: write what the interfaces say, or with --check say what differs from it."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Collection, Mapping
from pathlib import Path

from gidl.cli_shared import (
    FINDINGS,
    FINE,
    USAGE,
    add_files,
    compiled_from,
    count,
    files_of,
    show,
    strictly,
)
from gidl.compile import Compiled
from gidl.diagnostics import Finding, Findings, Severity
from gidl.file_names import same_modules, source_stem
from gidl.model import Location
from gidl.output import (
    LANGUAGES,
    Difference,
    Outputs,
    compare,
    diff_text,
    first_difference,
    not_ours,
    read_output,
    replace_texts,
    write,
)


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    gen = verbs.add_parser("gen", help="write C++, Python, LCM and model files", allow_abbrev=False)
    add_files(gen)
    gen.add_argument("--out", type=Path, help="folder to write to; generated/ when left out")
    gen.add_argument(
        "--lang",
        type=_languages,
        metavar="A,B",
        help=f"which of {', '.join(LANGUAGES)}; all by default",
    )
    gen.add_argument("--check", action="store_true", help="write nothing; show what differs")
    gen.add_argument(
        "--prune",
        action="store_true",
        help="delete the leftovers of all interfaces, even when files are named",
    )
    gen.add_argument(
        "--depfile",
        type=Path,
        metavar="FILE",
        help="write the list of read files there, for Make and Ninja",
    )
    gen.set_defaults(command=run)


def _languages(text: str) -> tuple[str, ...]:
    chosen = tuple(part.strip() for part in text.split(","))
    for language in chosen:
        if language not in LANGUAGES:
            raise argparse.ArgumentTypeError(f"'{language}' is none of {', '.join(LANGUAGES)}")
    return chosen


def run(chosen: argparse.Namespace) -> int:
    from gidl.depfile import depfile_text
    from gidl.emit import UnsupportedError

    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = strictly(chosen, compiled_from(chosen, files))
    found = list(compiled.findings)
    texts: dict[str, str] | None = None
    if not compiled.has_errors and "python" in chosen.lang:
        found += _modules_of_two(compiled)
    if not any(finding.severity is Severity.ERROR for finding in found):
        try:
            texts = texts_of(compiled, chosen.lang)
        except UnsupportedError as problem:
            refusal = Findings()
            refusal.error("G0801", problem.location, problem.text)
            found += refusal.found
    if texts is None:
        show(chosen, found, compiled.sources)
        return FINDINGS
    outputs = Outputs(chosen.out, chosen.outputs)
    difference = compare(outputs, texts, chosen.lang, _sources(chosen, compiled))
    if chosen.check:
        if chosen.error_format != "text":
            found += differing(outputs, texts, difference, _mend(chosen)).found
        show(chosen, found, compiled.sources)
        return _told(chosen, outputs, texts, difference)
    in_the_way = _in_the_way(outputs, difference)
    show(chosen, found + in_the_way, compiled.sources)
    if in_the_way:
        return FINDINGS
    write(outputs, texts, difference)
    if chosen.depfile is not None:
        project = [chosen.project.file] if chosen.project.file is not None else []
        made = [outputs.place(path) for path in texts]
        replace_texts({chosen.depfile: depfile_text(made, compiled.sources, project)})
    deleted = "".join(f"gidl: deleted {place}\n" for place in difference.stale)
    written = len(difference.changed) + len(difference.missing)
    stale = f", {len(difference.stale)} deleted" if difference.stale else ""
    where = outputs.shown(chosen.lang)
    _say(
        chosen, f"{deleted}gidl: {count(len(texts), 'file')} in {where}, {written} written{stale}\n"
    )
    return FINE


def _modules_of_two(compiled: Compiled) -> list[Finding]:
    from gidl.targets.naming import has_output

    model = compiled.model
    wrong = Findings()
    for clash in same_modules(f.path for f in model.files if has_output(model, f.path)):
        clash.report("G0022", wrong, compiled.sources)
    return wrong.found


def _in_the_way(outputs: Outputs, difference: Difference) -> list[Finding]:
    """A finding for each file that somebody wrote by hand and `gen` would replace."""
    findings = Findings()
    for place in not_ours(outputs, difference):
        message = "is no generated file, and a generated one belongs there"
        findings.file_error(
            "G1404", place.as_posix(), message, "move it away or delete it; nothing was written"
        )
    return findings.found


def texts_of(compiled: Compiled, languages: Collection[str]) -> dict[str, str]:
    """Path below the output folder -> text. Raises UnsupportedError."""
    from gidl import wire_layout
    from gidl.emit import render
    from gidl.model_json import file_text

    model = compiled.model
    layout = wire_layout.build(model)
    texts = render(model, layout, [language for language in languages if language != "model"])
    if "model" in languages:
        for file in model.files:
            if file.asked_for:
                texts[f"model/{source_stem(file.path)}.json"] = file_text(model, layout, file)
    return texts


def _sources(chosen: argparse.Namespace, compiled: Compiled) -> Collection[str] | None:
    """The sources whose stale output goes: the named files. None: the run is about all interfaces,
    so output of any other source is left over from one that is gone."""
    if chosen.prune or not chosen.files:
        return None
    return {source_stem(file.path) for file in compiled.model.files if file.asked_for}


def differing(
    outputs: Outputs, texts: Mapping[str, str], difference: Difference, mend: str
) -> Findings:
    """A finding for each file that is not as generated."""
    findings = Findings()
    for path in difference.changed:
        place = outputs.place(path)
        line = first_difference(read_output(place) or "", texts[path])
        at = Location(place.as_posix(), line, 1)
        findings.error("G1401", at, "is not what the interfaces say", mend)
    for path in difference.missing:
        place = outputs.place(path)
        findings.file_error("G1402", place.as_posix(), "is not there", mend)
    for place in difference.stale:
        message = "is generated from an interface that does not give it any more"
        findings.file_error("G1403", place.as_posix(), message, mend)
    return findings


def _told(
    chosen: argparse.Namespace,
    outputs: Outputs,
    texts: Mapping[str, str],
    difference: Difference,
) -> int:
    where = outputs.shown(chosen.lang)
    if difference.is_empty:
        agree = "is" if len(texts) == 1 else "are"
        made = count(len(texts), "file")
        _say(chosen, f"gidl: {made} in {where} {agree} what the interfaces say\n")
        return FINE
    if chosen.error_format == "text":
        sys.stdout.write(diff_text(outputs, texts, difference))
    which = count(difference.count, "file")
    _say(chosen, f"gidl: {which} in {where} not as generated; {_mend(chosen)}\n")
    return FINDINGS


def _say(chosen: argparse.Namespace, text: str) -> None:
    """Prints a line for people; it goes to stderr when stdout has a report for machines."""
    (sys.stdout if chosen.error_format == "text" else sys.stderr).write(text)


def _mend(chosen: argparse.Namespace) -> str:
    """The same command, to write instead of to check."""
    words = list(chosen.words)
    words.remove("--check")
    for at, word in enumerate(words):
        if word.partition("=")[0] == "--error-format":
            del words[at : at + (1 if "=" in word else 2)]
            break
    return f"this mends it: {shlex.join(['gidl', *words])}"
