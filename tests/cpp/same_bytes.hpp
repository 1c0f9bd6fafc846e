#pragma once

#include <cstring>

#include "gecos/base/bytes.hpp"

/// std::ranges::equal for images: tests are not optimised, and it would take 50 ms for 2 MB.
inline bool same_bytes(gecos::ByteView one, gecos::ByteView other) {
  return one.size() == other.size() &&
         (one.empty() || std::memcmp(one.data(), other.data(), one.size()) == 0);
}
