#include "gecos/base/whole_characters.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace gecos {
namespace {

TEST(WholeCharacters, CutsBeforeTheCharacterThatDoesNotFit) {
  EXPECT_EQ(whole_characters("", 0), "");
  EXPECT_EQ(whole_characters("abc", 0), "");
  EXPECT_EQ(whole_characters("abc", 2), "ab");
  EXPECT_EQ(whole_characters("abc", 3), "abc");
  for (const std::string_view character : {"\u00e4", "\u20ac", "\U0001f916"}) {  // 2, 3, 4 bytes
    const std::string text = "a" + std::string(character) + "b";
    for (std::size_t most = 1; most <= character.size(); ++most) {
      EXPECT_EQ(whole_characters(text, most), "a") << most;
    }
    EXPECT_EQ(whole_characters(text, 1 + character.size()), "a" + std::string(character));
  }
}

TEST(WholeCharacters, CutsWhatIsNotUtf8Anywhere) {
  const std::string text(9, '\x80');
  for (std::size_t most = 0; most <= text.size(); ++most) {
    EXPECT_EQ(whole_characters(text, most).size(), most);
  }
}

}  // namespace
}  // namespace gecos
