"""One batch of random types against lcm-gen: generated code on both sides, values, comparison."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import distribution
from pathlib import Path
from random import Random
from typing import Any

from gecos import wire
from gidl.diagnostics.findings import Findings
from gidl.files.loader import Loader
from gidl.model import Model, Struct
from gidl.resolve.files import resolve
from gidl.wire import wire_layout
from gidl.wire.wire_layout import Layout
from lcm_converter import program
from paired_values import PairedValues
from random_idl import Author

TREE = Path(__file__).resolve().parents[2]
WIRE_SOURCES = ("check", "decode_error", "decoder", "swap_copy", "text")
PREFIX = "lcmgen"  # package of lcm-gen's code, so that it does not meet ours of the same name


@dataclass(frozen=True)
class Outcome:
    types: int
    values: int
    differences: list[str]


def run(folder: Path, seed: int, types: int, values: int) -> Outcome:
    """Generates, compiles and compares in `folder`. Everything follows from `seed`."""
    dice = Random(seed)
    name = f"random_{seed}"
    file = folder / f"{name}.gidl"
    file.write_text(Author(dice).module(name, types), encoding="utf-8")
    model = _model(file)
    layout = wire_layout.build(model)
    lcm = _generate(folder, file)

    for path in (folder / "python", folder / "theirs"):
        sys.path.insert(0, str(path))
    try:
        import_module(PREFIX).__path__ = [str(folder / "theirs" / PREFIX)]  # of this batch
        batch = _Batch(model, layout, name, dice)
        structs = [d.name for d in model.declarations() if isinstance(d, Struct)]
        records = folder / "values"
        with records.open("wb") as out:
            for index, struct_name in enumerate(structs):
                for message in batch.messages(struct_name, values):
                    out.write(struct.pack("<II", index, len(message)) + message)
    finally:
        del sys.path[:2]
    differences = batch.differences
    differences += _cpp(folder, model, layout, lcm, structs, records, len(structs) * values)
    return Outcome(len(structs), values, differences)


class _Batch:
    """The Python half: ours and lcm-gen's make the same bytes and read each other's."""

    def __init__(self, model: Model, layout: Layout, module: str, dice: Random) -> None:
        self._ours = import_module(f"{module}_types")
        self._model = model
        self._layout = layout
        self._pairs = PairedValues(model, layout, self._our_class, self._their_class, dice)
        self._classes: dict[str, Any] = {}
        self.differences: list[str] = []

    def _our_class(self, scoped_name: str) -> Any:
        return getattr(self._ours, self._layout.python_names.types[scoped_name].name)

    def _their_class(self, full_name: str) -> Any:
        if full_name not in self._classes:
            module = import_module(f"{PREFIX}.{full_name}")
            self._classes[full_name] = getattr(module, full_name.rpartition(".")[2])
        return self._classes[full_name]

    def messages(self, name: str, values: int) -> Iterator[bytes]:
        kind = self._our_class(name)
        known = self._layout.structs[name]
        peer = self._their_class(known.lcm.name)
        told = {
            "ours": kind.fingerprint() & 0xFFFF_FFFF_FFFF_FFFF,
            "layout": known.fingerprint & 0xFFFF_FFFF_FFFF_FFFF,
            "lcm-gen": int.from_bytes(peer._get_packed_fingerprint(), "big"),
        }
        if len(set(told.values())) != 1:
            self.differences.append(f"{name}: fingerprints {told}")
        for _ in range(values):
            ours, theirs = self._pairs.struct(name)
            message = theirs.encode()
            mine = wire.to_message(ours)
            if mine != message:
                self._differs(name, "encodes otherwise", ours, message, mine)
            read = wire.from_message(kind, message)
            if read != ours or wire.to_message(read) != message:
                self._differs(name, "reads otherwise", read, message, wire.to_message(read))
            again = peer.decode(mine).encode()
            if again != message:
                self._differs(name, "is read otherwise by lcm-gen", ours, message, again)
            yield message

    def _differs(self, name: str, how: str, value: Any, theirs: bytes, ours: bytes) -> None:
        self.differences.append(
            f"{name}: Python {how}: {value}\n  lcm-gen {theirs.hex()}\n  ours    {ours.hex()}"
        )


def _model(file: Path) -> Model:
    findings = Findings()
    loader = Loader(findings, (file.parent,))
    vocabulary = loader.load_vocabulary()
    loader.load_all([str(file)])
    model = resolve(loader.files.values(), vocabulary, findings)
    assert not findings.has_errors, findings.found
    return model


def _generate(folder: Path, file: Path) -> Path:
    """Our code below cpp/ and python/, lcm-gen's below theirs/. Returns the .lcm file."""
    gidl = [sys.executable, "-m", "gidl", "gen", "-I", str(folder), "--out", str(folder), str(file)]
    search = {**os.environ, "PYTHONPATH": str(TREE / "codegen")}
    subprocess.run(gidl, check=True, stdout=subprocess.DEVNULL, env=search)
    lcm = folder / "lcm" / f"{file.stem}.lcm"
    theirs = str(folder / "theirs")
    subprocess.run(
        [lcm_gen(), "-x", "--cpp-hpath", theirs, "-p", "--ppath", theirs,
         "--package-prefix", PREFIX, str(lcm)],
        check=True,
    )  # fmt: skip
    return lcm


def wheel() -> Path:
    return Path(str(distribution("lcm").locate_file("")))


def lcm_gen() -> str:
    found = wheel() / "bin" / "lcm-gen"
    return str(found) if found.exists() else str(shutil.which("lcm-gen"))


def _cpp(
    folder: Path,
    model: Model,
    layout: Layout,
    lcm: Path,
    structs: list[str],
    records: Path,
    expected: int,
) -> list[str]:
    """The C++ half: one translation unit with all of it, which reads the records."""
    source = folder / "peer.cpp"
    source.write_text(program(model, layout, lcm.stem, PREFIX, structs), encoding="utf-8")
    binary = folder / "peer"
    runtime = TREE / "runtime" / "cpp"
    compiler = [os.environ.get("CXX", "c++")]
    if shutil.which("ccache"):
        compiler.insert(0, "ccache")
    include = ["-Icpp", "-Itheirs", f"-I{runtime}"]  # relative, so that ccache knows them again
    objects = []
    for each in (source, *(runtime / "gecos" / "wire" / f"{part}.cpp" for part in WIRE_SOURCES)):
        objects.append(f"{each.stem}.o")
        subprocess.run(
            [*compiler, "-std=c++20", "-O0", *include, "-isystem", str(wheel() / "include"),
             "-c", each.name if each == source else str(each), "-o", objects[-1]],
            check=True, cwd=folder,
        )  # fmt: skip
    subprocess.run([compiler[-1], *objects, "-o", binary.name], check=True, cwd=folder)
    done = subprocess.run([str(binary), str(records)], capture_output=True, text=True)
    differences = [f"C++: {line}" for line in done.stdout.splitlines()[:-1]]
    last = done.stdout.splitlines()[-1:]
    if done.returncode or last != [f"{expected} messages"]:
        differences.append(f"C++: ended with {done.returncode} after {last}: {done.stderr}")
    return differences
