#include "gecos/wire/text.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace gecos::wire {
namespace {

using namespace std::string_view_literals;

// The encoding as RFC 3629 defines it, for every number, also those that are no characters.
std::string encoded(std::uint32_t code) {
  const auto byte = [](std::uint32_t bits) { return static_cast<char>(bits); };
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xC0 | code >> 6), byte(0x80 | (code & 63))};
  if (code < 0x10000) {
    return {byte(0xE0 | code >> 12), byte(0x80 | (code >> 6 & 63)), byte(0x80 | (code & 63))};
  }
  return {byte(0xF0 | code >> 18), byte(0x80 | (code >> 12 & 63)), byte(0x80 | (code >> 6 & 63)),
          byte(0x80 | (code & 63))};
}

TEST(Utf8, EveryCharacterIsValidAndNoSurrogateIs) {
  for (std::uint32_t code = 0; code < 0x120000; ++code) {
    const bool character = code < 0xD800 || (code > 0xDFFF && code < 0x110000);
    ASSERT_EQ(valid_utf8(encoded(code)), character) << std::hex << code;
  }
}

TEST(Utf8, OverlongFormsAreRefused) {
  for (const std::string_view text :
       {"\xC0\x80"sv, "\xC1\xBF"sv, "\xE0\x80\xAF"sv, "\xE0\x9F\xBF"sv, "\xF0\x80\x80\xAF"sv,
        "\xF0\x8F\xBF\xBF"sv}) {
    EXPECT_FALSE(valid_utf8(text));
  }
}

TEST(Utf8, ACharacterCutAnywhereIsRefusedAtEveryPlace) {
  for (const std::uint32_t code : {0xE4u, 0x20ACu, 0x1F916u}) {
    const std::string character = encoded(code);
    for (std::size_t kept = 1; kept < character.size(); ++kept) {
      for (std::size_t before = 0; before < 20; ++before) {
        const std::string text = std::string(before, 'a') + character.substr(0, kept);
        EXPECT_FALSE(valid_utf8(text)) << text;
        EXPECT_FALSE(valid_utf8(text + "bcdefghijk")) << text;
        EXPECT_TRUE(valid_utf8(std::string(before, 'a') + character + "bcdefghijk"));
      }
    }
  }
}

TEST(Text, AStrangeByteIsSeenAtEveryPlace) {
  for (std::size_t size = 0; size < 40; ++size) {
    const std::string plain(size, 'a');
    EXPECT_TRUE(plain_ascii(plain));
    for (std::size_t at = 0; at < size; ++at) {
      for (int byte = 0; byte < 256; ++byte) {
        std::string text = plain;
        text[at] = static_cast<char>(byte);
        ASSERT_EQ(plain_ascii(text), byte > 0 && byte < 128) << byte << " at " << at;
      }
    }
  }
}

TEST(Text, MayNotContainNul) {
  EXPECT_TRUE(valid_text("Stäubli"));
  EXPECT_TRUE(valid_text(""));
  EXPECT_TRUE(valid_utf8("a\0b"sv));
  EXPECT_FALSE(valid_text("a\0b"sv));
  EXPECT_FALSE(valid_text("\xFF"));
}

}  // namespace
}  // namespace gecos::wire
