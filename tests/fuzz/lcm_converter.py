"""Writes the C++ program that holds generated C++ to lcm-gen's: it turns each value that lcm-gen's
code has read into ours, member by member, and compares what both encode."""

from __future__ import annotations

from collections.abc import Iterator

from gidl.model import Model, Struct, Union
from gidl.targets.cpp.names import member_name, type_name
from gidl.wire.lcm_lowering import LcmStruct
from gidl.wire.wire_layout import Layout


def program(model: Model, layout: Layout, stem: str, prefix: str, structs: list[str]) -> str:
    """@pre all of the model is one module in one file with the stem `stem`."""
    lowered = [s for of_file in layout.lcm_structs.values() for s in of_file]
    lines = [f'#include "{prefix}/{s.name.replace(".", "/")}.hpp"' for s in lowered]
    lines += [f'#include "{stem}_types.cpp"', '#include "gecos/wire/contents.hpp"', _CONVERT]
    for s in lowered:
        lines += _mapping(model, layout, s, prefix)
    lines.append(f"namespace {prefix}::{stem} {{")
    for s in lowered:
        lines += _assign(model, layout, s)
    lines += ["}", _COMPARE, "static void judge(std::uint32_t type, gecos::ByteView message) {"]
    lines.append("  switch (type) {")
    for index, name in enumerate(structs):
        theirs = f"{prefix}::{layout.structs[name].lcm.name.replace('.', '::')}"
        ours = type_name(model, layout, name)
        lines.append(f'    case {index}: return compare<{theirs}, {ours}>("{name}", message);')
    lines += ["  }", "}", _MAIN]
    return "\n".join(lines)


def _mapping(model: Model, layout: Layout, lcm: LcmStruct, prefix: str) -> Iterator[str]:
    """Which class of lcm-gen reads the block of an appendable type."""
    if lcm.source is None or not isinstance(model.find(lcm.source), Struct | Union):
        return
    ours = type_name(model, layout, lcm.source)
    theirs = f"{prefix}::{lcm.name.replace('.', '::')}"
    yield f"template <> struct TheirsOf<{ours}> {{ using type = {theirs}; }};"


def _assign(model: Model, layout: Layout, lcm: LcmStruct) -> Iterator[str]:
    """What converts one class of lcm-gen."""
    theirs = lcm.simple_name
    declaration = model.find(lcm.source) if lcm.source is not None else None
    sources = {m.source: m.name for m in lcm.members if m.source is not None}
    if declaration is None:
        if set(sources) == {"value"}:
            yield f"template <class T> void assign([[maybe_unused]] const {theirs}& from, T& to) {{"
            yield f"  convert(from.{sources['value']}, to);"
            yield "}"
        return
    if not isinstance(declaration, Struct | Union):
        return
    ours = type_name(model, layout, declaration.name)
    yield f"inline void assign([[maybe_unused]] const {theirs}& from,"
    yield f"                   [[maybe_unused]] {ours}& to) {{"
    if isinstance(declaration, Union):
        yield f"  convert(from.{lcm.members[0].name}, to.tag);"
        for index, case in enumerate(declaration.cases, start=1):
            arm = f"from.{sources[case.member.name]}"
            yield f"  if (!{arm}.empty()) convert({arm}[0], to.value.template emplace<{index}>());"
    else:
        for m in model.all_members(declaration):
            yield f"  convert(from.{sources[m.name]}, to.{member_name(m.name)});"
    yield "}"


_CONVERT = r"""
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

static int differences = 0;
static void differs(const std::string& what) {
  std::printf("%s\n", what.c_str());
  ++differences;
}

template <class T> struct TheirsOf;
template <class T> struct IsOptional : std::false_type {};
template <class T> struct IsOptional<std::optional<T>> : std::true_type {};
template <class T> struct IsMap : std::false_type {};
template <class K, class V, class O> struct IsMap<std::map<K, V, O>> : std::true_type {};
template <class T> struct IsVector : std::false_type {};
template <class T> struct IsVector<std::vector<T>> : std::true_type {};
template <class T> struct IsArray : std::false_type {};
template <class T, std::size_t n> struct IsArray<std::array<T, n>> : std::true_type {};

template <class From, class To>
void convert(const From& from, To& to) {
  if constexpr (requires { assign(from, to); }) {
    assign(from, to);
  } else if constexpr (std::is_same_v<To, bool>) {
    to = from != 0;
  } else if constexpr (std::is_arithmetic_v<To> || std::is_enum_v<To>) {
    to = static_cast<To>(from);
  } else if constexpr (requires { to.set_bits(from); }) {
    if (!to.set_bits(from)) differs("bits are not taken");
  } else if constexpr (std::is_same_v<To, std::string>) {
    to = from;
  } else if constexpr (IsOptional<To>::value) {
    if (!from.empty()) convert(from[0], to.emplace());
  } else if constexpr (IsMap<To>::value) {
    for (const auto& entry : from) {
      typename To::key_type key{};
      typename To::mapped_type value{};
      convert(entry.key, key);
      convert(entry.value, value);
      to.emplace(key, value);
    }
  } else if constexpr (IsArray<To>::value) {
    for (std::size_t i = 0; i < to.size(); ++i) convert(from[i], to[i]);
  } else if constexpr (IsVector<To>::value) {
    for (const auto& item : from) {
      typename To::value_type element{};
      convert(item, element);
      to.push_back(element);
    }
  } else {  // the bytes of an appendable value
    typename TheirsOf<To>::type block;
    const int size = static_cast<int>(from.size());
    if (block._decodeNoHash(from.data(), 0, size) != size) differs("a block is not read");
    convert(block, to);
  }
}
"""

_COMPARE = r"""
template <class Theirs, class Ours>
void compare(const char* name, gecos::ByteView message) {
  const std::string type(name);
  Theirs theirs;
  const int size = static_cast<int>(message.size());
  if (Theirs::getHash() != Ours::fingerprint()) differs(type + ": fingerprints");
  if (theirs.decode(message.data(), 0, size) != size) {
    return differs(type + ": lcm-gen's C++ refuses");
  }
  Ours ours;
  convert(theirs, ours);
  gecos::Bytes again(static_cast<std::size_t>(theirs.getEncodedSize()));
  theirs.encode(again.data(), 0, static_cast<int>(again.size()));
  const gecos::Bytes mine = gecos::wire::to_message(ours);
  if (again != mine) differs(type + ": encodes otherwise than lcm-gen's C++");
  if (!std::equal(mine.begin(), mine.end(), message.begin(), message.end())) {
    differs(type + ": encodes otherwise than lcm-gen's Python");
  }
  const auto read = gecos::wire::from_message<Ours>(message);
  if (!read) return differs(type + ": refuses: " + read.error().message());
  if (!(*read == ours)) differs(type + ": reads another value");
}
"""

_MAIN = r"""
int main(int, char** arguments) {
  std::ifstream file(arguments[1], std::ios::binary);
  const std::vector<char> all((std::istreambuf_iterator<char>(file)), {});
  std::size_t messages = 0;
  for (std::size_t at = 0; at + 8 <= all.size(); ++messages) {
    std::uint32_t head[2];
    std::memcpy(head, all.data() + at, sizeof head);
    judge(head[0], std::as_bytes(std::span(all.data() + at + 8, head[1])));
    at += 8 + head[1];
  }
  std::printf("%zu messages\n", messages);
  return differences != 0;
}
"""
