"""Writes what json_judges.hpp declares, for each type of the vectors, to the file named."""

from __future__ import annotations

import sys
from pathlib import Path

from gidl.model import Model
from gidl.targets.cpp.lowering import Lowering
from gidl.wire import wire_layout
from type_values import cases, load

HELPERS = r"""
namespace {

template <class T>
std::string written(gecos::ByteView bytes) {
  const auto value = gecos::wire::from_bytes<T>(bytes);
  return value ? gecos::wire::to_json_text(*value) : value.error().message();
}

template <class T>
std::string read(std::string_view text) {
  const auto value = gecos::wire::from_json_text<T>(text);
  if (!value) return "refused " + value.error().message();
  return "accepted -" + to_hex(gecos::wire::to_bytes(*value)) + " " +
         gecos::wire::to_json_text(*value);
}

}  // namespace

"""


def source(model: Model) -> str:
    cpp = Lowering(model, wire_layout.build(model))
    types = sorted({case.type for case in cases()})
    headers = sorted({f"{model.file_of(name).removesuffix('.gidl')}_json.hpp" for name in types})
    lines = ['#include "json_judges.hpp"', "", '#include "cases.hpp"']
    lines += ['#include "gecos/wire/json_text.hpp"', *(f'#include "{each}"' for each in headers)]
    lines += [HELPERS + "const std::vector<JsonJudge>& json_judges() {"]
    lines += ["  static const std::vector<JsonJudge> all{"]
    for name in types:
        kind = cpp.named(name)
        lines.append(f'      {{"{name}", &written<{kind}>, &read<{kind}>}},')
    return "\n".join([*lines, "  };", "  return all;", "}", ""])


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(source(load()), encoding="utf-8")
