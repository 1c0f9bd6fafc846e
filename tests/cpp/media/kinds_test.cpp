#include "gecos/media/kinds.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

namespace gecos::media {
namespace {

TEST(Open, HowFarLcmGoesIsANumberOfRouters) {
  for (const char* const right : {"", "0", "1", "255"}) {
    setenv("GECOS_LCM_TTL", right, 1);
    EXPECT_TRUE(open(Kind::Lcm)) << right;
  }
  for (const char* const wrong : {"-1", "256", "1 ", "far"}) {
    setenv("GECOS_LCM_TTL", wrong, 1);
    const auto opened = open(Kind::Lcm);
    ASSERT_FALSE(opened) << wrong;
    EXPECT_EQ(opened.error().text,
              "lcm: GECOS_LCM_TTL is '" + std::string(wrong) +
                  "'; it says how many routers a packet may pass, 0 (this host alone) to 255");
  }
  unsetenv("GECOS_LCM_TTL");
}

}  // namespace
}  // namespace gecos::media
