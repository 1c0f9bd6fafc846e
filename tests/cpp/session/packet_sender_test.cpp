// The packets that wait for a client that does not read.
#include "gecos/session/server/packet_sender.hpp"

#include <gtest/gtest.h>

#include "gecos/session/protocol/packets.hpp"
#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

/// A session's sender whose client does not read.
class PacketSenderTest : public ::testing::Test {
 protected:
  PacketSenderTest() {
    connection_.carry(32 << 20);
    connection_.full = true;
  }
  /// The bytes that the client gets when it reads at last.
  std::size_t bytes_that_waited() {
    connection_.full = false;
    sender_.flush();
    std::size_t bytes = 0;
    for (const Bytes& packet : connection_.sent) bytes += packet.size();
    return bytes;
  }

  TestConnection connection_{true};
  PacketSender sender_{connection_};
};

TEST_F(PacketSenderTest, ResultsThatNobodyReadsTakeABoundedMemory) {
  const Bytes result(4 << 20);
  for (int i = 0; i < 100; ++i) sender_.reply({}, result, nullptr);
  EXPECT_FALSE(sender_.overrun()) << "each of them is answered";
  EXPECT_LE(bytes_that_waited(), std::size_t{129} << 20);
  EXPECT_EQ(connection_.sent.size(), 100u);
}

TEST_F(PacketSenderTest, FailuresThatNobodyReadsTakeABoundedMemory) {
  const Failure failure{Detail::Rejected, std::string(4 << 20, 'x'), {}, {}};
  for (int i = 0; i < 100; ++i) sender_.reply({}, failure, nullptr);
  EXPECT_FALSE(sender_.overrun()) << "each of them is answered";
  EXPECT_LE(bytes_that_waited(), std::size_t{129} << 20);
  EXPECT_EQ(connection_.sent.size(), 100u);
}

TEST_F(PacketSenderTest, AClientThatAsksForRepliesAgainAndReadsNothingIsLost) {
  const Bytes result(4 << 20);
  for (int i = 0; i < 100; ++i) sender_.reply_again({}, result, nullptr);
  EXPECT_TRUE(sender_.overrun());
  EXPECT_LE(bytes_that_waited(), std::size_t{256} << 20);
}

}  // namespace
}  // namespace gecos::session
