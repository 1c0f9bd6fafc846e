#include "gecos/base/checked_result.hpp"

#include <gtest/gtest.h>

namespace gecos {
namespace {

using Length = Checked<std::string, std::string>;

TEST(CheckedResult, GivesItsValue) {
  Length length = std::string("3 m");
  EXPECT_EQ(*length, "3 m");
  EXPECT_EQ(length->size(), 3u);
  EXPECT_EQ(*std::move(length), "3 m");
}

TEST(CheckedResultDeathTest, EndsTheProgramWithTheTextOfItsErrorWhenUsedUnchecked) {
  const Length none = tl::unexpected(std::string("the sensor is not plugged in"));
  const char* const says = "holds an error: the sensor is not plugged in. Check a result";
  EXPECT_DEATH(static_cast<void>(none->size()), says);
  EXPECT_DEATH(static_cast<void>(*none), says);
}

}  // namespace
}  // namespace gecos
