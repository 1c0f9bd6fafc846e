#pragma once

#include <cstddef>
#include <string_view>

namespace gecos {

/// Returns the longest beginning of `text` that has at most `most` bytes and ends with a whole
/// character. @pre `text` is UTF-8
inline std::string_view whole_characters(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto continues = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  while (most > 0 && continues(most)) --most;
  return text.substr(0, most);
}

}  // namespace gecos
