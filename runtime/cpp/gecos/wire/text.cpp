#include "gecos/wire/text.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace gecos::wire {
namespace {

std::uint8_t byte_at(std::string_view text, std::size_t i) {
  return static_cast<std::uint8_t>(text[i]);
}

/// Returns the number of bytes of the character that starts at index `i`; 0 when the character is
/// malformed.
std::size_t character_size(std::string_view text, std::size_t i) {
  const std::uint8_t lead = byte_at(text, i);
  std::size_t size = 0;
  std::uint8_t lowest = 0x80;  // limits of the second byte
  std::uint8_t highest = 0xBF;
  if (lead < 0x80) {
    return 1;
  } else if (lead >= 0xC2 && lead <= 0xDF) {
    size = 2;
  } else if (lead >= 0xE0 && lead <= 0xEF) {
    size = 3;
    if (lead == 0xE0) lowest = 0xA0;   // a smaller byte: an overlong form
    if (lead == 0xED) highest = 0x9F;  // a larger byte: a surrogate
  } else if (lead >= 0xF0 && lead <= 0xF4) {
    size = 4;
    if (lead == 0xF0) lowest = 0x90;   // a smaller byte: an overlong form
    if (lead == 0xF4) highest = 0x8F;  // a larger byte: above U+10FFFF
  } else {
    return 0;
  }
  if (text.size() - i < size) return 0;
  const std::uint8_t second = byte_at(text, i + 1);
  if (second < lowest || second > highest) return 0;
  for (std::size_t k = 2; k < size; ++k) {
    if ((byte_at(text, i + k) & 0xC0) != 0x80) return 0;
  }
  return size;
}

}  // namespace

bool valid_utf8(std::string_view text) {
  constexpr std::uint64_t high_bits = 0x8080808080808080u;
  std::size_t i = 0;
  while (i < text.size()) {
    std::uint64_t eight;
    while (text.size() - i >= sizeof eight) {  // skips ASCII, the usual case, eight bytes at a time
      std::memcpy(&eight, text.data() + i, sizeof eight);
      if ((eight & high_bits) != 0) break;
      i += sizeof eight;
    }
    if (i == text.size()) break;
    const std::size_t size = character_size(text, i);
    if (size == 0) return false;
    i += size;
  }
  return true;
}

bool valid_text(std::string_view text) {
  return text.find('\0') == std::string_view::npos && valid_utf8(text);
}

}  // namespace gecos::wire
