// An input of a fuzzer, read as decisions: what the hostile side does next, and with which numbers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "gecos/base/bytes.hpp"

namespace gecos::fuzz {

/// Ends the program, so that a fuzzer keeps the input, when a promise does not hold.
inline void expect(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: broken: %s\n", promise);
  std::abort();
}

/// Where it is over, every decision is 0.
class Script {
 public:
  explicit Script(ByteView bytes) : rest_(bytes) {}

  bool over() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const auto value = std::to_integer<std::uint8_t>(rest_.front());
    rest_ = rest_.subspan(1);
    return value;
  }
  /// @pre 0 < limit <= 256
  std::size_t below(std::size_t limit) { return byte() % limit; }
  bool one_in(std::size_t many) { return below(many) == 1; }
  std::uint64_t word() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8 | byte();
    return value;
  }
  /// Small, next to a power of two, or any.
  std::uint64_t number() {
    switch (below(4)) {
      case 0:
        return byte();
      case 1:
        return (std::uint64_t{1} << below(64)) - 1 + below(3);
      case 2:
        return ~std::uint64_t{byte()};
      default:
        return word();
    }
  }
  Bytes bytes(std::size_t most) {
    const std::size_t wanted = std::min(most, std::size_t{byte()});
    const ByteView taken = rest_.first(std::min(wanted, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return {taken.begin(), taken.end()};
  }

 private:
  ByteView rest_;
};

}  // namespace gecos::fuzz
