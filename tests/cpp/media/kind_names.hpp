// Media by their names, in the names of tests and in what gtest prints.
#pragma once

#include <gtest/gtest.h>

#include <ostream>
#include <string>

#include "gecos/media/kinds.hpp"

namespace gecos::media {

inline void PrintTo(Kind kind, std::ostream* out) { *out << to_string(kind); }

inline std::string name_of(const testing::TestParamInfo<Kind>& made) {
  return std::string(to_string(made.param));
}

}  // namespace gecos::media
