"""Writes tests/vectors/types.json as C++ (what cases.hpp declares) to the file that is named."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from gidl.model import Model, NamedType
from gidl.targets.cpp.lowering import Lowering
from gidl.wire import wire_layout
from memory_factor import MemoryFactors
from type_values import CppWriter, cases, load

HELPERS = r"""
namespace {

template <class T>
gecos::Bytes encoded(const T& value) {
  return gecos::wire::to_bytes(value);
}

template <class T>
bool equals(gecos::ByteView bytes, const T& value) {
  const auto decoded = gecos::wire::from_bytes<T>(bytes);
  return decoded && *decoded == value;
}

template <class T>
std::string printed(const T& value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

template <class T>
Verdict verdict(gecos::ByteView bytes, void (*decoded_now)()) {
  const auto decoded = gecos::wire::from_bytes<T>(bytes);
  if (decoded_now != nullptr) decoded_now();
  if (!decoded) return {std::nullopt, decoded.error().message()};
  return {gecos::wire::to_bytes(*decoded), ""};
}

}  // namespace

gecos::Bytes from_hex(std::string_view hex) {
  gecos::Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

std::string to_hex(gecos::ByteView bytes) {
  std::string hex;
  for (const std::byte each : bytes) {
    hex += "0123456789abcdef"[std::to_integer<int>(each >> 4)];
    hex += "0123456789abcdef"[std::to_integer<int>(each & std::byte{15})];
  }
  return hex;
}
"""


def source(model: Model) -> str:
    cpp = Lowering(model, wire_layout.build(model))
    writer = CppWriter(model)
    types = sorted({case.type for case in cases()})
    headers = sorted({f"{model.file_of(name).removesuffix('.gidl')}_types.hpp" for name in types})
    lines = ['#include "cases.hpp"', "", "#include <algorithm>", "#include <limits>"]
    lines += ["#include <sstream>", ""]
    lines += [f'#include "{header}"' for header in headers]
    lines += [HELPERS, "const std::vector<Case>& cases() {"]
    lines += ["  static const std::vector<Case> all{"]
    for case in cases():
        value = writer.expression(NamedType(case.type), case.value)
        lines += [
            f'      {{"{case.type}", {json.dumps(case.name)}, "{case.bytes.hex()}",',
            f"       [] {{ return encoded({value}); }},",
            f"       [](gecos::ByteView bytes) {{ return equals(bytes, {value}); }},",
            f"       [] {{ return printed({value}); }}}},",
        ]
    lines += ["  };", "  return all;", "}", ""]
    head = "Verdict judge(std::string_view type, gecos::ByteView bytes, void (*decoded)())"
    lines.append(f"{head} {{")
    for name in types:
        call = f"verdict<{cpp.named(name)}>(bytes, decoded)"
        lines.append(f'  if (type == "{name}") return {call};')
    lines += ['  return {std::nullopt, "no such type"};', "}", ""]
    factors = MemoryFactors(model)
    lines += ["const std::vector<JudgedType>& judged_types() {"]
    lines += ["  static const std::vector<JudgedType> all{"]
    lines += [f'      {{"{name}", {factors.of(NamedType(name))}}},' for name in types]
    lines += ["  };", "  return all;", "}", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(source(load()), encoding="utf-8")
