#include "gecos/access/password_limit.hpp"

#include <gtest/gtest.h>

namespace gecos::access {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint start{10min};

/// A limit for which `user` has given a wrong password each second, `times` times, from `start` on.
PasswordLimit after_wrong(int times) {
  PasswordLimit limit;
  for (int second = 0; second < times; ++second) limit.count_wrong("bob", start + second * 1s);
  return limit;
}

TEST(PasswordLimit, LetsAUserTryAfterFourWrongPasswords) {
  EXPECT_EQ(after_wrong(4).wait("bob", start + 4s), 0s);
}

TEST(PasswordLimit, LetsAUserWaitAfterFiveUntilTheFirstIsAMinuteOld) {
  const PasswordLimit limit = after_wrong(5);
  EXPECT_EQ(limit.wait("bob", start + 4s), 56s);
  EXPECT_EQ(limit.wait("bob", start + 59s), 1s);
  EXPECT_EQ(limit.wait("bob", start + 60s), 0s);
}

TEST(PasswordLimit, GivesOneTryForEachWrongPasswordThatIsAMinuteOld) {
  PasswordLimit limit = after_wrong(5);
  limit.count_wrong("bob", start + 60s);
  EXPECT_EQ(limit.wait("bob", start + 60s), 1s);
  EXPECT_EQ(limit.wait("bob", start + 61s), 0s);
}

TEST(PasswordLimit, IsOfEachUserAlone) { EXPECT_EQ(after_wrong(5).wait("ada", start + 4s), 0s); }

}  // namespace
}  // namespace gecos::access
