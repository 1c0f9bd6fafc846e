#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace gecos::crypto {

/// Overwrites `bytes` with zeros in a way that no compiler optimizes away.
void wipe(std::span<std::byte> bytes);

/// Bytes that must not outlive their use: every copy wipes itself.
template <std::size_t N>
class Secret {
 public:
  Secret() = default;
  explicit Secret(std::span<const std::byte, N> bytes) { std::ranges::copy(bytes, bytes_.begin()); }
  Secret(const Secret&) = default;
  Secret& operator=(const Secret&) = default;
  ~Secret() { wipe(bytes_); }

  std::span<const std::byte, N> bytes() const { return bytes_; }
  std::span<std::byte, N> bytes() { return bytes_; }

 private:
  std::array<std::byte, N> bytes_{};
};

/// Key of a cipher, or of one direction of a channel.
using Key = Secret<32>;

}  // namespace gecos::crypto
