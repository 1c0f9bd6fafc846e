// Checks whether strings may be sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace gecos::wire {

/// Returns whether `text` is ASCII without NUL, which is true for most strings. Checks eight bytes
/// at a time.
inline bool plain_ascii(std::string_view text) {
  constexpr std::uint64_t high_bits = 0x8080808080808080u;
  constexpr std::uint64_t low_bits = 0x0101010101010101u;
  std::uint64_t suspicious = 0;  // gets a high bit where a byte of `text` has one, or is 0
  std::size_t i = 0;
  for (std::uint64_t eight; text.size() - i >= sizeof eight; i += sizeof eight) {
    std::memcpy(&eight, text.data() + i, sizeof eight);
    suspicious |= eight | (eight - low_bits);
  }
  for (; i < text.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(text[i]);
    suspicious |= static_cast<std::uint8_t>(byte | (byte - 1));
  }
  return (suspicious & high_bits) == 0;
}

/// Returns whether `text` is well-formed UTF-8 by RFC 3629, which has no overlong forms, no
/// surrogates, and no characters above U+10FFFF.
bool valid_utf8(std::string_view text);

/// Returns whether `text` may be sent as a string: whether it is UTF-8 without NUL.
bool valid_text(std::string_view text);

/// Orders the characters that are keys of a map by their Latin-1 code, even where `char` is signed.
struct LatinOrder {
  bool operator()(char a, char b) const {
    return static_cast<unsigned char>(a) < static_cast<unsigned char>(b);
  }
};

}  // namespace gecos::wire
