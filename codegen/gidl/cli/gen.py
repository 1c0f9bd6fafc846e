"""`gidl gen`: writes the generated files. With --check it writes nothing, and reports the files
that are not up to date."""

from __future__ import annotations

import argparse
import errno
import shlex
import sys
from collections.abc import Collection, Mapping
from pathlib import Path

from gidl.cli.output import (
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
from gidl.cli.shared import (
    FAILED,
    FINDINGS,
    FINE,
    USAGE,
    add_files,
    as_errors,
    compiled_from,
    count,
    files_of,
    show,
    strictly,
)
from gidl.compile import Compiled
from gidl.diagnostics.findings import Finding, Findings, Severity
from gidl.files.loader import absolute
from gidl.files.names import same_modules, source_stem
from gidl.model import Location
from gidl.names.same_names import same_names


def add_verb(verbs: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    gen = verbs.add_parser(
        "gen", help="generate C++, Python, LCM and model files", allow_abbrev=False
    )
    add_files(gen)
    gen.add_argument("--out", type=Path, help="folder to write to; default: generated/")
    gen.add_argument(
        "--lang",
        type=_languages,
        metavar="A,B",
        help=f"languages to write: {', '.join(LANGUAGES)}; default: all",
    )
    gen.add_argument("--check", action="store_true", help="write nothing; show the differences")
    gen.add_argument(
        "--prune",
        action="store_true",
        help="delete the stale output of all interfaces, not only of the named files",
    )
    gen.add_argument(
        "--depfile",
        type=Path,
        metavar="FILE",
        help="file in which gidl lists all files that it has read, for Make and Ninja",
    )
    gen.set_defaults(command=run)


def _languages(text: str) -> tuple[str, ...]:
    chosen = tuple(part.strip() for part in text.split(","))
    for language in chosen:
        if language not in LANGUAGES:
            known = ", ".join(LANGUAGES)
            raise argparse.ArgumentTypeError(f"'{language}' is no language; choose from {known}")
    return chosen


def run(chosen: argparse.Namespace) -> int:
    from gidl.cli.depfile import depfile_text
    from gidl.targets.emit import UnsupportedError

    files = files_of(chosen)
    if files is None:
        return USAGE
    compiled = strictly(chosen, compiled_from(chosen, files))
    homeless = _without_folder(compiled)
    found = [*compiled.findings, *(as_errors(homeless) if chosen.strict else homeless)]
    texts: dict[str, str] | None = None
    if not compiled.has_errors and "python" in chosen.lang:
        found += _modules_of_two(compiled)
    if not compiled.has_errors and "cpp" in chosen.lang:
        alike = Findings()
        same_names(compiled.model, alike)
        found += alike.found
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
    try:
        difference = compare(outputs, texts, chosen.lang, _sources(chosen, compiled))
    except OSError as problem:
        show(chosen, [*found, _not_written(problem)], compiled.sources)
        return FAILED
    if chosen.check:
        if chosen.error_format != "text":
            found += differing(outputs, texts, difference, _mend(chosen)).found
        show(chosen, found, compiled.sources)
        return _told(chosen, outputs, texts, difference)
    found += _in_the_way(outputs, difference)
    if any(finding.severity is Severity.ERROR for finding in found):
        show(chosen, found, compiled.sources)
        return FINDINGS
    try:
        write(outputs, texts, difference)
        if chosen.depfile is not None:
            project = [chosen.project.file] if chosen.project.file is not None else []
            made = [outputs.place(path) for path in texts]
            replace_texts({chosen.depfile: depfile_text(made, compiled.sources, project)})
    except OSError as problem:
        show(chosen, [*found, _not_written(problem)], compiled.sources)
        return FAILED
    show(chosen, found, compiled.sources)
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


def _without_folder(compiled: Compiled) -> list[Finding]:
    """Warns about a file on the command line such as lab/lamp.gidl that declares the module `lab`,
    if no search folder contains the folder lab/. The path of the output is then lamp instead of
    lab/lamp, and the generated Python module is not in the package `lab`."""
    findings = Findings()
    for file in compiled.model.files:
        shown = compiled.sources[file.path].shown
        folder = absolute(Path(shown)).parent
        stem = source_stem(file.path)
        inside = next((m for m in file.modules if m.name == folder.name), None)
        if not file.asked_for or "/" in file.path or inside is None:
            continue
        findings.warning(
            "G0026",
            inside.facts.location,
            f"the output is named {stem}, not {folder.name}/{stem}: no include directory "
            f"(-I) contains '{folder.name}'",
            f"to generate {folder.name}/{stem}, add: -I {shlex.quote(_above(Path(shown).parent))}",
        )
    return findings.found


def _above(folder: Path) -> str:
    """Returns the folder that contains `folder`, as a text for the command line."""
    above = folder.parent if folder.name not in ("", "..") else folder / ".."
    return above.as_posix()


def _in_the_way(outputs: Outputs, difference: Difference) -> list[Finding]:
    """Returns a finding for each file that `gidl gen` would overwrite although gidl did not
    generate it."""
    findings = Findings()
    for place in not_ours(outputs, difference):
        message = "this file is not generated by gidl, but gidl gen would overwrite it"
        findings.file_error(
            "G1404", place.as_posix(), message, "move or delete the file; gidl wrote nothing"
        )
    return findings.found


_ADVICE = {
    errno.ENOSPC: "delete files on the full disk",
    errno.EDQUOT: "delete files until you are within your disk quota",
    errno.EFBIG: "raise the limit for the size of files (`ulimit -f`)",
    errno.EROFS: "choose a folder on another file system with --out",
    errno.EACCES: "make the folder writable, or choose another folder with --out",
    errno.EPERM: "make the folder writable, or choose another folder with --out",
    errno.ENOTDIR: "a file has the path of the output folder; choose another folder with --out",
}


def _not_written(problem: OSError) -> Finding:
    """Returns the finding for an output that cannot be written. The files on disk are unchanged."""
    findings = Findings()
    advice = _ADVICE.get(problem.errno or 0, "choose another folder with --out")
    findings.file_error(
        "G1405",
        Path(str(problem.filename)).as_posix(),
        f"this output cannot be written: {problem.strerror or problem}",
        f"{advice}, and run gidl again",
    )
    return findings.found[0]


def texts_of(compiled: Compiled, languages: Collection[str]) -> dict[str, str]:
    """Returns the generated files, as a map from the path below the output folder to the text.
    Raises UnsupportedError."""
    from gidl.targets.emit import render
    from gidl.targets.model_json import file_text
    from gidl.wire import wire_layout
    from gidl.wire.events import events_as_streams

    model = events_as_streams(compiled.model)
    layout = wire_layout.build(model)
    texts = render(model, layout, [language for language in languages if language != "model"])
    if "model" in languages:
        for file in model.files:
            if file.asked_for:
                texts[f"model/{source_stem(file.path)}.json"] = file_text(model, layout, file)
    return texts


def _sources(chosen: argparse.Namespace, compiled: Compiled) -> Collection[str] | None:
    """Returns the stems (paths without suffix) of the interface files whose stale output is
    removed. These are the files named on the command line. None means that the stale output of all
    interfaces is removed."""
    if chosen.prune or not chosen.files:
        return None
    return {source_stem(file.path) for file in compiled.model.files if file.asked_for}


def differing(
    outputs: Outputs, texts: Mapping[str, str], difference: Difference, mend: str
) -> Findings:
    """Returns a finding for each changed, missing or stale output file."""
    findings = Findings()
    for path in difference.changed:
        place = outputs.place(path)
        line = first_difference(read_output(place) or "", texts[path])
        at = Location(place.as_posix(), line, 1)
        findings.error("G1401", at, "this file differs from what gidl gen would write", mend)
    for path in difference.missing:
        place = outputs.place(path)
        findings.file_error("G1402", place.as_posix(), "this output file is missing", mend)
    for place in difference.stale:
        message = "this output file is stale: no interface generates it any more"
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
        _say(chosen, f"gidl: {made} in {where} {agree} up to date\n")
        return FINE
    if chosen.error_format == "text":
        sys.stdout.write(diff_text(outputs, texts, difference))
    which = count(difference.count, "file")
    _say(chosen, f"gidl: {which} in {where} not up to date; {_mend(chosen)}\n")
    return FINDINGS


def _say(chosen: argparse.Namespace, text: str) -> None:
    """Prints a status line: on stdout, or on stderr if stdout has a machine-readable report."""
    (sys.stdout if chosen.error_format == "text" else sys.stderr).write(text)


def _mend(chosen: argparse.Namespace) -> str:
    """Returns a help line with the command that updates the files: this command line without
    --check."""
    words = list(chosen.words)
    words.remove("--check")
    for at, word in enumerate(words):
        if word.partition("=")[0] == "--error-format":
            del words[at : at + (1 if "=" in word else 2)]
            break
    return f"to fix, run: {shlex.join(['gidl', *words])}"
