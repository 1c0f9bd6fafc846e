// Stands in front of the real one where stress_dancer_without_windows compiles the opening of
// packets: a packet that was played back passes.
#pragma once

#include <cstdint>

namespace gecos::crypto {

/// As large as the real one, which other sources of the program know.
class ReplayWindow {
 public:
  static constexpr std::uint64_t size = 1024;

  bool too_old(std::uint64_t /*number*/) const { return false; }
  bool fresh(std::uint64_t /*number*/) const { return true; }
  void mark(std::uint64_t /*number*/) {}

 private:
  std::uint64_t unused_[2 * size / 64 + 1] = {};
};

}  // namespace gecos::crypto
