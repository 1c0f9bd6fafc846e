#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace gecos::crypto {

/// Overwrites `bytes` with zeros. A compiler cannot optimize these writes away.
void wipe(std::span<std::byte> bytes);

/// Secret bytes that must not stay in memory after their use: the destructor overwrites them.
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

/// The key of a cipher, or of one direction of a channel.
using Key = Secret<32>;

}  // namespace gecos::crypto
