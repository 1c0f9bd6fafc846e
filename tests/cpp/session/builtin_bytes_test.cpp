// The bytes of built-in operations and of broker calls, as they were when the session coded them by
// hand: clients and servers of before and after understand each other.
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "gecos/broker_calls.hpp"
#include "gecos/broker_interface.hpp"
#include "gecos/object_calls.hpp"
#include "gecos/object_interface.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

std::string hex(ByteView bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    text += digits[std::to_integer<std::size_t>(byte) >> 4];
    text += digits[std::to_integer<std::size_t>(byte) & 0xf];
  }
  return text;
}

/// Written as these bytes, and read from them.
template <class T>
void expect_bytes(const T& value, std::string_view bytes) {
  const Bytes written = layout::to_bytes(value);
  EXPECT_EQ(hex(written), bytes);
  const auto read = layout::from_bytes<T>(written);
  ASSERT_TRUE(read) << bytes << ": " << read.error().message();
  EXPECT_EQ(hex(layout::to_bytes(*read)), bytes);
}

Holder holder() { return {Status::MASTER, "eva", "lab", "demo", 42, 1.5, 0.25, true, true, 0.5}; }

Description description() {
  return {"RX90",
          "robcl::Rx90",
          "1.0",
          0x0123456789abcdef,
          true,
          "p",
          "a",
          7,
          2,
          "move",
          42,
          "confirmed",
          {{"move", 0.5, "eva", "lab", "demo", 43, ""}}};
}

Entry entry() {
  return {"RX90", "robcl::Rx90", {"robcl::Device"}, 9,    5, 42, "eva",
          "h",    "lab",         {"shm:/x"},        true, 6};
}

TEST(BuiltInOperations, AHolderThatAnOlderServerTellsHasNotTakenOver) {
  const Bytes whole = wire::to_bytes(holder());
  constexpr std::size_t newer = 1 + 8;  // the size of `taken_over` and `taken_over_for`
  const auto read = wire::from_bytes<Holder>(ByteView(whole).first(whole.size() - newer));
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(read->releasing);
  EXPECT_FALSE(read->taken_over);
  EXPECT_EQ(read->taken_over_for, 0);
}

TEST(BuiltInOperations, KeepTheirBytes) {
  expect_bytes(GecosObject_holders_result{{holder()}},
               "000000010000003b000000020000000465766100000000046c6162000000000564656d6f00000000"
               "2a3ff80000000000003fd000000000000001013fe0000000000000");
  expect_bytes(GecosObject_describe_result{description()},
               "000000980000000552583930000000000c726f62636c3a3a527839300000000004312e3000012345"
               "6789abcdef01000000027000000000026100000000000000000700000002000000056d6f76650000"
               "00002a0000000a636f6e6669726d6564000000000100000033000000056d6f7665003fe000000000"
               "00000000000465766100000000046c6162000000000564656d6f000000002b0000000100");
  expect_bytes(GecosObject_acquire_arguments{Status::ACTOR, "two hands"},
               "00000001010000000a74776f2068616e6473000000000000000000");
  expect_bytes(GecosObject_acquire_arguments{Status::MASTER, {}, 2.5},
               "00000002004004000000000000");
  expect_bytes(GecosObject_acquire_result{{Status::ACTOR, 11}}, "0000000c00000001000000000000000b");
  expect_bytes(GecosObject_release_arguments{11, true}, "000000000000000b01");
  expect_bytes(GecosObject_subscribe_arguments{0x6755a361}, "6755a361");
  expect_bytes(GecosObject_subscribe_result{{3, 7}}, "000000030000000000000007");
  expect_bytes(GecosObject_unsubscribe_arguments{0x6755a361}, "6755a361");
  expect_bytes(GecosObject_outcome_arguments{5, 9, 4},
               "000000000000000500000000000000090000000000000004");
  expect_bytes(GecosObject_outcome_result{{5, "done"}}, "0000000a0500000005646f6e6500");
  expect_bytes(GecosObject_feed_arguments{0x6755a361, 3}, "6755a36100000003");
  expect_bytes(GecosObject_feed_result{true}, "01");
  expect_bytes(GecosObject_end_feed_arguments{0x6755a361, 3}, "6755a36100000003");
  expect_bytes(GecosObject_feed_report_arguments{0x6755a361}, "6755a361");
  FeedReport report;
  report.admitted = 3;
  report.no_status = 1;
  report.last_refusal = "late";
  report.expired = true;
  const std::string none(16, '0');
  expect_bytes(GecosObject_feed_report_result{report}, "000000520000000000000003" + none + none +
                                                           none + "0000000000000001" + none + none +
                                                           none + none + "000000056c6174650001");
}

TEST(BrokerCalls, KeepTheirBytes) {
  expect_bytes(Broker_enlist_arguments{entry(), 2.5, {}, {}},
               "000000710000000552583930000000000c726f62636c3a3a5278393000000000010000000e726f62"
               "636c3a3a44657669636500000000000000000900000000000000050000002a000000046576610000"
               "0000026800000000046c616200000000010000000773686d3a2f7800010000000000000006400400000"
               "00000000000");
  expect_bytes(Broker_lookup_arguments{"RX90"}, "000000055258393000");
  expect_bytes(Broker_withdraw_arguments{"RX90"}, "000000055258393000");
  expect_bytes(Broker_lookup_result{entry()},
               "000000710000000552583930000000000c726f62636c3a3a5278393000000000010000000e726f62"
               "636c3a3a44657669636500000000000000000900000000000000050000002a000000046576610000"
               "0000026800000000046c616200000000010000000773686d3a2f7800010000000000000006");
  expect_bytes(
      Broker_list_result{{entry()}},
      "00000001000000710000000552583930000000000c726f62636c3a3a527839300000000001000000"
      "0e726f62636c3a3a44657669636500000000000000000900000000000000050000002a0000000465"
      "766100000000026800000000046c616200000000010000000773686d3a2f7800010000000000000006");
}

TEST(BrokerCalls, ReadTheAnswerOfABrokerThatSaysLess) {
  const auto read = layout::from_bytes<Broker_enlist_result>({});
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->settles_in, std::nullopt);
}

TEST(BrokerCalls, ReadTheQuestionOfAServerThatSaysLess) {
  Bytes told = layout::to_bytes(Broker_enlist_arguments{entry(), 2.5, {}, 1.5});
  told.resize(told.size() - 1 - sizeof(double));  // neither that `confirmed_ago` has a value nor it
  const auto read = layout::from_bytes<Broker_enlist_arguments>(told);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->served_for, 2.5);
  EXPECT_EQ(read->confirmed_ago, std::nullopt);
}

TEST(BuiltInOperations, KeepTheirCodes) {
  std::uint32_t code = 0;
  for (const OperationDescription& operation : GecosObjectInterface::operations) {
    EXPECT_EQ(number(operation.code), ++code) << operation.name;
    EXPECT_TRUE(is_builtin(operation.code)) << operation.name;
  }
  EXPECT_EQ(code, 20u);
  EXPECT_EQ(number(BrokerInterface::enlist.code), 0x17d413ce);
  EXPECT_EQ(number(BrokerInterface::lookup.code), 0x49e3d3e3);
  EXPECT_EQ(number(BrokerInterface::withdraw.code), 0xc5ebb42f);
  EXPECT_FALSE(is_builtin(BrokerInterface::enlist.code));
}

}  // namespace
}  // namespace gecos::session
