#pragma once

#include <cstddef>
#include <string_view>

namespace gecos {

/// Returns the longest beginning of `text` that has at most `most` bytes and ends with a whole
/// character. If `text` is not UTF-8, cuts it after `most` bytes.
inline std::string_view whole_characters(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  constexpr std::size_t longest_character = 4;  // bytes
  const auto continues = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  std::size_t begin = most;  // of the character that does not fit
  while (begin > 0 && most - begin < longest_character - 1 && continues(begin)) --begin;
  return text.substr(0, continues(begin) ? most : begin);
}

}  // namespace gecos
