#include "gecos/base/short_bytes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace gecos {
namespace {

Bytes counting(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i);
  return bytes;
}

TEST(ShortBytes, HoldsAnyNumberOfBytes) {
  for (const std::size_t size : {0u, 1u, 127u, 128u, 129u, 4000u}) {
    const Bytes bytes = counting(size);
    EXPECT_TRUE(std::ranges::equal(ShortBytes(bytes).view(), bytes)) << size;
  }
}

TEST(ShortBytes, IsAssignedFewAfterManyAndManyAfterFew) {
  ShortBytes bytes;
  EXPECT_TRUE(bytes.view().empty());
  for (const std::size_t size : {500u, 3u, 129u, 0u, 128u}) {
    bytes.assign(counting(size));
    EXPECT_TRUE(std::ranges::equal(bytes.view(), counting(size))) << size;
  }
}

}  // namespace
}  // namespace gecos
