#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/bytes.hpp"

/// What generated C++ makes of a type's JSON; written out for every type by write_json_judges.py.
struct JsonJudge {
  std::string_view type;
  std::string (*written)(gecos::ByteView bytes);  ///< the JSON of a value
  std::string (*read)(std::string_view text);     ///< "accepted <hex> <JSON>" or "refused <why>"
};
const std::vector<JsonJudge>& json_judges();
