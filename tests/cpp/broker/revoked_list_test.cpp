// The file of revocations as the broker reads it.

#include "gecos/broker/revoked_list.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "../media/scratch_directory.hpp"

namespace gecos::broker {
namespace {

class RevokedListTest : public ::testing::Test {
 protected:
  void write(const std::string& text, ::mode_t mode = 0600) const {
    std::ofstream(path) << text;
    ASSERT_EQ(::chmod(path.c_str(), mode), 0);
  }
  const media::ScratchDirectory directory;
  const std::string path = directory.path() + "/revoked";
  RevokedList list{path};
};

TEST_F(RevokedListTest, IsEmptyWithoutAFile) {
  const auto found = list.read();
  ASSERT_TRUE(found) << found.error();
  EXPECT_EQ((*found)->number, 0u);
  EXPECT_TRUE((*found)->revoked.empty());
}

TEST_F(RevokedListTest, IsReadAgainEachTime) {
  write("- ben@desk\n");
  const auto before = list.read();
  ASSERT_TRUE(before) << before.error();
  EXPECT_EQ((*before)->revoked, (std::vector<access::RevokedUser>{{"", "ben@desk"}}));
  write("- ben@desk\n- anna\n");
  const auto after = list.read();
  ASSERT_TRUE(after) << after.error();
  EXPECT_EQ((*after)->revoked.size(), 2u);
  EXPECT_NE((*after)->number, (*before)->number);
}

TEST_F(RevokedListTest, SaysWhichLineHasAnError) {
  write("ben@desk\n");
  const auto found = list.read();
  ASSERT_FALSE(found);
  EXPECT_EQ(
      found.error(),
      path + ": line 1 must be a key of 64 hexadecimal digits, a blank and the owner of the key");
}

TEST_F(RevokedListTest, DoesNotCountIfOtherUsersMayWriteIt) {
  write("- ben@desk\n", 0622);
  const auto found = list.read();
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().find("other users may write to the file"), std::string::npos);
}

}  // namespace
}  // namespace gecos::broker
