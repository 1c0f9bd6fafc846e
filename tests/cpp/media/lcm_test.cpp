// What is lcm's own: its bytes, its addresses, and strangers on its ports.

#include <gtest/gtest.h>

#include <random>

#include "gecos/media/lcm.hpp"
#include "gecos/media/lcm/datagram.hpp"
#include "gecos/media/lcm/inbox.hpp"
#include "gecos/media/lcm/port.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

TEST(LcmDatagram, TheHeaderComesBackAndIsBigEndian) {
  const DatagramHeader header{.kind = DatagramKind::Packet,
                              .reply_port = 0x1234,
                              .server = 0x0102030405060708,
                              .client = 9,
                              .number = 10};
  std::array<std::byte, DatagramHeader::bytes> bytes;
  header.write(bytes);
  EXPECT_EQ(bytes[4], std::byte{0x12});
  EXPECT_EQ(bytes[8], std::byte{0x01});
  EXPECT_EQ(bytes[31], std::byte{10});
  const auto read = DatagramHeader::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->kind, header.kind);
  EXPECT_EQ(read->reply_port, header.reply_port);
  EXPECT_EQ(read->server, header.server);
  EXPECT_EQ(read->client, header.client);
  EXPECT_EQ(read->number, header.number);
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
  const SharedStream stream{.id = 1, .largest = 2, .depth = 3, .port = 4, .channel = 5};
  std::array<std::byte, SharedStream::bytes> bytes;
  stream.write(bytes);
  const auto read = SharedStream::read(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->channel, 5u);
  EXPECT_EQ(read->depth, 3u);
  EXPECT_FALSE(SharedStream::read(ByteView(bytes).first(SharedStream::bytes - 1)));
  bytes[8] = bytes[9] = std::byte{0};
  EXPECT_FALSE(SharedStream::read(bytes)) << "a stream that keeps nothing";
}

TEST(LcmAddress, ReadsWhatItWrites) {
  const LcmAddress address{"239.255.76.67", 20017, "GO0123456789abcdef"};
  EXPECT_EQ(address.to_string(), "lcm:239.255.76.67:20017/GO0123456789abcdef");
  const auto read = LcmAddress::parse(address.to_string());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->group, address.group);
  EXPECT_EQ(read->port, address.port);
  EXPECT_EQ(read->channel, address.channel);
}

TEST(LcmAddress, RefusesWhatIsNone) {
  for (const char* wrong :
       {"", "lcm:", "lcm:239.255.76.67", "lcm:239.255.76.67:1", "lcm:239.255.76.67:1/",
        "lcm:239.255.76.67:0/X", "lcm:239.255.76.67:70000/X", "lcm:239.255.76.67:1x/X", "lcm::1/X",
        "lcm:239.255.76.67?ttl=255&x:1/X", "shm:/run/x.sock"}) {
    EXPECT_FALSE(LcmAddress::parse(wrong)) << wrong;
  }
  EXPECT_FALSE(LcmAddress::parse("lcm:239.255.76.67:1/" + std::string(64, 'X')));
}

TEST(LcmInbox, BoundsItsMemoryAndCountsWhatItDropped) {
  LcmInbox inbox;
  const Bytes body(1024);
  const std::size_t fits = LcmInbox::most_bytes / body.size();
  for (std::size_t i = 0; i < fits + 10; ++i) inbox.take({.kind = DatagramKind::Packet}, body);
  EXPECT_EQ(inbox.dropped(), 10u);
  Bytes packet;
  ASSERT_TRUE(inbox.pop(packet));
  inbox.take({.kind = DatagramKind::Packet}, body);
  EXPECT_EQ(inbox.dropped(), 10u);
  for (std::size_t i = 0; i < LcmInbox::most_packets; ++i) {
    inbox.take({.kind = DatagramKind::Packet}, {});
  }
  EXPECT_GT(inbox.dropped(), 10u) << "empty packets take memory too";
}

class LcmStrangers : public testing::Test {
 protected:
  LcmStrangers()
      : door_(medium_->listen("RX90", false).value()),
        client_(std::move(*medium_->connect(door_->address()))),
        server_(wait_for_client(*door_), door_.get()),
        where_(LcmAddress::parse(door_->address()).value()),
        stranger_(LcmPort::open({}, where_.port).value()) {}

  const std::unique_ptr<Medium> medium_ = make_lcm();
  const std::unique_ptr<Acceptor> door_;
  End client_;
  End server_;
  const LcmAddress where_;
  const std::unique_ptr<LcmPort> stranger_;
};

TEST_F(LcmStrangers, GarbageOnAnObjectsChannelMakesNoLinkAndStopsNothing) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 500; ++i) {
    Bytes garbage(random() % 100);
    for (std::byte& byte : garbage) byte = static_cast<std::byte>(random());
    stranger_->publish(where_.channel, garbage);
  }
  ASSERT_TRUE(client_.send("an honest call"));
  EXPECT_EQ(server_.receive(), "an honest call");
  EXPECT_TRUE(server_.others.empty());
}

TEST_F(LcmStrangers, AnotherChannelOfThePortIsNotHeard) {
  Bytes hello(DatagramHeader::bytes);
  DatagramHeader{.kind = DatagramKind::Hello, .reply_port = 20000, .client = 1}.write(
      std::span(hello).first<DatagramHeader::bytes>());
  stranger_->publish("GOsomebodyelse", hello);
  ASSERT_TRUE(client_.send("an honest call"));
  EXPECT_EQ(server_.receive(), "an honest call");
  EXPECT_TRUE(server_.others.empty());
}

TEST_F(LcmStrangers, ADatagramForAnEarlierLifeOfTheServerIsIgnored) {
  Bytes late(DatagramHeader::bytes);
  DatagramHeader{.kind = DatagramKind::Packet, .reply_port = 20000, .server = 12345, .client = 1}
      .write(std::span(late).first<DatagramHeader::bytes>());
  stranger_->publish(where_.channel, late);
  ASSERT_TRUE(client_.send("an honest call"));
  EXPECT_EQ(server_.receive(), "an honest call");
  EXPECT_TRUE(server_.others.empty()) << "it would run a command of a session that has ended";
}

TEST_F(LcmStrangers, AClientWhoseHelloWasLostIsMetByItsFirstPacket) {
  Bytes first(DatagramHeader::bytes);
  DatagramHeader{.kind = DatagramKind::Packet, .reply_port = 20000, .client = 77, .number = 1}
      .write(std::span(first).first<DatagramHeader::bytes>());
  stranger_->publish(where_.channel, first);
  auto link = wait_for_client(*door_);
  ASSERT_NE(link, nullptr);
  EXPECT_EQ(link->peer().description, "239.255.76.67:20000, not authenticated");
  EXPECT_FALSE(link->peer().uid);
  End met(std::move(link), door_.get());
  EXPECT_EQ(met.receive(), "");
}

TEST_F(LcmStrangers, AStreamThatWasRepeatedOrOvertakenNeverGoesBack) {
  const auto writer = door_->make_stream(100, 4);
  ASSERT_TRUE(server_.link->share(1, *writer));
  const auto reader = client_.wait_for_stream(1);
  ASSERT_NE(reader, nullptr);
  ASSERT_TRUE(writer->publish(bytes_of("one"), 1));
  ASSERT_TRUE(writer->publish(bytes_of("two"), 2));
  StreamSample sample;
  ASSERT_TRUE(client_.wait([&] { return reader->latest(1, sample); }));
  // Another reader opens it, so the last sample goes out again.
  const auto again = client_.link->open_stream(1);
  ASSERT_NE(again, nullptr);
  StreamSample same;
  while (!again->latest(0, same)) {
    std::vector<int> both(client_.link->descriptors().begin(), client_.link->descriptors().end());
    both.insert(both.end(), door_->descriptors().begin(), door_->descriptors().end());
    ASSERT_NE(sleep_on(both, too_late()), Wake::TimedOut);
    server_.link->receive();
    client_.link->disarm();
  }
  EXPECT_EQ(same.sequence, 2u);
  EXPECT_FALSE(reader->latest(2, sample));
  EXPECT_FALSE(reader->next(2, sample));
}

}  // namespace
}  // namespace gecos::media
