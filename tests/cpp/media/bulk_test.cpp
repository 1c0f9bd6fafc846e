// Large packets beside a ring: both sides in one mapping, so that a thread sanitizer sees them.

#include "gecos/media/buffers/bulk.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <random>
#include <thread>

#include "../same_bytes.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t few_slots = 64;
constexpr std::size_t image = 2'000'000;

Bytes packet(std::size_t size, std::uint64_t seed) {
  constexpr std::size_t period = 256 * 256;
  Bytes bytes(size);
  for (std::size_t i = 0; i < std::min(size, period); ++i) {
    bytes[i] = static_cast<std::byte>(i * 31 + i / 256 + seed);
  }
  for (std::size_t at = period; at < size; at += period) {
    std::copy_n(bytes.begin(), std::min(period, size - at), &bytes[at]);
  }
  return bytes;
}

struct Areas final : AreaMaker {
  explicit Areas(BulkReader& to) : reader(to) {}
  std::shared_ptr<Mapping> make_area(std::uint64_t number) override {
    if (none_left) return nullptr;
    made.push_back(std::make_shared<Mapping>(Mapping::anonymous(area_bytes)));
    reader.know(number, made.back());
    return made.back();
  }
  bool release(std::uint64_t number) override {
    if (none_left) return false;
    reader.end(number);
    given_back = number;
    return true;
  }
  BulkReader& reader;
  std::vector<std::shared_ptr<Mapping>> made;
  std::uint64_t given_back = 0;
  bool none_left = false;
};

struct TwoSides {
  Mapping a = Mapping::anonymous(RingMemory::bytes(few_slots));
  Mapping b = Mapping::anonymous(RingMemory::bytes(few_slots));
  RingMemory writer_memory = RingMemory::at(a.data(), few_slots);
  RingMemory reader_memory = RingMemory::at(b.data(), few_slots);
  int looks = 0;
  BulkReader source{[this] { ++looks; }};
  Areas areas{source};
  RingWriter ring{writer_memory};
  BulkWriter writer{ring, areas};
  RingReader reader{*reader_memory.control, writer_memory, &source};
  TwoSides() { ring.set_reader(reader_memory.control); }

  void expect_next(const Bytes& sent) {
    const auto got = reader.read();
    ASSERT_TRUE(got);
    EXPECT_TRUE(same_bytes(*got, sent)) << got->size() << " bytes, of " << sent.size();
  }
  void rest_for(unsigned beats) {
    for (unsigned i = 0; i < beats; ++i) writer.beat();
  }
};

TEST(Bulk, KeepsTheOrderAndTheCountOfLargeAndSmallPackets) {
  TwoSides side;
  std::uint64_t number = 0;
  std::vector<Bytes> sent;
  for (const std::size_t size : {std::size_t{10}, image, std::size_t{0}, largest_ring_packet + 1,
                                 std::size_t{300}, image + 1}) {
    sent.push_back(packet(size, size));
    const ByteView head = ByteView(sent.back()).first(size / 3);
    const ByteView body = ByteView(sent.back()).subspan(size / 3);
    const auto as =
        size > largest_ring_packet ? side.writer.write(head, body) : side.ring.write(head, body);
    ASSERT_TRUE(as);
    EXPECT_EQ(*as, ++number);
  }
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_EQ(side.ring.taken(), i);
    side.expect_next(sent[i]);
  }
  EXPECT_FALSE(side.reader.read());
  EXPECT_EQ(side.ring.taken(), sent.size());
}

TEST(Bulk, CarriesTheLargestAndNothingLarger) {
  TwoSides side;
  EXPECT_EQ(side.writer.write({}, Bytes(largest_bulk_packet + 1)).error(), SendProblem::TooLarge);
  EXPECT_TRUE(side.areas.made.empty()) << "memory is made when it is needed";
  const Bytes largest = packet(largest_bulk_packet, 1);
  ASSERT_TRUE(side.writer.write(largest, {}));
  side.expect_next(largest);
}

TEST(Bulk, OneAtATimeLiesAlwaysInTheSameMemory) {
  TwoSides side;
  const std::byte* first = nullptr;
  for (int i = 0; i < 200; ++i) {
    const auto place = side.writer.place(image);
    ASSERT_EQ(place.size(), image);
    if (first == nullptr) first = place.data();
    ASSERT_EQ(place.data(), first);
    side.writer.send_placed();
    ASSERT_TRUE(side.reader.read());
  }
  EXPECT_EQ(side.areas.made.size(), 1u);
}

TEST(Bulk, APlaceThatIsNotSentIsDroppedWithTheNext) {
  TwoSides side;
  const auto dropped = side.writer.place(image);
  ASSERT_FALSE(dropped.empty());
  const Bytes sent = packet(largest_ring_packet + 1, 3);
  ASSERT_EQ(side.writer.write(sent, {}), 1u);
  side.expect_next(sent);
  EXPECT_FALSE(side.reader.read());
}

TEST(Bulk, SaysFullUntilTheReaderHasTakenAndLosesNothing) {
  TwoSides side;
  std::deque<Bytes> sent;
  std::mt19937_64 random(5);
  const auto send = [&] {
    Bytes next = packet(1'000'000 + random() % 7'000'000, random());
    const auto as = side.writer.write(next, {});
    if (as) sent.push_back(std::move(next));
    return as;
  };
  for (int round = 0; round < 6; ++round) {
    auto as = send();
    while (as) as = send();
    ASSERT_EQ(as.error(), SendProblem::Full);
    ASSERT_GT(sent.size(), 4u);
    for (std::size_t take = 1 + random() % sent.size(); take > 0; --take) {
      side.expect_next(sent.front());
      sent.pop_front();
    }
  }
  while (!sent.empty()) side.expect_next(sent.front()), sent.pop_front();
  EXPECT_TRUE(side.writer.write(Bytes(largest_bulk_packet), {})) << "all of it is free again";
}

TEST(Bulk, AFullRingIsFullForLargePacketsToo) {
  TwoSides side;
  while (side.ring.write({}, {})) {
  }
  EXPECT_EQ(side.writer.write(Bytes(image), {}).error(), SendProblem::Full);
  ASSERT_TRUE(side.reader.read());
  EXPECT_TRUE(side.writer.write(Bytes(image), {}));
}

TEST(Bulk, SaysFullWhenTheMemoryCannotBeHad) {
  TwoSides side;
  side.areas.none_left = true;
  EXPECT_EQ(side.writer.write(Bytes(image), {}).error(), SendProblem::Full);
  side.areas.none_left = false;
  EXPECT_TRUE(side.writer.write(Bytes(image), {}));
}

TEST(Bulk, MemoryThatIsNotUsedIsGivenBackOnceAllIsTaken) {
  TwoSides side;
  const Bytes sent = packet(image, 1);
  ASSERT_TRUE(side.writer.write(sent, {}));
  side.rest_for(3 * area_kept);
  EXPECT_EQ(side.areas.given_back, 0u) << "the reader has not taken it";
  side.expect_next(sent);
  side.areas.none_left = true;
  side.rest_for(1);
  EXPECT_EQ(side.areas.made[0].use_count(), 3) << "the reader could not be told";
  side.areas.none_left = false;
  side.rest_for(1);
  EXPECT_EQ(side.areas.given_back, 1u);
  EXPECT_EQ(side.areas.made[0].use_count(), 1) << "neither side holds it";
  EXPECT_FALSE(side.reader.read());
  side.source.rest();

  ASSERT_TRUE(side.writer.write(sent, {}));
  side.expect_next(sent);
  EXPECT_EQ(side.areas.made.size(), 2u);
  for (unsigned i = 0; i < 3 * area_kept; ++i) {
    side.writer.beat();
    if (i % area_kept == 0) {
      ASSERT_TRUE(side.writer.write(sent, {}));
      side.expect_next(sent);
    }
  }
  EXPECT_EQ(side.areas.made.size(), 2u) << "it was in use";
}

TEST(Bulk, AReaderThatNeverTakesOrLiesOnlyKeepsItFull) {
  TwoSides side;
  while (side.writer.write(Bytes(image), {})) {
  }
  for (const std::uint64_t lie : {~std::uint64_t{0}, std::uint64_t{few_slots + 1}}) {
    side.reader_memory.control->slots_taken.store(lie);
    side.reader_memory.control->packets_taken.store(lie);
    EXPECT_EQ(side.writer.write(Bytes(image), {}).error(), SendProblem::Full);
  }
}

TEST(Bulk, AWriterThatLiesAboutAPlaceBreaksTheRing) {
  constexpr std::uint64_t all_ones = ~std::uint64_t{0};
  for (const BulkPlace lie :
       {BulkPlace{2, 0, image}, BulkPlace{0, 0, image}, BulkPlace{all_ones, 0, image},
        BulkPlace{1, 0, 0}, BulkPlace{1, 0, largest_bulk_packet + 1}, BulkPlace{1, 0, all_ones},
        BulkPlace{1, all_ones, image}, BulkPlace{1, area_bytes, image},
        BulkPlace{1, area_bytes - image + 1, image}, BulkPlace{1, all_ones - image + 1, image},
        BulkPlace{1, 4 * image, image}}) {
    TwoSides side;
    ASSERT_TRUE(side.writer.write(Bytes(image), {}));
    ASSERT_TRUE(side.reader.read());
    side.ring.announce(lie);
    EXPECT_FALSE(side.reader.read());
    EXPECT_TRUE(side.reader.broken()) << lie.area << " " << lie.offset << " " << lie.size;
    EXPECT_EQ(side.ring.taken(), 1u) << "what was not read was not taken";
    EXPECT_LE(side.looks, 16);
    ASSERT_TRUE(side.ring.write({}, {}));
    EXPECT_FALSE(side.reader.read()) << "a broken ring stays broken";
  }
}

TEST(Bulk, WithoutASourceNothingMayLieBesideTheRing) {
  TwoSides side;
  RingReader reader(*side.reader_memory.control, side.writer_memory);
  ASSERT_TRUE(side.writer.write(Bytes(image), {}));
  EXPECT_FALSE(reader.read());
  EXPECT_TRUE(reader.broken());
}

TEST(Bulk, WhatWasHandedUpDoesNotChange) {
  TwoSides side;
  const Bytes sent = packet(image, 9);
  ASSERT_TRUE(side.writer.write(sent, {}));
  const auto got = side.reader.read();
  ASSERT_TRUE(got);
  std::memset(side.areas.made[0]->data(), 0xee, image);
  EXPECT_TRUE(std::ranges::equal(*got, sent));
}

TEST(Bulk, NothingIsLostBetweenTwoThreadsBesideAThirdThatBeats) {
  TwoSides side;
  constexpr std::uint64_t count = 400;
  std::atomic<bool> done{false};
  std::thread beating([&] {
    while (!done.load()) {  // so often that it is given back between two packets now and then
      side.writer.beat();
      std::this_thread::yield();
    }
  });
  const auto size_of = [](std::uint64_t i) {
    return i % 3 == 0 ? std::size_t{8} : std::size_t{20'000} + (i * 7919) % 300'000;
  };
  std::thread writing([&] {
    for (std::uint64_t i = 0; i < count; ++i) {
      const Bytes body(size_of(i), static_cast<std::byte>(i));
      const bool large = body.size() > largest_ring_packet;
      while (!(large ? side.writer.write({}, body) : side.ring.write({}, body))) {
        std::this_thread::yield();
      }
    }
  });
  for (std::uint64_t i = 0; i < count;) {
    const auto got = side.reader.read();
    if (!got) {
      ASSERT_FALSE(side.reader.broken());
      side.source.rest();
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(got->size(), size_of(i));
    ASSERT_TRUE(
        std::ranges::all_of(*got, [&](std::byte b) { return b == static_cast<std::byte>(i); }));
    ++i;
  }
  writing.join();
  done.store(true);
  beating.join();
}

}  // namespace
}  // namespace gecos::media
