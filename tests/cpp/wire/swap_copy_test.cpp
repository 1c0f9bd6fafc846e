#include "gecos/wire/swap_copy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "gecos/base/bytes.hpp"

namespace gecos::wire {
namespace {

constexpr std::size_t most = 133;       // several vector steps and every remainder
constexpr std::size_t alignments = 65;  // each offset in the widest register, and one around
constexpr std::byte untouched{0xA5};

Bytes pattern(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 89 + 7);
  return bytes;
}

// Reversed one element after the other, by nothing but indexes.
Bytes expected_swap(ByteView from, std::size_t width) {
  Bytes swapped(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    swapped[i] = from[i / width * width + (width - 1 - i % width)];
  }
  return swapped;
}

template <typename Copy>
void check_all_lengths_and_alignments(std::size_t width, Copy copy) {
  const Bytes source = pattern(most * width + 2 * alignments);
  for (std::size_t count = 0; count <= most; ++count) {
    for (std::size_t shift = 0; shift < alignments; ++shift) {
      const std::size_t from = shift;
      const std::size_t to = (shift * 7 + count) % alignments;
      Bytes target(most * width + 2 * alignments, untouched);
      copy(target.data() + to, source.data() + from, count);
      Bytes expected(target.size(), untouched);
      const Bytes swapped = expected_swap(ByteView(source).subspan(from, count * width), width);
      std::copy(swapped.begin(), swapped.end(), expected.begin() + static_cast<std::ptrdiff_t>(to));
      ASSERT_EQ(target, expected) << count << " elements of " << width << " from +" << from
                                  << " to +" << to;
    }
  }
}

struct Loop {
  detail::SwapKind kind;
  std::size_t width;
};

void PrintTo(const Loop& loop, std::ostream* out) {
  static constexpr const char* names[] = {"portable", "SSSE3", "AVX2", "AVX-512"};
  *out << names[static_cast<int>(loop.kind)] << ", " << loop.width << " bytes";
}

class SwapLoop : public ::testing::TestWithParam<Loop> {};

TEST_P(SwapLoop, ReversesEveryLengthAtEveryAlignmentAndNothingElse) {
  const detail::SwapKind kind = GetParam().kind;
  const std::size_t width = GetParam().width;
  if (!detail::swap_copy_with(kind, width, nullptr, nullptr, 0)) {
    GTEST_SKIP() << "this machine does not have it";
  }
  check_all_lengths_and_alignments(width,
                                   [&](std::byte* to, const std::byte* from, std::size_t count) {
                                     detail::swap_copy_with(kind, width, to, from, count);
                                   });
}

using enum detail::SwapKind;
INSTANTIATE_TEST_SUITE_P(Kinds, SwapLoop,
                         ::testing::Values(Loop{Portable, 2}, Loop{Portable, 4}, Loop{Portable, 8},
                                           Loop{Ssse3, 2}, Loop{Ssse3, 4}, Loop{Ssse3, 8},
                                           Loop{Avx2, 2}, Loop{Avx2, 4}, Loop{Avx2, 8},
                                           Loop{Avx512, 2}, Loop{Avx512, 4}, Loop{Avx512, 8}));

template <std::size_t width>
void check_chosen() {
  check_all_lengths_and_alignments(width,
                                   [](std::byte* to, const std::byte* from, std::size_t count) {
                                     swap_copy<width>(to, from, count);
                                   });
}

TEST(SwapCopy, ReversesOnALittleEndianHost) {
  if (std::endian::native == std::endian::big) GTEST_SKIP() << "here it copies";
  check_chosen<2>();
  check_chosen<4>();
  check_chosen<8>();
}

TEST(SwapCopy, CopiesBytesAsTheyAre) { check_chosen<1>(); }

TEST(SwapCopy, StoresTheMostSignificantByteFirst) {
  std::array<std::byte, 4> bytes{};
  store_big_endian(bytes.data(), std::uint32_t{0x01020304});
  EXPECT_EQ(bytes, (std::array{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}}));
  EXPECT_EQ(load_big_endian<std::uint32_t>(bytes.data()), 0x01020304u);
  EXPECT_EQ(load_big_endian<std::int16_t>(bytes.data() + 2), 0x0304);
}

}  // namespace
}  // namespace gecos::wire
