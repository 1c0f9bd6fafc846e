// What is lcm's own: its bytes, its addresses, its clocks and bounds.
#include "gecos/media/lcm/lcm.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>

#include "gecos/crypto/handshake_initiator.hpp"
#include "gecos/media/lcm/port.hpp"
#include "gecos/media/sealed/datagram.hpp"
#include "gecos/media/sealed/receive_queue.hpp"
#include "gecos/media/sealed/stream.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

TEST(LcmDatagram, TheHeaderComesBackAndIsBigEndian) {
  const DatagramHeader header{
      .kind = DatagramKind::First, .reply_port = 0x1234, .client = 0x0102030405060708};
  std::array<std::byte, DatagramHeader::bytes> bytes;
  header.write(bytes);
  EXPECT_EQ(bytes[4], std::byte{0x12});
  EXPECT_EQ(bytes[8], std::byte{0x01});
  EXPECT_EQ(bytes[15], std::byte{0x08});
  const auto read = DatagramHeader::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->kind, header.kind);
  EXPECT_EQ(read->reply_port, header.reply_port);
  EXPECT_EQ(read->client, header.client);
}

TEST(LcmDatagram, WhatIsSealedSaysWhatItIs) {
  std::array<std::byte, InnerHeader::bytes> bytes;
  InnerHeader{InnerKind::Opened, 258, 0x0102}.write(bytes);
  EXPECT_EQ(bytes[7], std::byte{1});
  EXPECT_EQ(bytes[8], std::byte{2});
  const auto read = InnerHeader::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->kind, InnerKind::Opened);
  EXPECT_EQ(read->number, 258u);
  EXPECT_EQ(read->sent_ns, 0x0102);
  EXPECT_FALSE(InnerHeader::read(ByteView(bytes).first(InnerHeader::bytes - 1)));
  for (const std::byte wrong : {std::byte{0}, std::byte{10}, std::byte{0xff}}) {
    bytes[0] = wrong;
    EXPECT_FALSE(InnerHeader::read(bytes));
  }
}

TEST(LcmDatagram, AnInwardStreamComesBackAndIsChecked) {
  std::array<std::byte, InwardShare::bytes> bytes;
  InwardShare{.id = 7, .largest = 300, .depth = 4}.write(bytes);
  const auto read = InwardShare::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->id, 7u);
  EXPECT_EQ(read->largest, 300u);
  EXPECT_EQ(read->depth, 4u);
  EXPECT_FALSE(InwardShare::read(ByteView(bytes).first(InwardShare::bytes - 1)));
  InwardShare{.id = 7, .largest = 300, .depth = 0}.write(bytes);
  EXPECT_FALSE(InwardShare::read(bytes)) << "a stream that keeps nothing";

  std::array<std::byte, InwardSampleHead::bytes> head;
  InwardSampleHead{.id = 7, .stamp_ns = -5}.write(head);
  const auto sample = InwardSampleHead::read(head);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->id, 7u);
  EXPECT_EQ(sample->stamp_ns, -5);
  EXPECT_FALSE(InwardSampleHead::read(ByteView(head).first(InwardSampleHead::bytes - 1)));
}

TEST(LcmDatagram, StrangersBytesAreNoDatagram) {
  std::array<std::byte, DatagramHeader::bytes> bytes;
  DatagramHeader{}.write(bytes);
  ASSERT_TRUE(DatagramHeader::read(bytes));
  EXPECT_FALSE(DatagramHeader::read(ByteView(bytes).first(DatagramHeader::bytes - 1)));
  EXPECT_FALSE(DatagramHeader::read({}));
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
    auto wrong = bytes;
    wrong[at] = std::byte{0xff};
    EXPECT_FALSE(DatagramHeader::read(wrong)) << at;
  }
}

TEST(LcmDatagram, ASharedStreamComesBackAndIsChecked) {
  const crypto::StreamSealer sealer;
  const SharedStream stream{
      .id = 1, .largest = 2, .depth = 3, .port = 4, .channel = 5, .key = sealer.key()};
  std::array<std::byte, SharedStream::bytes> bytes;
  stream.write(bytes);
  const auto read = SharedStream::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->channel, 5u);
  EXPECT_EQ(read->depth, 3u);
  EXPECT_TRUE(std::ranges::equal(read->key.key.bytes(), sealer.key().key.bytes()));
  EXPECT_EQ(read->key.signer, sealer.key().signer);
  EXPECT_FALSE(SharedStream::read(ByteView(bytes).first(SharedStream::bytes - 1)));
  bytes[8] = bytes[9] = std::byte{0xff};
  EXPECT_FALSE(SharedStream::read(bytes)) << "a stream that keeps more than any of ours";
  bytes[8] = bytes[9] = std::byte{0};
  EXPECT_FALSE(SharedStream::read(bytes)) << "a stream that keeps nothing";
}

TEST(SealedAddress, ReadsWhatItWrites) {
  SealedAddress address{"lcm", "239.255.76.67", 20017, "GO0123456789abcdef", std::nullopt};
  EXPECT_EQ(address.to_string(), "lcm:239.255.76.67:20017/GO0123456789abcdef");
  EXPECT_FALSE(SealedAddress::parse(address.to_string()).value().key);
  address.key = crypto::KeyPair::draw().public_key;
  EXPECT_EQ(address.place(), "lcm:239.255.76.67:20017/GO0123456789abcdef");
  EXPECT_EQ(address.to_string(), address.place() + "#" + address.key->to_string());
  const auto read = SealedAddress::parse(address.to_string());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->medium, address.medium);
  EXPECT_EQ(read->network, address.network);
  EXPECT_EQ(read->port, address.port);
  EXPECT_EQ(read->channel, address.channel);
  EXPECT_EQ(read->key, address.key);
}

TEST(SealedAddress, RefusesWhatIsNone) {
  for (const char* wrong :
       {"", "lcm:", "lcm:239.255.76.67", "lcm:239.255.76.67:1", "lcm:239.255.76.67:1/",
        "lcm:239.255.76.67:0/X", "lcm:239.255.76.67:70000/X", "lcm:239.255.76.67:1x/X", "lcm::1/X",
        "lcm:239.255.76.67?ttl=255&x:1/X", "lcm:239.255.76.67:1/X#", "lcm:239.255.76.67:1/X#12ab",
        "a medium:here:1/X", ":here:1/X", "shm:/run/x.sock"}) {
    EXPECT_FALSE(SealedAddress::parse(wrong)) << wrong;
  }
  EXPECT_FALSE(SealedAddress::parse("lcm:239.255.76.67:1/" + std::string(64, 'X')));
}

TEST(SendersClock, TellsHowLongPacketsWaited) {
  SendersClock clock;
  const TimePoint begun{std::chrono::hours(5)};
  using namespace std::chrono_literals;
  const auto sent = [](Duration after) { return (std::chrono::hours(99) + after).count(); };
  EXPECT_EQ(clock.age(sent(0ms), begun + 3ms), 0ms) << "nothing is known yet";
  EXPECT_EQ(clock.age(sent(10ms), begun + 11ms), 0ms) << "2 ms quicker than the first";
  EXPECT_EQ(clock.age(sent(20ms), begun + 21ms), 0ms);
  const Duration waited = clock.age(sent(30ms), begun + 3031ms);
  EXPECT_LE(waited, 3s);
  EXPECT_GE(waited, 3s - 2ms) << "less what the clocks may have drifted meanwhile";
  EXPECT_EQ(clock.age(sent(3100ms), begun + 3101ms), 0ms);
}

TEST(SendersClock, GoesAlongWithAClockThatIsSlow) {
  SendersClock clock;
  for (int seconds = 0; seconds < 100'000; ++seconds) {
    const Duration here = std::chrono::seconds(seconds);
    ASSERT_EQ(clock.age((here - here / 5000).count(), TimePoint{here}), Duration::zero())
        << seconds;
  }
}

TEST(SendersClock, GivesWithTheQuickestAnswerAnUpperBoundOfAnAge) {
  std::mt19937_64 random(7);
  const auto way = [&] { return std::chrono::microseconds(100 + random() % 5000); };
  const Duration ahead = std::chrono::hours(99);  // the sender's clock
  SendersClock clock;
  Duration quickest = std::chrono::seconds(1);
  for (int i = 1; i <= 1000; ++i) {
    const Duration now = i * std::chrono::milliseconds(100);
    const Duration there = way();
    const Duration back = way();
    clock.age((ahead + now - back).count(), TimePoint{now});  // the answer, read at `now`
    quickest = std::min(quickest, there + back);
    const Duration age = std::chrono::microseconds(random() % 1'000'000);
    const Duration measured = ahead + now - age;
    const Duration told = now - (measured + *clock.difference() - quickest);
    ASSERT_GE(told, age);
    ASSERT_LE(told, age + quickest);
  }
}

TEST(SendersClock, IsNotUpsetByAnyNumber) {
  SendersClock clock;
  for (const std::int64_t sent : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1},
                                  std::int64_t{0}, std::numeric_limits<std::int64_t>::max()}) {
    clock.age(sent, TimePoint{});
    clock.age(sent, TimePoint::max());
  }
}

TEST(ReceiveQueue, BoundsItsMemoryAndCountsWhatItDropped) {
  ReceiveQueue queue;
  const auto frame_of = [](std::size_t size) {
    Bytes frame(crypto::Sealer::overhead + InnerHeader::bytes + size);
    InnerHeader{InnerKind::Packet, 1}.write(
        std::span(frame).subspan<crypto::Sealer::text_at, InnerHeader::bytes>());
    return frame;
  };
  const std::size_t fits = ReceiveQueue::most_bytes / frame_of(1024).size();
  for (std::size_t i = 0; i < fits + 10; ++i) queue.put(frame_of(1024), TimePoint{});
  EXPECT_EQ(queue.dropped(), 10u);
  ReceiveQueue::Packet packet;
  ASSERT_TRUE(queue.pop(packet));
  EXPECT_EQ(ReceiveQueue::packet_in(packet.frame).size(), 1024u);
  queue.put(frame_of(1024), TimePoint{});
  EXPECT_EQ(queue.dropped(), 10u);
  for (std::size_t i = 0; i < ReceiveQueue::most_packets; ++i) queue.put(frame_of(0), TimePoint{});
  EXPECT_GT(queue.dropped(), 10u) << "empty packets take memory too";
}

TEST(ReceiveQueue, AHeartbeatCountsAsReadAfterThePacketsBeforeItWereHandled) {
  ReceiveQueue queue;
  const auto put = [&](InnerKind kind) {
    Bytes frame(crypto::Sealer::overhead + InnerHeader::bytes);
    InnerHeader{kind, 1}.write(
        std::span(frame).subspan<crypto::Sealer::text_at, InnerHeader::bytes>());
    queue.put(std::move(frame), TimePoint{});
  };
  ReceiveQueue::Packet packet;
  put(InnerKind::Beat);
  EXPECT_EQ(queue.beats_read(), 1u) << "nothing came before it";
  put(InnerKind::Packet);
  put(InnerKind::Beat);
  EXPECT_EQ(queue.beats(), 3u);
  EXPECT_EQ(queue.beats_read(), 1u) << "the packet is not read";
  ASSERT_TRUE(queue.pop(packet));
  EXPECT_EQ(queue.beats_read(), 1u) << "its reader may still handle it";
  put(InnerKind::Beat);
  EXPECT_EQ(queue.beats_read(), 1u);
  EXPECT_FALSE(queue.pop(packet));
  EXPECT_EQ(queue.beats_read(), 4u);
  put(InnerKind::Beat);
  EXPECT_EQ(queue.beats_read(), 5u) << "nobody has to ask while nothing is there";
}

TEST(LcmPort, RunsOutOfDescriptorsWithAWord) {
  rlimit usual{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &usual), 0);
  const auto used = static_cast<rlim_t>(open_descriptors());
  int refused = 0;
  for (rlim_t spare = 0; spare < 24; ++spare) {
    const rlimit few{used + spare, usual.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
    auto port = LcmPort::open({}, draw_port());
    auto heard = port ? (*port)->subscribe("X", [](ByteView) {})
                      : tl::expected<std::uint64_t, MediumError>{};
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &usual), 0);
    if (port && heard) continue;
    const std::string text = port ? heard.error().text : port.error().text;
    EXPECT_NE(text.find("Too many open files"), std::string::npos) << text;
    ++refused;
  }
  EXPECT_GT(refused, 10);
}

TEST(LcmPort, AdvisesNoRouteToWhatIsNoMulticastGroup) {
  LcmOptions options;
  options.group = "1.2.3.4";
  const auto port = LcmPort::open(options, 20017);
  ASSERT_FALSE(port);
  EXPECT_NE(port.error().text.find("1.2.3.4 is not a multicast group"), std::string::npos);
  EXPECT_EQ(port.error().text.find("ip route"), std::string::npos) << port.error().text;
}

}  // namespace
}  // namespace gecos::media
