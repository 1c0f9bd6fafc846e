// Whom the list of revocations of a laboratory refuses.

#include "gecos/access/revocations.hpp"

#include <gtest/gtest.h>

namespace gecos::access {
namespace {

const std::string key_of_ben(64, 'b'), key_of_anna(64, 'a');
const UserAtHost ben{"ben", "desk"}, ben_elsewhere{"ben", "bench"}, anna{"anna", "desk"}, nobody{};

TEST(Revocations, OfAKeyRefuseThisKeyWhoeverHasIt) {
  const std::vector<RevokedUser> list{{key_of_ben, "ben@desk"}};
  EXPECT_TRUE(revokes(list, key_of_ben, ben));
  EXPECT_TRUE(revokes(list, key_of_ben, nobody)) << "a key without an owner";
  EXPECT_TRUE(revokes(list, key_of_ben, anna)) << "another host gives the key another owner";
  EXPECT_FALSE(revokes(list, key_of_anna, ben)) << "another key of the same owner";
  EXPECT_FALSE(revokes(list, "", ben)) << "the kernel names this user";
}

TEST(Revocations, OfAnOwnerRefuseAllKeysOfThisOwnerAndNoOther) {
  const std::vector<RevokedUser> here{{"", "ben@desk"}}, everywhere{{"", "ben"}};
  EXPECT_TRUE(revokes(here, key_of_anna, ben));
  EXPECT_TRUE(revokes(here, "", ben));
  EXPECT_FALSE(revokes(here, key_of_ben, ben_elsewhere));
  EXPECT_TRUE(revokes(everywhere, key_of_ben, ben_elsewhere));
  for (const auto& list : {here, everywhere}) {
    EXPECT_FALSE(revokes(list, key_of_ben, anna));
    EXPECT_FALSE(revokes(list, key_of_ben, nobody));
  }
  EXPECT_FALSE(revokes({}, key_of_ben, ben));
}

TEST(Revocations, AreReadFromTheLinesOfAFile) {
  const auto list = read_revocations(key_of_ben + " ben@desk\n- anna\n" + key_of_anna + " -\n");
  ASSERT_TRUE(list) << list.error();
  EXPECT_EQ(*list,
            (std::vector<RevokedUser>{{key_of_ben, "ben@desk"}, {"", "anna"}, {key_of_anna, ""}}));
  EXPECT_TRUE(read_revocations("")->empty());
}

TEST(Revocations, WithAnErrorNameTheLine) {
  for (const std::string wrong : {"ben@desk", "- -", "-", "- ", "beef ben@desk", ""}) {
    const auto list = read_revocations(key_of_ben + " ben@desk\n" + wrong + "\n");
    ASSERT_FALSE(list) << wrong;
    EXPECT_EQ(list.error(),
              "line 2 must be a key of 64 hexadecimal digits, a blank and the owner of the key")
        << wrong;
  }
}

TEST(Revocations, HaveANumberThatIsEqualForEqualTextsAloneAnd0ForNone) {
  EXPECT_EQ(number_of_revocations(""), 0u);
  EXPECT_EQ(number_of_revocations("- ben\n"), number_of_revocations("- ben\n"));
  EXPECT_NE(number_of_revocations("- ben\n"), number_of_revocations("- bem\n"));
  EXPECT_NE(number_of_revocations("- ben\n"), 0u);
}

}  // namespace
}  // namespace gecos::access
