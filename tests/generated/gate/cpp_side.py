"""The C++ program of a set of files: generated code, `Form` of every type, a question for each
type, call and stream.

What the program calls is found by its place, not by its name: members by structured bindings,
handlers as the virtual functions of a servant's class in the order of its calls.
"""

from __future__ import annotations

import re
import struct
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import spelled
from gidl.files.names import source_stem
from gidl.model import Attribute, Bitset, Interface, Model, Struct, Union
from gidl.targets.cpp.names import absolute, member_name
from gidl.wire.wire_layout import Layout
from neutral import is_hand_written, named_fields
from python_side import Verdict

OBJECT_REF = "gecos/object_ref"
"""Stem of the file that declares ObjectRef of our library; driver.hpp has its Form."""


@dataclass(frozen=True)
class Virtual:
    """A handler of a servant's class, as its header declares it."""

    result: str
    name: str
    parameters: str

    @property
    def inner(self) -> str:
        return self.result.removeprefix("gecos::Result<").removesuffix(">")

    @property
    def values(self) -> list[str]:
        """Names of the parameters."""
        return [part.split()[-1].lstrip("&") for part in _top_level(self.parameters)]


def _top_level(text: str) -> list[str]:
    """`text` split at the commas that no bracket holds."""
    parts, depth, start = [], 0, 0
    for at, letter in enumerate(text):
        depth += (letter in "<(") - (letter in ">)")
        if letter == "," and depth == 0:
            parts.append(text[start:at])
            start = at + 1
    return [part.strip() for part in (*parts, text[start:]) if part.strip()]


class Program:
    """Its source, and the numbers of its questions."""

    def __init__(self, model: Model, layout: Layout, cpp: Path, stems: list[str]) -> None:
        self._model = model
        self._layout = layout
        self._cpp = cpp
        self._stems = stems
        self.questions: list[str] = []
        self.numbers: dict[tuple[str, str], int] = {}
        self._virtuals: dict[str, list[Virtual]] = {}
        self._publishers: dict[str, list[str]] = {}

    def source(self) -> str:
        types = [d for d in self._model.declarations() if self._is_ours(d.name)]
        lines = [f'#include "{name}"' for name in (*self._sources(), *self._call_headers())]
        lines += [
            '#include "gecos/wire/json_text.hpp"',
            '#include "driver.hpp"',
            "",
            "namespace gate {",
        ]
        lines += self._json()
        kinds = [d for d in self._model.declarations() if isinstance(d, Struct | Union | Bitset)]
        forms = [d for d in kinds if self._stem(d.name) != OBJECT_REF and self._reached(d.name)]
        lines += [line for d in forms for line in self._declared(d)]
        lines += [line for d in forms for line in self._defined(d)]
        for declaration in types:
            if isinstance(declaration, Struct | Union) and not is_hand_written(declaration):
                name = spelled.cpp(self._model, self._layout, declaration.name)
                self._question("type", declaration.name, f"send<{name}>")
                self._question("bytes", declaration.name, f"receive<{name}>")
                self._question("json", declaration.name, f"to_json<{name}>")
                self._question("from json", declaration.name, f"from_json<{name}>")
        probes = [d for d in types if isinstance(d, Interface)]
        for interface in probes:
            lines += self._interface(interface)
        body = ",\n    ".join(self.questions)
        lines += [f"const Question all[] = {{\n    {body}}};" if body else ""]
        all_of_them = "all" if body else "std::span<const gate::Question>()"
        lines += ["}  // namespace gate", ""]
        lines += ["int main(int count, char** words) {"]
        call = f"gate::run({'gate::' if body else ''}{all_of_them}, count, words)"
        lines += [f"  return {call};", "}", ""]
        return "\n".join(lines)

    def _is_ours(self, name: str) -> bool:
        return self._stem(name) in self._stems

    def _reached(self, name: str) -> bool:
        return (self._cpp / f"{self._stem(name)}_types.hpp").exists() or self._stem(
            name
        ) == "robcl/geometry"

    def _stem(self, name: str) -> str:
        return source_stem(self._model.file_of(name))

    def _sources(self) -> Iterator[str]:
        for stem in self._stems:
            for part in ("types", "interface", "client", "server", "json"):
                if (self._cpp / f"{stem}_{part}.cpp").exists():
                    yield f"{stem}_{part}.cpp"

    def _call_headers(self) -> Iterator[str]:
        for stem in self._stems:
            if (self._cpp / f"{stem}_calls.hpp").exists():
                yield f"{stem}_calls.hpp"

    def _question(self, what: str, name: str, function: str) -> None:
        self.numbers[what, name] = len(self.questions)
        self.questions.append(function)

    def _json(self) -> list[str]:
        return [
            "template <class T>",
            "Answers to_json(gecos::ByteView neutral, gecos::ByteView) {",
            "  In in(neutral);",
            "  const auto made = std::make_unique<T>();",
            "  T& value = *made;",
            "  Form<T>::fill(in, value);",
            "  const std::string text = gecos::wire::to_json_text(value);",
            "  const auto bytes = std::as_bytes(std::span(text));",
            "  return {yes({bytes.begin(), bytes.end()}), {}};",
            "}",
            "template <class T>",
            "Answers from_json(gecos::ByteView bytes, gecos::ByteView) {",
            "  const auto* begin = reinterpret_cast<const char*>(bytes.data());",
            "  const std::string_view text(begin, bytes.size());",
            "  const auto value = gecos::wire::from_json_text<T>(text);",
            "  if (!value) return {no(value.error().message()), {}};",
            "  return {yes(gecos::wire::to_bytes(*value)), {}};",
            "}",
            "template <class T>",
            "gecos::Bytes values_to_bytes(const T& value) {",
            "  if constexpr (gecos::layout::Listed<T>) {",
            "    return gecos::layout::to_bytes(value);",
            "  } else {",
            "    gecos::Bytes bytes(value.encoded_size());",
            "    gecos::wire::Encoder to(bytes);",
            "    value.encode(to);",
            "    return bytes;",
            "  }",
            "}",
            "template <class T>",
            "Answers call_values(gecos::ByteView bytes, gecos::ByteView) {",
            "  const auto made = std::make_unique<T>();",
            "  T& value = *made;",
            "  gecos::wire::Decoder from(bytes);",
            "  bool fine = false;",
            "  if constexpr (gecos::layout::Listed<T>) {",
            "    fine = gecos::layout::decode(from, value);",
            "  } else {",
            "    fine = value.decode(from);",
            "  }",
            "  if (!fine) return {no(from.error().message()), {}};",
            "  const std::string text = gecos::wire::to_json_text(value);",
            "  const auto written = std::as_bytes(std::span(text));",
            "  return {yes(values_to_bytes(value)), yes({written.begin(), written.end()})};",
            "}",
            "template <class T>",
            "Answers call_values_from_json(gecos::ByteView bytes, gecos::ByteView) {",
            "  const auto* begin = reinterpret_cast<const char*>(bytes.data());",
            "  const auto value = gecos::wire::from_json_text<T>({begin, bytes.size()});",
            "  if (!value) return {no(value.error().path), {}};",
            "  return {yes(values_to_bytes(*value)), {}};",
            "}",
        ]

    # -- types ---------------------------------------------------------------------------------

    def _declared(self, declaration: Struct | Union | Bitset) -> list[str]:
        name = spelled.cpp(self._model, self._layout, declaration.name)
        if is_hand_written(declaration):
            return [f"template <> struct Form<{name}> : HandWritten<{name}> {{}};"]
        return [
            f"template <> struct Form<{name}> {{",
            f"  static void fill(In&, {name}&);",
            f"  static void dump(Out&, const {name}&);",
            "};",
        ]

    def _defined(self, declaration: Struct | Union | Bitset) -> Iterator[str]:
        if is_hand_written(declaration):
            return
        name = spelled.cpp(self._model, self._layout, declaration.name)
        for verb, stream, const in (("fill", "In& io", ""), ("dump", "Out& io", "const ")):
            head = f"void Form<{name}>::{verb}([[maybe_unused]] {stream}, "
            yield f"{head}[[maybe_unused]] {const}{name}& value) {{"
            yield from self._body(declaration, verb)
            yield "}"

    def _body(self, declaration: Struct | Union | Bitset, verb: str) -> Iterator[str]:
        if isinstance(declaration, Union):
            yield "  auto& [tag, held] = value;"
            yield f"  gate::{verb}(io, tag, held);"
            return
        if isinstance(declaration, Bitset):
            base, own = None, [f.name for f in named_fields(self._model, declaration)]
        else:
            base, own = declaration.base, [member.name for member in declaration.members]
        if base:
            yield f"  Form<{spelled.cpp(self._model, self._layout, base)}>::{verb}(io, value);"
            for member in own:
                yield f"  gate::{verb}(io, value.{member_name(member)});"
        elif own:
            bound = ", ".join(f"m{i}" for i in range(len(own)))
            yield f"  auto& [{bound}] = value;"
            yield f"  gate::{verb}(io, {bound});"

    # -- calls ---------------------------------------------------------------------------------

    def _interface(self, interface: Interface) -> Iterator[str]:
        proxy = spelled.cpp(self._model, self._layout, interface.name)
        servant = spelled.cpp_servant(self._layout, interface.name)
        yield from self._results(interface)
        self._values(interface)
        probe = f"Probe_{interface.name.replace('::', '_')}"
        yield f"class {probe} final : public {servant} {{"
        yield " public:"
        yield "  GateHandler gate_handler;"
        methods: dict[int, str] = {}
        for each in self._model.with_bases(interface):
            layout = self._layout.interfaces[each.name]
            found = self._handlers(each)
            assert len(found) == len(layout.calls), f"{each.name}: {found}"
            for call, virtual in zip(layout.calls, found, strict=True):
                values = ", ".join(virtual.values)
                yield f"  {virtual.result} {virtual.name}({virtual.parameters}) override {{"
                yield f"    return gate_handler.answer<{virtual.inner}>({values});"
                yield "  }"
                owner = spelled.cpp(self._model, self._layout, each.name)
                methods[call.code] = f"{owner}::{virtual.name}"
        yield "};"
        lambda_ = "[](gecos::ByteView a, gecos::ByteView b) { return "
        for call in self._layout.all_calls(self._model, interface):
            key = f"{interface.name} {call.code}"
            method = f"&{methods[call.code]}"
            self._question("ask", key, f"{lambda_}ask<{proxy}>({method}, a, b); }}")
            self._question("serve", key, f"{lambda_}serve<{probe}>({call.code}U, a, b); }}")
        for each in self._model.with_bases(interface):
            codes = sorted(
                self._layout.stream(member.scoped_name).code
                for member in each.members
                if isinstance(member, Attribute) and member.streams_out
            )
            for code, name in zip(codes, self._publishers.get(each.name, []), strict=True):
                owner = spelled.cpp_servant(self._layout, each.name)
                key = f"{interface.name} {code}"
                self._question(
                    "publish", key, f"{lambda_}publish<{probe}>(&{owner}::{name}, a, b); }}"
                )

    def _values(self, interface: Interface) -> None:
        """Questions about the structs of arguments and results."""
        for call in self._layout.interfaces[interface.name].calls:
            names = self._layout.cpp_names
            for what, fields, table in (
                ("arguments", call.request, names.arguments),
                ("result", call.reply, names.results),
            ):
                if fields:
                    name, key = absolute(table[call.name]), f"{interface.name} {call.code}"
                    self._question(what, key, f"call_values<{name}>")
                    self._question(f"{what} from json", key, f"call_values_from_json<{name}>")

    def _results(self, interface: Interface) -> Iterator[str]:
        """`Form` of the structs that an operation with several outputs gives."""
        calls = self._layout.interfaces[interface.name].calls
        for call in calls:
            if len(call.reply) > 1:
                name = spelled.cpp_results(self._layout, call.name)
                members = ", ".join(f"m{i}" for i in range(len(call.reply)))
                yield f"template <> struct Form<{name}> {{"
                for verb, io, const in (("fill", "In", ""), ("dump", "Out", "const ")):
                    yield f"  static void {verb}({io}& io, {const}{name}& value) {{"
                    yield f"    auto& [{members}] = value;"
                    yield f"    gate::{verb}(io, {members});"
                    yield "  }"
                yield "};"
                self._question("results", f"{interface.name} {call.code}", f"send<{name}>")

    def _handlers(self, interface: Interface) -> list[Virtual]:
        """In the order of the interface's own calls."""
        if interface.name not in self._virtuals:
            servant = self._layout.cpp_names.servants[interface.name]
            scope, name = "::".join(servant.scope), servant.name
            text = self._header(interface)
            if scope:  # a header may have several namespaces with a class of that name
                inside = rf"^namespace {scope} {{\n(.*?)^}}  // namespace {scope}$"
                text = "".join(re.findall(inside, text, re.S | re.M))
            body = re.search(rf"class {name} :.*?\n}};", text, re.S)
            assert body is not None, f"no servant {name} in the header of {interface.name}"
            text = re.sub(r"\s+", " ", re.sub(r"//.*", "", body[0]))
            found = re.findall(r"virtual (gecos::Result<.*?>) (\w+)\( ?(.*?)\) = 0;", text)
            self._virtuals[interface.name] = [Virtual(*each) for each in found]
            self._publishers[interface.name] = re.findall(r"void (publish_\w+)\(", text)
        return self._virtuals[interface.name]

    def _header(self, interface: Interface) -> str:
        stem = self._stem(interface.name)
        here = self._cpp / f"{stem}_server.hpp"
        if not here.exists():
            here = Path(__file__).resolve().parents[3] / "generated" / "cpp" / f"{stem}_server.hpp"
        return here.read_text(encoding="utf-8")


@dataclass
class Asked:
    """A question to the program, and its two answers."""

    what: str
    name: str
    first: bytes
    second: bytes = b""
    answers: tuple[Verdict, Verdict] | None = None


def answer(program: Program, binary: Path, asked: list[Asked]) -> list[str]:
    """Fills in the answers. Says where the program died; it goes on with the next question."""
    died: list[str] = []
    at = 0
    while at < len(asked) and len(died) < 4:
        part = asked[at:]
        questions, answers = binary.with_suffix(".ask"), binary.with_suffix(".say")
        records = b"".join(
            struct.pack("<II", program.numbers[q.what, q.name], len(q.first)) + q.first
            + struct.pack("<I", len(q.second)) + q.second
            for q in part
        )  # fmt: skip
        questions.write_bytes(struct.pack("<I", len(part)) + records)
        answers.write_bytes(b"")
        done = subprocess.run([binary, questions, answers], capture_output=True, timeout=300)
        said = list(_answers(answers.read_bytes()))
        for question, given in zip(part, said, strict=False):
            question.answers = given
        at += len(said)
        if at < len(asked):
            lost, text = asked[at], done.stderr.decode(errors="replace")
            died.append(f"C++ died of {lost.what} {lost.name} {lost.first.hex()}:\n{text[:3000]}")
            at += 1
        elif done.returncode or b"runtime error" in done.stderr:
            died.append(f"C++ ended with {done.returncode}: {done.stderr.decode()[:3000]}")
    return died


def _answers(data: bytes) -> Iterator[tuple[Verdict, Verdict]]:
    at = 0
    pair: list[Verdict] = []
    while at + 5 <= len(data):
        fine, size = data[at] == 1, struct.unpack_from("<I", data, at + 1)[0]
        if at + 5 + size > len(data):
            return
        body = data[at + 5 : at + 5 + size]
        at += 5 + size
        pair.append(
            Verdict(True, body) if fine else Verdict(False, b"", body.decode(errors="replace"))
        )
        if len(pair) == 2:
            yield pair[0], pair[1]
            pair = []
