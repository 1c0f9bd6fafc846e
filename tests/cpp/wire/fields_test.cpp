#include "gecos/wire/fields.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "gecos/wire/contents.hpp"
#include "json.hpp"

namespace gecos::wire {
namespace {

using gecos::testing::from_hex;

struct Byte {
  std::uint8_t value = 0;
  bool decode(Decoder& from) { return from.get(value, "Byte.value"); }
};

/// What `read` says of the bytes: "accepted", or the error as people read it.
template <typename Read>
std::string verdict(const std::string& hex, Read read) {
  const Bytes bytes = from_hex(hex);
  Decoder from(bytes);
  const bool accepted = read(from) && from.expect_end();
  return accepted ? "accepted" : from.error().message();
}

TEST(GetBlock, SkipsWhatANewerWriterPutAtItsEnd) {
  Byte byte;
  EXPECT_EQ(verdict("00000003"
                    "070809",
                    [&](Decoder& from) { return get_block(from, byte, "b"); }),
            "accepted");
  EXPECT_EQ(byte.value, 7);
}

TEST(GetBlock, RefusesAValueThatItsBlockDoesNotHold) {
  Byte byte;
  EXPECT_EQ(verdict("00000000"
                    "07",
                    [&](Decoder& from) { return get_block(from, byte, "b"); }),
            "field 'Byte.value' at byte 4: the bytes end before the value does");
}

TEST(GetNumbers, ReadsCountAndNumbers) {
  std::vector<std::int16_t> numbers;
  const auto read = [&](Decoder& from) { return get_numbers(from, numbers, 2, "n"); };
  EXPECT_EQ(verdict("00000002"
                    "0001ffff",
                    read),
            "accepted");
  EXPECT_EQ(numbers, (std::vector<std::int16_t>{1, -1}));
  EXPECT_EQ(verdict("00000003"
                    "000100020003",
                    read),
            "field 'n' at byte 0: more elements than allowed");
  EXPECT_EQ(verdict("00000002"
                    "000100",
                    read),
            "field 'n' at byte 0: the bytes end before the value does");
}

TEST(GetSequence, ReadsElementsAndBooleans) {
  std::vector<Byte> bytes;
  EXPECT_EQ(verdict("00000002"
                    "0102",
                    [&](Decoder& from) {
                      return get_sequence(from, bytes, 1, npos, "s",
                                          [&](Byte& byte) { return byte.decode(from); });
                    }),
            "accepted");
  ASSERT_EQ(bytes.size(), 2u);
  EXPECT_EQ(bytes[1].value, 2);
  std::vector<bool> flags;
  const auto read = [&](Decoder& from) {
    return get_sequence(from, flags, 1, npos, "s", [&](bool& flag) { return from.get(flag, "s"); });
  };
  EXPECT_EQ(verdict("00000002"
                    "0100",
                    read),
            "accepted");
  EXPECT_EQ(flags, (std::vector<bool>{true, false}));
  EXPECT_EQ(verdict("00000002"
                    "0102",
                    read),
            "field 's' at byte 5: a boolean must be 0 or 1");
}

TEST(GetEach, FillsAnArrayAndStopsAtTheFirstFault) {
  std::array<bool, 3> flags{};
  const auto read = [&](Decoder& from) {
    return get_each(flags, [&](bool& flag) { return from.get(flag, "f"); });
  };
  EXPECT_EQ(verdict("010001", read), "accepted");
  EXPECT_EQ(flags, (std::array{true, false, true}));
  EXPECT_EQ(verdict("010301", read), "field 'f' at byte 1: a boolean must be 0 or 1");
}

TEST(GetOptional, IsThereOrNot) {
  std::optional<std::uint8_t> value = 5;
  const auto read = [&](Decoder& from) {
    return get_optional(from, value, "o", [&](std::uint8_t& it) { return from.get(it, "o"); });
  };
  EXPECT_EQ(verdict("00", read), "accepted");
  EXPECT_EQ(value, std::nullopt);
  EXPECT_EQ(verdict("0107", read), "accepted");
  EXPECT_EQ(value, 7);
  EXPECT_EQ(verdict("0207", read), "field 'o' at byte 0: a boolean must be 0 or 1");
  EXPECT_EQ(verdict("01", read), "field 'o' at byte 1: the bytes end before the value does");
}

TEST(GetMap, KeysAscendAndComeOnce) {
  std::map<std::uint8_t, std::uint8_t> entries;
  const auto read = [&](Decoder& from) {
    return get_map(
        from, entries, 2, 3, "m", [&](std::uint8_t& key) { return from.get(key, "m"); },
        [&](std::uint8_t& value) { return from.get(value, "m"); });
  };
  EXPECT_EQ(verdict("00000002"
                    "01070208",
                    read),
            "accepted");
  EXPECT_EQ(entries, (std::map<std::uint8_t, std::uint8_t>{{1, 7}, {2, 8}}));
  EXPECT_EQ(verdict("00000002"
                    "02070108",
                    read),
            "field 'm' at byte 6: the map's keys are not ascending");
  EXPECT_EQ(verdict("00000002"
                    "01070108",
                    read),
            "field 'm' at byte 6: the map's keys are not ascending");
  EXPECT_EQ(verdict("00000004"
                    "0101020203030404",
                    read),
            "field 'm' at byte 0: more elements than allowed");
}

TEST(InRange, RefusesWhereTheNumberBegan) {
  std::uint16_t number = 0;
  const auto read = [&](Decoder& from) {
    return from.get(number, "r") && in_range(from, number <= 9, sizeof number, "r");
  };
  EXPECT_EQ(verdict("0009", read), "accepted");
  EXPECT_EQ(verdict("000a", read), "field 'r' at byte 0: outside its declared range");
}

TEST(Within, SaysWhichNumberIsOutsideWhichLimits) {
  double angle = 0;
  const auto read = [&](Decoder& from) {
    return from.get(angle, "a") && within(from, angle, {-2.0, 2.0}, "a", "[-2.0, 2.0] rad");
  };
  EXPECT_EQ(verdict("4000000000000000", read), "accepted");
  EXPECT_EQ(verdict("4008000000000000", read),
            "field 'a' at byte 0: 3 is outside [-2.0, 2.0] rad; give at most 2.0 rad");
  EXPECT_EQ(verdict("4056800000000000", read),
            "field 'a' at byte 0: 90 is outside [-2.0, 2.0] rad; is the value in degrees?");
  EXPECT_EQ(verdict("7ff8000000000000", read),
            "field 'a' at byte 0: nan is outside [-2.0, 2.0] rad; give a number");
  std::vector<std::uint64_t> counts;
  const auto read_all = [&](Decoder& from) {
    return get_numbers(from, counts, npos, "c") &&
           all_within(from, counts, {.low = 3}, "c", "[3, inf]");
  };
  EXPECT_EQ(verdict("0000000200000000000000030000000000000002", read_all),
            "field 'c' at byte 12: 2 is outside [3, inf]; give at least 3");
}

TEST(OutsideLimits, AsksForTheUnitThatWouldFit) {
  EXPECT_EQ(out_of_range("open.width", 50.0, "[0.0, 0.08] m"),
            "open.width: 50 is outside [0.0, 0.08] m; is the value in millimetres?");
  EXPECT_EQ(out_of_range("open.width", 500.0, "[0.0, 0.08] m"),
            "open.width: 500 is outside [0.0, 0.08] m; give at most 0.08 m");
  EXPECT_EQ(out_of_range("open.width", 0.09, "[0.0, 0.08] m"),
            "open.width: 0.09 is outside [0.0, 0.08] m; give at most 0.08 m");
  EXPECT_EQ(out_of_range("turn", -3.0, "[-inf, 2.0] rad"), "turn: -3 is outside [-inf, 2.0] rad");
  EXPECT_EQ(out_of_range("turn", 90, "[-inf, 2.0] rad"),
            "turn: 90 is outside [-inf, 2.0] rad; is the value in degrees?");
  EXPECT_EQ(out_of_range("count", std::uint64_t{1} << 63U, "[0, 3]"),
            "count: 9223372036854775808 is outside [0, 3]; give at most 3");
}

TEST(GetTag, RefusesWhatTheTagsTypeLacks) {
  std::uint8_t tag = 0;
  const auto read = [&](Decoder& from) { return get_tag<std::int32_t>(from, tag, "t"); };
  EXPECT_EQ(verdict("000000ff", read), "accepted");
  EXPECT_EQ(tag, 255);
  EXPECT_EQ(verdict("00000100", read),
            "field 't' at byte 0: the union's discriminator and members do not agree");
}

TEST(GetArm, IsThereExactlyWhenSelected) {
  const auto read = [](bool selected) {
    return [selected](Decoder& from) { return get_arm(from, selected, "a"); };
  };
  EXPECT_EQ(verdict("01", read(true)), "accepted");
  EXPECT_EQ(verdict("00", read(false)), "accepted");
  EXPECT_EQ(verdict("00", read(true)),
            "field 'a' at byte 0: the union's discriminator and members do not agree");
  EXPECT_EQ(verdict("01", read(false)),
            "field 'a' at byte 0: the union's discriminator and members do not agree");
}

}  // namespace
}  // namespace gecos::wire
