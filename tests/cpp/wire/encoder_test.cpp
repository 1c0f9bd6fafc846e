#include "gecos/wire/encoder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "json.hpp"

namespace gecos::wire {
namespace {

using gecos::testing::to_hex;

template <typename Write>
std::string encoded(Write write) {
  Bytes bytes(64, std::byte{0xEE});
  Encoder encoder(bytes);
  write(encoder);
  bytes.resize(encoder.written());
  return to_hex(bytes);
}

TEST(Encoder, WritesNumbersBigEndian) {
  EXPECT_EQ(encoded([](Encoder& to) { to.put(std::int8_t{-2}); }), "fe");
  EXPECT_EQ(encoded([](Encoder& to) { to.put(std::uint16_t{0x1234}); }), "1234");
  EXPECT_EQ(encoded([](Encoder& to) { to.put(std::int32_t{-2}); }), "fffffffe");
  EXPECT_EQ(encoded([](Encoder& to) { to.put(std::uint64_t{1}); }), "0000000000000001");
  EXPECT_EQ(encoded([](Encoder& to) { to.put(1.0F); }), "3f800000");
  EXPECT_EQ(encoded([](Encoder& to) { to.put(-2.0); }), "c000000000000000");
}

TEST(Encoder, WritesManyAtOnceAsOneAfterTheOther) {
  const auto write = [](Encoder& to) { to.put(true, std::int16_t{1}, false, 1.0F); };
  EXPECT_EQ(encoded(write), "010001003f800000");
}

TEST(Encoder, WritesBooleansAsOneByte) {
  EXPECT_EQ(encoded([](Encoder& to) {
              to.put(true);
              to.put(false);
            }),
            "0100");
}

TEST(Encoder, WritesStringsWithLengthAndNul) {
  EXPECT_EQ(encoded([](Encoder& to) { to.put_string("abc"); }), "0000000461626300");
  EXPECT_EQ(encoded([](Encoder& to) { to.put_string(""); }), "0000000100");
  EXPECT_EQ(string_size("abc"), 8u);
}

TEST(Encoder, WritesArraysOfEveryShapeWithoutACount) {
  const std::vector<std::int16_t> list{1, -1};
  const std::array<double, 1> array{1.0};
  const std::uint8_t plain[]{7, 8};
  EXPECT_EQ(encoded([&](Encoder& to) { to.put_array(list); }), "0001ffff");
  EXPECT_EQ(encoded([&](Encoder& to) { to.put_array(array); }), "3ff0000000000000");
  EXPECT_EQ(encoded([&](Encoder& to) { to.put_array(std::span(plain)); }), "0708");
  EXPECT_EQ(encoded([&](Encoder& to) { to.put_array(std::vector<double>{}); }), "");
}

TEST(Encoder, WritesCountsAndBytesOneAfterTheOther) {
  const std::array bytes{std::byte{1}, std::byte{2}};
  EXPECT_EQ(encoded([&](Encoder& to) {
              to.put_count(bytes.size());
              to.put_bytes(bytes);
              to.put_bytes({});
            }),
            "000000020102");
}

}  // namespace
}  // namespace gecos::wire
