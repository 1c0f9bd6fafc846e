// What the shared vectors (vectors_test.cpp) cannot say: stickiness, blocks, depth, borrowing.
#include "gecos/wire/decoder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "json.hpp"

namespace gecos::wire {
namespace {

using gecos::testing::from_hex;

TEST(Decoder, KeepsItsFirstFailure) {
  const Bytes bytes = from_hex("02000000");
  Decoder in(bytes);
  bool flag = false;
  ASSERT_FALSE(in.get(flag, "flag"));
  std::uint8_t number = 77;
  std::string text = "kept";
  std::size_t count = 77;
  EXPECT_FALSE(in.get(number, "number"));
  EXPECT_FALSE(in.get_string(text));
  EXPECT_FALSE(in.get_count(count, 0));
  EXPECT_FALSE(in.get_array(std::span<double>{}));
  EXPECT_FALSE(in.get_bytes({}));
  EXPECT_FALSE(in.fail(DecodeProblem::OutOfRange, "later"));
  EXPECT_FALSE(in.expect_end());
  EXPECT_FALSE(in.at_end());
  EXPECT_TRUE(in.failed());
  EXPECT_EQ(in.remaining(), 0u);
  EXPECT_EQ(number, 77);
  EXPECT_EQ(text, "kept");
  EXPECT_EQ(count, 77u);
  EXPECT_EQ(in.error(), (DecodeError{DecodeProblem::InvalidBoolean, 0, "flag"}));
  EXPECT_EQ(in.error().message(), "field 'flag' at byte 0: a boolean must be 0 or 1");
}

TEST(Decoder, LeavesTheValueAloneWhenItRefuses) {
  const Bytes bytes = from_hex("0000000461620063");
  Decoder in(bytes);
  std::string text = "kept";
  EXPECT_FALSE(in.get_string(text));
  EXPECT_EQ(text, "kept");
  EXPECT_EQ(in.error().problem, DecodeProblem::MissingNul);
}

TEST(Decoder, LendsStringsAndBytes) {
  const Bytes bytes = from_hex("0000000361620001020304");
  Decoder in(bytes);
  std::string_view text;
  ByteView view;
  ASSERT_TRUE(in.get_string_view(text));
  EXPECT_EQ(text, "ab");
  EXPECT_EQ(text.data(), reinterpret_cast<const char*>(bytes.data()) + 4);
  ASSERT_TRUE(in.get_view(view, 4));
  EXPECT_EQ(view.data(), bytes.data() + 7);
  EXPECT_TRUE(in.at_end());
  EXPECT_FALSE(in.get_view(view, 1, "more"));
  EXPECT_EQ(in.error(), (DecodeError{DecodeProblem::Truncated, 11, "more"}));
}

TEST(Decoder, FillsAnyRunOfNumbers) {
  const Bytes bytes = from_hex("00010002ffffff");
  Decoder in(bytes);
  std::array<std::int16_t, 2> pair{};
  std::vector<std::uint8_t> rest(3);
  ASSERT_TRUE(in.get_array(pair));
  ASSERT_TRUE(in.get_array(rest));
  EXPECT_EQ(pair, (std::array<std::int16_t, 2>{1, 2}));
  EXPECT_EQ(rest, (std::vector<std::uint8_t>{255, 255, 255}));
}

TEST(Decoder, ABlockFailsForItsOuterDecoderToo) {
  const Bytes bytes = from_hex(
      "00000001"
      "05"
      "0000");
  Decoder outer(bytes);
  Decoder inner;
  ASSERT_TRUE(outer.open_block(inner));
  std::int16_t number = 0;
  EXPECT_FALSE(inner.get(number, "inner"));
  EXPECT_FALSE(outer.failed());
  EXPECT_FALSE(outer.close_block(inner));
  EXPECT_TRUE(outer.failed());
  EXPECT_FALSE(outer.get(number, "after"));
  EXPECT_EQ(outer.error(), (DecodeError{DecodeProblem::Truncated, 4, "inner"}));
}

TEST(Decoder, ABlockMayHaveMoreThanItsReaderKnows) {
  const Bytes bytes = from_hex(
      "00000003"
      "050607"
      "09");
  Decoder outer(bytes);
  Decoder inner;
  std::uint8_t number = 0;
  ASSERT_TRUE(outer.open_block(inner));
  ASSERT_TRUE(inner.get(number));
  EXPECT_EQ(number, 5);
  ASSERT_TRUE(outer.close_block(inner));
  ASSERT_TRUE(outer.get(number));
  EXPECT_EQ(number, 9);
  EXPECT_TRUE(outer.expect_end());
}

TEST(Decoder, DepthIsGivenBack) {
  Decoder in{ByteView{}};
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < max_depth - 1; ++i) ASSERT_TRUE(in.enter());
    {
      const DepthGuard deepest(in);
      EXPECT_TRUE(deepest);
    }
    for (int i = 0; i < max_depth - 1; ++i) in.leave();
  }
  EXPECT_FALSE(in.failed());
}

TEST(Decoder, ASeventeenthLevelIsRefused) {
  Decoder in{ByteView{}};
  for (int i = 0; i < max_depth; ++i) ASSERT_TRUE(in.enter());
  const DepthGuard deepest(in, "tree");
  EXPECT_FALSE(deepest);
  EXPECT_EQ(in.error(), (DecodeError{DecodeProblem::TooDeep, 0, "tree"}));
}

TEST(DecodeError, EveryProblemHasAText) {
  for (int i = 0; i <= static_cast<int>(DecodeProblem::InvalidValue); ++i) {
    EXPECT_STRNE(describe(static_cast<DecodeProblem>(i)), "unknown problem") << i;
  }
  EXPECT_EQ((DecodeError{DecodeProblem::TrailingBytes, 3, ""}).message(),
            "at byte 3: bytes are left over");
}

}  // namespace
}  // namespace gecos::wire
